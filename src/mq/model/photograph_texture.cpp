#include "mq/model/photograph_texture.h"

#include <fmt/format.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/base/words.h"
#include "mq/draw/align_photographs.h"
#include "mq/io/file_print.h"
#include "mq/model/detail/photograph_labels.h"
#include "mq/model/detail/photograph_light.h"
#include "mq/model/detail/photograph_looks.h"
#include "mq/model/detail/photograph_pictures.h"
#include "mq/model/detail/photograph_reader.h"
#include "mq/model/detail/photograph_records.h"
#include "mq/model/photograph_costs.h"
#include "mq/model/photographs.h"
#include "mq/views/tones.h"

namespace mq {
namespace {

constexpr double opaque = 0.5;  ///< the least alpha of a photograph that shows something

}  // namespace

/// What is known of one set of photographs.
struct PhotographTexturing::Work {
  Work(const TexturedModel& model, const TextureSignal& from, std::span<const Photograph> given,
       const PhotographTextureOptions& wanted, Messages& messages, const Progress& progress)
      : signal(from),
        photographs(given),
        options(wanted),
        reader(given, wanted.unreadable, messages),
        values(model, from),
        projector(model.surface, from.space().positions(), model.atlas->texel_spacing(), progress),
        patches(make_patches(from.space().texels(), from.space().stiffness(), wanted.patch)),
        cameras(given.size()),
        moved(given.size(), 0.0),
        exposed(no_exposures(int(given.size()))),
        pixels_per_texel(given.size(), 0.0) {}

  /// Weighted means per unknown; of none where they are not asked for.
  struct Means {
    Signal sum;
    Vector weight;

    Means(Eigen::Index unknowns, int channels)
        : sum(Signal::Zero(unknowns, channels)), weight(Vector::Zero(unknowns)) {}

    /// Where there is one, it becomes the value of what has the region `number`, and what lies beyond its border.
    void put(int number, PhotographTexture& result) const {
      if (weight.size() == 0) return;
      for (Eigen::Index i = 0; i < weight.size(); ++i)
        if (weight[i] > 0 && result.regions[std::size_t(i)] == number) result.values.row(i) = sum.row(i) / weight[i];
      for (const int i : result.beyond.unknowns_of(number))
        if (weight[i] > 0) result.beyond.put(number, i, sum.row(i) / weight[i]);
    }
  };

  void align(const Looks& looks, Messages& messages, const Progress& progress) {
    const PhotographCosts costs = photograph_costs(photographs, signal.space().size(), options);
    const double reading = costs.read_to_align / costs.aligned();
    constexpr double most_pixels = 1e6, most_of_all = 1e8;
    constexpr std::size_t most_places = 60'000;
    std::vector<int> places;
    for (std::size_t k = 0; k < looks.places.size(); k += 1 + looks.places.size() / most_places)
      places.push_back(looks.places[k]);
    std::vector<AlignedPhotograph> aligned;
    std::vector<std::vector<float>> details;  ///< of the places of each
    for (std::size_t v = 0; v < photographs.size(); ++v) {
      const Progress step = step_of(v, reading, progress);
      AlignedPhotograph& one = aligned.emplace_back();
      one.camera = cameras[v];
      const std::string name = fmt::format("align{}", v);
      const std::uint64_t source = print_of(v);
      if (const auto record = store.find(name, source)) {
        read_to_align(*record, one, details.emplace_back());
        continue;
      }
      const auto photograph = reader.read(v);
      if (!photograph) {
        one.grey = Image<float>(1, 1, 1), details.emplace_back();
        continue;
      }
      const double fine = projector.pixels_per_spacing(photograph->camera, places);
      one.grey = picture_to_align(photograph->light, fine,
                                  std::min(most_pixels, most_of_all / double(photographs.size())));
      const std::vector<double> shown = projector.confidences(one.camera, places, options.projection, step);
      for (std::size_t k = 0; k < shown.size(); ++k)
        if (shown[k] > 0) one.places.push_back(places[k]), one.weights.push_back(float(shown[k]));
      const double step_of_grey = fine * one.grey.width() / photograph->light.width();
      const Image<float> squares = reduced(squared_detail(one.grey, step_of_grey), 2);
      const Signal at_places = projector.sampled(one.camera, squares, one.places);
      details.emplace_back(at_places.data(), at_places.data() + at_places.size());
      if (store.keeps()) keep(name, source, record_to_align(one, details.back()), int(v) + 1, "read to be aligned", messages);
    }
    weigh_by_sharpness(details, projector.places().size(), aligned);
    align_photographs(projector.places(), aligned, progress.step("align", 1 - reading));
    for (std::size_t v = 0; v < photographs.size(); ++v) {
      cameras[v] = aligned[v].camera;
      moved[v] = aligned[v].moved;
    }
    if (store.keeps())
      keep("aligned", print_of_all(), record_of_poses(cameras, moved), int(photographs.size()), "aligned", messages);
  }

  /// Puts it and says so.
  void keep(const std::string& name, std::uint64_t source, std::span<const std::byte> record, int done,
            const char* what, Messages& messages) const {
    store.put(name, source, record);
    messages.safe(fmt::format("{} of {} are {} and kept in {}", done,
                              counted(std::ssize(photographs), "photograph"), what, options.resume.string()));
  }

  /// Of what is kept of them; 0 where nothing is.
  std::uint64_t print_of(std::size_t view) const {
    return store.keeps() ? print_of_photographs(photographs.subspan(view, 1)) : 0;
  }
  std::uint64_t print_of_all() const { return store.keeps() ? print_of_photographs(photographs) : 0; }

  /// Aligned as they were before, else now.
  void find_poses(const Looks& looks, Messages& messages, const Progress& progress) {
    for (std::size_t v = 0; v < photographs.size(); ++v) cameras[v] = reader.camera(v);
    if (!options.align) return;
    if (const auto record = store.find("aligned", print_of_all()))
      read_poses(*record, cameras, moved);
    else
      align(looks, messages, progress);
    for (std::size_t v = 0; v < photographs.size(); ++v) {
      constexpr double far = 10;
      if (moved[v] > far)
        messages.warning(fmt::format("{}: alignment moved it by {:.0f} pixels: check its camera",
                                      photographs[v].picture.string(), moved[v]));
    }
  }

  void look(const Looks& looks, Messages& messages, const Progress& progress) {
    std::vector<std::vector<Observations::OfPatch>> of_view(photographs.size());
    for (std::size_t v = 0; v < photographs.size(); ++v) {
      const Progress step = step_of(v, 1, progress);
      pixels_per_texel[v] = projector.pixels_per_spacing(cameras[v], looks.places);
      const std::string name = fmt::format("look{}", v);
      const std::uint64_t source = store.keeps() ? print_of_aligned(photographs[v], cameras[v]) : 0;
      if (const auto record = store.find(name, source)) {
        of_view[v] = StoredReader(*record).list<Observations::OfPatch>();
        for (Observations::OfPatch& one : of_view[v]) one.observation.view = int(v);
        continue;
      }
      const auto photograph = reader.read(v);
      if (!photograph) continue;
      if (!photograph->remark.empty()) messages.remark(photograph->remark);
      const Image<float> picture = picture_to_look_at(photograph->light, pixels_per_texel[v]);
      const Partial shown = projector.project(cameras[v], picture, looks.places, options.projection, step);
      of_view[v] = observe(looks, shown, projector.places(), cameras[v], int(v));
      if (of_view[v].empty())
        messages.warning(photographs[v].picture.string() + ": shows nothing of the model: check its camera");
      StoredWriter record;
      record.add(of_view[v]);
      if (store.keeps()) keep(name, source, record.bytes, int(v) + 1, "looked at", messages);
    }
    observations = Observations::gather(patches.count(), of_view);
  }

  /// For who asks only whether a photograph shows a place.
  PhotographOptions plain_projection() const {
    PhotographOptions plain = options.projection;
    plain.doubtful = 0;
    return plain;
  }

  void expose() {
    const int count = int(photographs.size());
    if (options.exposure == PhotographExposure::match) exposed = exposures(observations, count);
    if (options.exposure == PhotographExposure::tone) exposed = tones(observations, count);
  }

  void choose(Messages& messages, const Progress& progress) {
    std::vector<LightColour> shown;
    for (const Observation& o : observations.all) shown.push_back(o.colour);
    const auto evened = [&] {
      for (std::size_t k = 0; k < shown.size(); ++k) observations.all[k].colour = shown[k];
      expose();
      even_out(exposed, observations);
    };
    evened();
    if (options.reject_outliers) {
      // What is rejected is found with exposures, of which it is to have no part.
      reject(patches, options.rejection, observations);
      evened();
      reject(patches, options.rejection, observations);
      const std::vector<char> strange = strangers(photographs, observations, messages);
      if (std::ranges::count(strange, 1) > 0) {
        // Nor are they to speak for or against the others.
        for (Observation& o : observations.all) o.rejected = strange[std::size_t(o.view)];
        evened();
        ObservationsOfOthers others(observations, strange);
        reject(patches, options.rejection, others.observations);
        for (std::size_t k = 0; k < others.places.size(); ++k)
          observations.all[others.places[k]].rejected = others.observations.all[k].rejected;
        take_strangers_alone(strange, observations);
      }
    }
    pool_details(patches, observations);
    ChooseOptions choice = options.choice;
    if (!options.before.empty()) choice.before = views_before(patches, options.before, int(photographs.size()));
    chosen = choose_views(patches, observations, choice, progress);
  }

  /// The photograph as colours are taken from it, in the signal's values: at about two pixels per texel, between which
  /// they are interpolated, so that a texel is a mean over about its own size. Nothing where it is left out.
  std::optional<Image<float>> picture(std::size_t view) {
    auto photograph = reader.read(view);
    if (!photograph) return std::nullopt;
    photograph->light = reduced(photograph->light, std::floor(pixels_per_texel[view] / 2 + 0.25));
    return values.of(*photograph, exposed, int(view));
  }

  /// Fills in `result.values` and `result.beyond`; what is masked by alpha, or cannot be read any more, becomes unseen.
  void take_colours(PhotographTexture& result, const Progress& progress) {
    result.values = Signal::Zero(std::ssize(result.labels), signal.channels());
    Means means(options.blend == PhotographBlend::mean ? std::ssize(result.labels) : 0, signal.channels());
    std::vector<std::vector<int>> own(photographs.size());
    for (std::size_t i = 0; i < result.labels.size(); ++i)
      if (result.labels[i] != unseen) own[std::size_t(result.labels[i])].push_back(int(i));
    Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(signal.channels());
    const std::uint64_t source = print_of_all();
    for (std::size_t v = 0; v < photographs.size(); ++v) {
      const Progress step = step_of(v, 1, progress);
      const std::span<const int> beyond = result.beyond.unknowns_of(int(v));
      result.views[v].texels = std::ssize(own[v]);
      const std::vector<int> to_blend = means.weight.size() > 0 ? agreed_texels(int(v)) : std::vector<int>();
      if (own[v].empty() && beyond.empty() && to_blend.empty()) continue;
      const std::optional<TakenColours> taken = colours_of(v, source, own[v], beyond, to_blend, means, step);
      const Signal own_values = taken ? values.with_alpha(taken->own) : Signal();
      const bool masked = taken && has_alpha(int(taken->own.cols()));
      for (std::size_t k = 0; k < own[v].size(); ++k) {
        if (!taken || (masked && taken->own(Eigen::Index(k), taken->own.cols() - 1) < opaque)) {
          result.labels[std::size_t(own[v][k])] = result.regions[std::size_t(own[v][k])] = unseen;
          --result.views[v].texels;
          continue;
        }
        result.values.row(own[v][k]) = own_values.row(Eigen::Index(k));
        sum += own_values.row(Eigen::Index(k));
      }
      if (!taken) continue;
      const Signal other_values = values.with_alpha(taken->beyond.values);
      // Beyond the border of what is rejected its gradients are not believed either.
      for (std::size_t k = 0; k < beyond.size(); ++k)
        if (taken->beyond.confidence[k] > 0 && !rejected_at(beyond[k], int(v)))
          result.beyond.put(int(v), beyond[k], other_values.row(Eigen::Index(k)));
    }
    means.put(int(photographs.size()), result);
    const std::int64_t seen = std::ssize(result.labels) - std::ranges::count(result.labels, unseen);
    if (seen == 0) return;
    for (std::size_t i = 0; i < result.labels.size(); ++i)
      if (result.labels[i] == unseen) result.values.row(Eigen::Index(i)) = sum / double(seen);
  }

  /// Of one photograph, which is not read where they are kept with this print of all. What all texels of many photographs show is more than
  /// should be kept: with means they are read again. Nothing where it cannot be read and is left out.
  std::optional<TakenColours> colours_of(std::size_t v, std::uint64_t source, std::span<const int> own,
                                         std::span<const int> beyond, std::span<const int> to_blend, Means& means,
                                         const Progress& progress) {
    TakenColours taken;
    StoredWriter asked;
    if (store.keeps()) asked.add(own), asked.add(beyond), asked.add(exposed.gains[v]), asked.add(exposed.exponents[v]);
    const std::uint64_t print = fingerprint(asked.bytes);
    const std::string name = fmt::format("colours{}", v);
    if (const auto record = to_blend.empty() ? store.find(name, source) : std::nullopt;
        record && read_colours(*record, print, taken))
      return taken;
    const std::optional<Image<float>> shown = picture(v);
    if (!shown) return std::nullopt;
    if (!to_blend.empty()) {
      Partial part = projector.project(cameras[v], *shown, to_blend, options.projection, progress);
      part.values = values.with_alpha(part.values);
      add_to_means(int(v), part, to_blend, [](std::size_t k) { return k; }, means);
    }
    taken.own = projector.sampled(cameras[v], *shown, own);
    taken.beyond = projector.project(cameras[v], *shown, beyond, plain_projection(), progress);
    if (store.keeps() && to_blend.empty()) store.put(name, source, record_of_colours(print, taken));
    return taken;
  }

  /// Whether a photograph is rejected on the patch of a texel, where another is not.
  bool rejected_at(int texel, int view) const {
    const int patch = patches.of[std::size_t(texel)];
    return observations.number_of(patch, view) >= 0 && !agrees(patch, view);
  }

  /// Whether a photograph shows a patch as is agreed on.
  bool agrees(int patch, int view) const {
    const std::int64_t k = observations.number_of(patch, view);
    return k >= 0 && !observations.all[std::size_t(k)].rejected;
  }

  /// Texels of the patches that a photograph shows as others do.
  std::vector<int> agreed_texels(int view) const {
    std::vector<int> texels;
    for (int p = 0; p < patches.count(); ++p) {
      if (agrees(p, view))
        texels.insert(texels.end(), patches.members.begin() + patches.offsets[p],
                      patches.members.begin() + patches.offsets[p + 1]);
    }
    return texels;
  }

  /// `row_of(k)`: where in the part the k-th texel is.
  void add_to_means(int view, const Partial& part, std::span<const int> texels, const auto& row_of,
                    Means& means) const {
    int patch = -1;
    double sharp = 1;
    for (std::size_t k = 0; k < texels.size(); ++k) {
      const int i = texels[k];
      if (const int p = patches.of[std::size_t(i)]; p != patch) {
        patch = p;
        sharp = sharpness(observations.of(p))[std::size_t(observations.number_of(p, view) - observations.offsets[p])];
      }
      const std::size_t row = row_of(k);
      means.sum.row(i) += sharp * part.confidence[row] * part.values.row(Eigen::Index(row));
      means.weight[i] += sharp * part.confidence[row];
    }
  }

  /// The part of `share` of the progress that one photograph has.
  Progress step_of(std::size_t view, double share, const Progress& progress) const {
    return progress.step(photographs[view].picture.filename().string(), share / double(photographs.size()));
  }

  const TextureSignal& signal;
  std::span<const Photograph> photographs;
  const PhotographTextureOptions options;
  PhotographReader reader;
  PhotographValues values;
  Projector projector;
  Patches patches;
  Observations observations;             ///< exposures are evened out once there is a choice
  std::vector<int> chosen;               ///< of each patch the number of its observation
  std::vector<PinholeCamera> cameras;    ///< of the pictures as they are
  std::vector<double> moved;             ///< by alignment
  Exposures exposed;
  std::vector<double> pixels_per_texel;
  PhotographStore store;
};

PhotographTexturing::PhotographTexturing(const TexturedModel& model, const TextureSignal& signal,
                                         std::span<const Photograph> photographs,
                                         const PhotographTextureOptions& options, Messages& messages,
                                         const Progress& progress) {
  require(!photographs.empty(), "a texture of photographs needs one at least");
  const PhotographCosts costs = photograph_costs(photographs, signal.space().size(), options);
  const auto part = [&](const char* name, double cost) { return progress.step(name, cost / costs.looked()); };
  work_ = std::make_unique<Work>(model, signal, photographs, options, messages, part("places", costs.places));
  const Looks looks(work_->patches);
  if (!options.resume.empty())
    work_->store = PhotographStore(options.resume,
                                   print_of_setup(model.surface.mesh, work_->projector.places(), signal, options),
                                   messages);
  work_->find_poses(looks, messages, part("align", costs.aligned()));
  work_->look(looks, messages, part("look", costs.look));
  work_->choose(messages, part("choose", costs.choose));
}

PhotographTexturing::~PhotographTexturing() = default;

std::vector<int> PhotographTexturing::labels(std::span<const int> wanted, const Progress& progress) const {
  require(wanted.empty() || std::ssize(wanted) == work_->signal.space().size(),
          fmt::format("a photograph is wanted for each of {} unknowns, found {}", work_->signal.space().size(),
                      wanted.size()));
  const std::vector<std::vector<int>> asked = views_to_ask(work_->patches, work_->observations, work_->chosen);
  std::vector<int> labels(work_->patches.of.size()), all(labels.size());
  std::iota(all.begin(), all.end(), 0);
  PhotographOptions options = work_->plain_projection();
  find_labels(work_->projector, work_->patches, asked, wanted, work_->cameras, options, std::move(all), labels,
              progress.step("all", 0.8));
  // What is filled goes on from what is beside it: that must not be the sky behind the outline.
  std::vector<int> border = beside_unseen(work_->patches, labels);
  std::erase_if(border, [&](int i) {
    return !wanted.empty() && wanted[std::size_t(i)] != unseen && wanted[std::size_t(i)] == labels[std::size_t(i)];
  });
  std::vector<int> surer = labels;
  options.outline *= std::max(1.0, work_->options.projection.doubtful);
  find_labels(work_->projector, work_->patches, asked, {}, work_->cameras, options, border, surer,
              progress.step("borders", 0.2));
  take_surer(work_->patches, border, surer, labels);
  return labels;
}

PhotographTexture PhotographTexturing::make(std::span<const int> wanted, const Progress& progress) const {
  const PhotographBlend blend = work_->options.blend;
  std::vector<int> chosen = labels(wanted, progress.step("what is hidden", 0.3)), regions = chosen;
  if (blend == PhotographBlend::mean)
    for (std::size_t i = 0; i < regions.size(); ++i) {
      const bool by_hand = !wanted.empty() && wanted[i] == regions[i];
      if (regions[i] != unseen && !by_hand) regions[i] = int(work_->photographs.size());
    }
  BeyondBorders beyond(work_->signal.space(), regions, work_->signal.channels());
  PhotographTexture result{.values = {},
                           .labels = std::move(chosen),
                           .regions = std::move(regions),
                           .beyond = std::move(beyond),
                           .offset = {},
                           .falloff = work_->exposed.falloff,
                           .views = std::vector<PhotographTexture::View>(work_->photographs.size()),
                           .seen_by = {}};
  for (std::size_t v = 0; v < result.views.size(); ++v) {
    result.views[v].gain = work_->exposed.gains[v];
    result.views[v].exponent = work_->exposed.exponents[v];
    result.views[v].moved = work_->moved[v];
  }
  count_views(work_->patches, work_->observations, work_->options.rejection, result);
  result.offset = blend == PhotographBlend::detail
                      ? offset(result.labels)
                      : Signal(Signal::Zero(std::ssize(result.labels), work_->signal.channels()));
  work_->take_colours(result, progress.step("colours", 0.7));
  for (std::size_t v = 0; v < result.views.size(); ++v) result.views[v].left_out = work_->reader.why_left_out(v);
  return result;
}

Partial PhotographTexturing::partial(int photograph, const Progress& progress) const {
  const auto view = std::size_t(photograph);
  require(photograph >= 0 && view < work_->photographs.size(),
          fmt::format("found photograph {} of {}", photograph, work_->photographs.size()));
  std::vector<int> all(std::size_t(work_->signal.space().size()));
  std::iota(all.begin(), all.end(), 0);
  const std::optional<Image<float>> picture = work_->picture(view);
  if (!picture)
    return {Signal::Zero(std::ssize(all), work_->signal.channels()), std::vector<double>(all.size(), 0.0)};
  Partial shown =
      work_->projector.project(work_->cameras[view], *picture, all, work_->options.projection, progress);
  shown.values = work_->values.with_alpha(shown.values);
  return shown;
}

Partial PhotographTexturing::mean(std::span<const Partial> partials, std::span<const int> labels) const {
  const auto unknowns = std::size_t(work_->signal.space().size());
  require(partials.size() == work_->photographs.size() && labels.size() == unknowns,
          fmt::format("the mean of {} photographs at {} unknowns needs a part and a label of each, found {} and {}",
                      work_->photographs.size(), unknowns, partials.size(), labels.size()));
  Work::Means means(Eigen::Index(unknowns), work_->signal.channels());
  for (std::size_t v = 0; v < partials.size(); ++v) {
    const std::vector<int> texels = work_->agreed_texels(int(v));
    work_->add_to_means(int(v), partials[v], texels, [&](std::size_t k) { return std::size_t(texels[k]); }, means);
  }
  Partial result{Signal::Zero(Eigen::Index(unknowns), work_->signal.channels()), std::vector<double>(unknowns, 0.0)};
  for (std::size_t i = 0; i < unknowns; ++i) {
    const auto row = Eigen::Index(i);
    result.confidence[i] = means.weight[row];
    if (means.weight[row] > 0)
      result.values.row(row) = means.sum.row(row) / means.weight[row];
    else if (labels[i] != unseen) {
      result.values.row(row) = partials[std::size_t(labels[i])].values.row(row);
      result.confidence[i] = partials[std::size_t(labels[i])].confidence[i];
    }
  }
  return result;
}

Signal PhotographTexturing::offset(std::span<const int> labels) const {
  const Observations& observations = work_->observations;
  Signal result = Signal::Zero(std::ssize(labels), work_->signal.channels());
  // Of each observation its own colour and that which is agreed on, as pixels of a picture.
  std::vector<LightColour> colours(observations.all.size() * 2);
  const std::vector<LightColour> agreed = agreed_in_place_of_own(observations);
  for (std::size_t k = 0; k < agreed.size(); ++k)
    colours[2 * k] = observations.all[k].colour, colours[2 * k + 1] = agreed[k];
  const Signal worked = work_->values.of_colours(colours);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (labels[i] == unseen) continue;
    const Eigen::Index row = 2 * observations.number_of(work_->patches.of[i], labels[i]);
    if (row < 0) continue;
    result.row(Eigen::Index(i)).head(worked.cols()) = worked.row(row + 1) - worked.row(row);
  }
  return result;
}

Signal colours_of_labels(std::span<const int> labels) {
  constexpr double golden_angle = 137.50776;
  Signal colours = Signal::Zero(std::ssize(labels), 3);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (labels[i] == unseen) continue;
    const Colour colour = colour_of(0.55 + 0.3 * (labels[i] % 3) / 2, 0.12, std::fmod(labels[i] * golden_angle, 360));
    for (int c = 0; c < 3; ++c) colours(Eigen::Index(i), c) = colour[std::size_t(c)];
  }
  return colours;
}

}  // namespace mq

#include "mq/model/photograph_texture.h"

#include <fmt/format.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/draw/align_photographs.h"
#include "mq/image/resample.h"
#include "mq/model/detail/photograph_light.h"
#include "mq/model/photographs.h"

namespace mq {
namespace {

constexpr int samples_of_patch = 5;
constexpr double opaque = 0.5;    ///< the least alpha of a photograph that shows something
constexpr int channels_of_look = 5;  ///< red, green, blue, detail, alpha

/// |∇|² of display brightness, per texel, of a picture with `step` pixels per texel.
Image<float> squared_detail(const Image<float>& light, double step) {
  Image<float> grey(light.width(), light.height(), 1), result(light.width(), light.height(), 1);
  parallel_for(light.height(), [&](std::int64_t y) {
    for (int x = 0; x < light.width(); ++x) {
      const auto pixel = light.pixel(x, int(y));
      grey(x, int(y)) = float(srgb_from_linear((pixel[0] + pixel[1] + pixel[2]) / 3));
    }
  }, 64);
  parallel_for(light.height(), [&](std::int64_t row) {
    const int y = int(row), below = std::min(y + 1, light.height() - 1);
    for (int x = 0; x < light.width(); ++x) {
      const float v = grey(x, y);
      const float dx = grey(std::min(x + 1, light.width() - 1), y) - v, dy = grey(x, below) - v;
      result(x, y) = float(step * step) * (dx * dx + dy * dy);
    }
  }, 64);
  return result;
}

Image<float> reduced(const Image<float>& image, double factor) {
  const auto side = [&](int size) { return std::max(1, int(std::lround(size / factor))); };
  if (factor <= 1) return image;
  return area_scaled(image, side(image.width()), side(image.height()));
}

/// Display brightness, at no more than about a pixel per texel and so many pixels.
Image<float> picture_to_align(const Image<float>& light, double pixels_per_texel, double most_pixels) {
  const double size = double(light.width()) * light.height();
  const Image<float> small = reduced(light, std::max({1.0, pixels_per_texel, std::sqrt(size / most_pixels)}));
  Image<float> grey(small.width(), small.height(), 1);
  for (int y = 0; y < small.height(); ++y)
    for (int x = 0; x < small.width(); ++x)
      grey(x, y) = float(srgb_from_linear((small(x, y, 0) + small(x, y, 1) + small(x, y, 2)) / 3));
  return grey;
}

/// What is looked at to choose: means over about two texels.
Image<float> picture_to_look_at(const Image<float>& light, double pixels_per_texel) {
  const double fine = std::max(1.0, pixels_per_texel), coarse = std::max(1.0, 2 * pixels_per_texel);
  const Image<float> at_texels = reduced(light, fine);
  const double step = pixels_per_texel / std::max(1.0, double(light.width()) / at_texels.width());
  const Image<float> colours = reduced(light, coarse);
  const Image<float> detail = area_scaled(squared_detail(at_texels, step), colours.width(), colours.height());
  Image<float> result(colours.width(), colours.height(), channels_of_look);
  for (int y = 0; y < result.height(); ++y)
    for (int x = 0; x < result.width(); ++x) {
      for (int c = 0; c < 3; ++c) result(x, y, c) = colours(x, y, c);
      result(x, y, 3) = detail(x, y);
      result(x, y, 4) = colours.channels() > 3 ? std::clamp(colours(x, y, 3), 0.0F, 1.0F) : 1.0F;
    }
  return result;
}

/// Patches with the texels at which photographs are looked at.
struct Looks {
  std::vector<int> offsets{0};
  std::vector<int> places;

  explicit Looks(const Patches& patches) {
    for (int p = 0; p < patches.count(); ++p) {
      const std::vector<int> some = patches.samples(p, samples_of_patch);
      places.insert(places.end(), some.begin(), some.end());
      offsets.push_back(int(places.size()));
    }
  }
};

std::vector<Observations::OfPatch> observe(const Looks& looks, const Partial& shown, std::span<const Vector3> points,
                                           const PinholeCamera& camera, int view) {
  std::vector<Observations::OfPatch> result;
  for (std::size_t p = 0; p + 1 < looks.offsets.size(); ++p) {
    double weight = 0, detail = 0, radius = 0;
    std::array<double, 3> colour{};
    for (int k = looks.offsets[p]; k < looks.offsets[p + 1]; ++k) {
      const double w = shown.confidence[std::size_t(k)] * shown.values(k, 4);
      if (!(w > 0)) continue;
      weight += w, detail += w * shown.values(k, 3);
      if (const auto place = camera.project(points[std::size_t(looks.places[std::size_t(k)])]))
        radius += w * radius_in(camera.width, camera.height, *place);
      for (int c = 0; c < 3; ++c) colour[std::size_t(c)] += w * shown.values(k, c);
    }
    if (!(weight > 0)) continue;
    Observation o{view, float(weight / (looks.offsets[p + 1] - looks.offsets[p])),
                  float(std::sqrt(detail / weight)), {}};
    for (std::size_t c = 0; c < 3; ++c) o.colour[c] = float(colour[c] / weight);
    o.radius = float(radius / weight);
    result.push_back({int(p), o});
  }
  return result;
}

/// The views of a patch in the order in which its texels ask them: the chosen one, then the best.
std::vector<int> order_of_views(std::span<const Observation> views, int chosen) {
  const std::vector<float> qualities = relative_qualities(views);
  std::vector<int> order(views.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, [&](int a, int b) {
    if ((a == chosen) != (b == chosen)) return a == chosen;
    if (views[std::size_t(a)].rejected != views[std::size_t(b)].rejected) return views[std::size_t(b)].rejected;
    return qualities[std::size_t(a)] > qualities[std::size_t(b)];
  });
  for (int& k : order) k = views[std::size_t(k)].view;
  return order;
}

/// What its patch is asked of, or where none shows that, what patches beside it are.
std::vector<std::vector<int>> views_to_ask(const Patches& patches, const Observations& observations,
                                           std::span<const int> chosen) {
  std::vector<std::vector<int>> orders(std::size_t(patches.count()));
  for (int p = 0; p < patches.count(); ++p) orders[std::size_t(p)] = order_of_views(observations.of(p), chosen[p]);
  std::vector<std::vector<int>> result = orders;
  const auto lend = [&](int from, int to) {
    if (!orders[std::size_t(to)].empty()) return;
    for (const int view : orders[std::size_t(from)])
      if (std::ranges::find(result[std::size_t(to)], view) == result[std::size_t(to)].end())
        result[std::size_t(to)].push_back(view);
  };
  for (const Patches::Link& link : patches.links) lend(link.a, link.b), lend(link.b, link.a);
  return result;
}

/// Gives open texels the photograph that is wanted where it shows them, else the first of those that their patch
/// asks which does; `unseen` where none does.
void find_labels(const Projector& projector, const Patches& patches, const std::vector<std::vector<int>>& asked,
                 std::span<const int> wanted, std::span<const PinholeCamera> cameras, const PhotographOptions& options,
                 std::vector<int> open, std::vector<int>& labels, const Progress& progress) {
  constexpr int most_rounds = 16;
  for (const int i : open) labels[std::size_t(i)] = unseen;
  const auto view_asked = [&](int texel, int round) {
    if (round < 0) return wanted.empty() ? unseen : wanted[std::size_t(texel)];
    const std::vector<int>& views = asked[std::size_t(patches.of[texel])];
    return round < std::ssize(views) ? views[std::size_t(round)] : unseen;
  };
  for (int round = wanted.empty() ? 0 : -1; round < most_rounds && !open.empty(); ++round) {
    std::vector<std::vector<int>> of_view(cameras.size());
    std::vector<int> still_open;
    for (const int i : open)
      if (const int view = view_asked(i, round); view != unseen)
        of_view[std::size_t(view)].push_back(i);
      else if (round < 0)
        still_open.push_back(i);
    open = std::move(still_open);
    for (std::size_t v = 0; v < cameras.size(); ++v) {
      const std::vector<double> confidences = projector.confidences(cameras[v], of_view[v], options, progress);
      for (std::size_t k = 0; k < of_view[v].size(); ++k)
        if (confidences[k] > 0)
          labels[std::size_t(of_view[v][k])] = int(v);
        else
          open.push_back(of_view[v][k]);
    }
    std::ranges::sort(open);
    progress.at(double(round + 1) / most_rounds);
  }
}

/// Texels of patches that hold an unseen one, or lie beside such a patch.
std::vector<int> beside_unseen(const Patches& patches, std::span<const int> labels) {
  std::vector<char> holds(std::size_t(patches.count()), 0);
  for (std::size_t i = 0; i < labels.size(); ++i)
    if (labels[i] == unseen) holds[std::size_t(patches.of[i])] = 1;
  std::vector<char> near = holds;
  for (const Patches::Link& link : patches.links) {
    if (holds[std::size_t(link.a)]) near[std::size_t(link.b)] = 1;
    if (holds[std::size_t(link.b)]) near[std::size_t(link.a)] = 1;
  }
  std::vector<int> texels;
  for (std::size_t i = 0; i < labels.size(); ++i)
    if (near[std::size_t(patches.of[i])] && labels[i] != unseen) texels.push_back(int(i));
  return texels;
}

/// Takes what was found with more distance from outlines, but where no texel of a patch and of those beside it would
/// be left: what is thin is shown near its outlines or not at all.
void take_surer(const Patches& patches, std::span<const int> texels, std::span<const int> surer,
                std::vector<int>& labels) {
  std::vector<std::int64_t> left(std::size_t(patches.count()), 0);
  for (std::size_t i = 0; i < labels.size(); ++i) left[std::size_t(patches.of[i])] += surer[i] != unseen;
  std::vector<char> keeps(left.size(), 0);
  for (std::size_t p = 0; p < left.size(); ++p) keeps[p] = left[p] > 0;
  for (const Patches::Link& link : patches.links) {
    if (left[std::size_t(link.a)] > 0) keeps[std::size_t(link.b)] = 1;
    if (left[std::size_t(link.b)] > 0) keeps[std::size_t(link.a)] = 1;
  }
  for (const int i : texels)
    if (keeps[std::size_t(patches.of[i])]) labels[std::size_t(i)] = surer[std::size_t(i)];
}

/// A photograph that disagrees nearly everywhere is rejected altogether, and said so.
void leave_out_strangers(std::span<const Photograph> photographs, Observations& observations, Messages& messages) {
  constexpr double nearly_everywhere = 0.7;
  std::vector<double> all(photographs.size(), 0.0), rejected(photographs.size(), 0.0);
  for (const Observation& o : observations.all) {
    all[std::size_t(o.view)] += 1;
    rejected[std::size_t(o.view)] += o.rejected;
  }
  for (std::size_t v = 0; v < photographs.size(); ++v)
    if (rejected[v] > nearly_everywhere * all[v])
      messages.warning(fmt::format("{}: disagrees with the other photographs on {:.0f} % of what it shows and is left "
                                   "out where others show that: check it and its camera",
                                   photographs[v].picture.string(), 100 * rejected[v] / all[v]));
  for (Observation& o : observations.all)
    if (rejected[std::size_t(o.view)] > nearly_everywhere * all[std::size_t(o.view)]) o.rejected = true;
}

void count_views(const Patches& patches, const Observations& observations, PhotographTexture& result) {
  result.patches = patches.count();
  for (const Observation& o : observations.all) {
    ++result.views[std::size_t(o.view)].patches;
    result.views[std::size_t(o.view)].rejected += o.rejected;
  }
  result.seen_by.assign(result.views.size() + 1, 0);
  for (int p = 0; p < patches.count(); ++p) result.seen_by[observations.of(p).size()] += patches.size(p);
}

}  // namespace

/// What is known of one set of photographs.
struct PhotographTexturing::Work {
  Work(const TexturedModel& model, const TextureSignal& from, std::span<const Photograph> given,
       const PhotographTextureOptions& wanted, const Progress& progress)
      : signal(from),
        photographs(given),
        options(wanted),
        values(model, from),
        projector(model.surface, from.space().positions(), model.atlas->texel_spacing(), progress),
        patches(make_patches(from.space().texels(), from.space().stiffness(), wanted.patch)),
        cameras(given.size()),
        moved(given.size(), 0.0),
        exposed(no_exposures(int(given.size()))),
        pixels_per_texel(given.size(), 0.0) {}

  void align(const Looks& looks, Messages& messages, const Progress& progress) {
    constexpr double most_pixels = 1e6, most_of_all = 1e8;
    constexpr std::size_t most_places = 60'000;
    std::vector<int> places;
    for (std::size_t k = 0; k < looks.places.size(); k += 1 + looks.places.size() / most_places)
      places.push_back(looks.places[k]);
    std::vector<AlignedPhotograph> aligned;
    for (std::size_t v = 0; v < photographs.size(); ++v) {
      const Progress step = step_of(v, 0.6, progress);
      const PhotographLight photograph = PhotographLight::read(photographs[v]);
      const double fine = projector.pixels_per_spacing(photograph.camera, places);
      AlignedPhotograph& one = aligned.emplace_back();
      one.camera = photograph.camera;
      one.grey = picture_to_align(photograph.light, fine,
                                  std::min(most_pixels, most_of_all / double(photographs.size())));
      const std::vector<double> shown = projector.confidences(one.camera, places, options.projection, step);
      for (std::size_t k = 0; k < shown.size(); ++k)
        if (shown[k] > 0) one.places.push_back(places[k]), one.weights.push_back(float(shown[k]));
    }
    align_photographs(projector.places(), aligned, progress.step("align", 0.4));
    for (std::size_t v = 0; v < photographs.size(); ++v) {
      constexpr double far = 10;
      cameras[v] = aligned[v].camera;
      moved[v] = aligned[v].moved;
      if (moved[v] > far)
        messages.warning(fmt::format("{}: alignment moved it by {:.0f} pixels: check its camera",
                                      photographs[v].picture.string(), moved[v]));
    }
  }

  void look(const Looks& looks, Messages& messages, const Progress& progress) {
    std::vector<std::vector<Observations::OfPatch>> of_view(photographs.size());
    for (std::size_t v = 0; v < photographs.size(); ++v) {
      const Progress step = step_of(v, 1, progress);
      const PhotographLight photograph = PhotographLight::read(photographs[v]);
      if (!options.align) cameras[v] = photograph.camera;
      if (!photograph.remark.empty()) messages.remark(photograph.remark);
      pixels_per_texel[v] = projector.pixels_per_spacing(cameras[v], looks.places);
      const Image<float> picture = picture_to_look_at(photograph.light, pixels_per_texel[v]);
      const Partial shown = projector.project(cameras[v], picture, looks.places, options.projection, step);
      of_view[v] = observe(looks, shown, projector.places(), cameras[v], int(v));
      if (of_view[v].empty())
        messages.warning(photographs[v].picture.string() + ": shows nothing of the model: check its camera");
    }
    observations = Observations::gather(patches.count(), of_view);
  }

  /// For who asks only whether a photograph shows a place.
  PhotographOptions plain_projection() const {
    PhotographOptions plain = options.projection;
    plain.doubtful = 0;
    return plain;
  }

  void choose(Messages& messages, const Progress& progress) {
    if (options.match_exposure) exposed = exposures(observations, int(photographs.size()));
    multiply_light(exposed, observations);
    if (options.reject_outliers) {
      reject(patches, options.rejection, observations);
      leave_out_strangers(photographs, observations, messages);
    }
    chosen = choose_views(patches, observations, options.choice, progress);
  }

  /// The photograph as colours are taken from it, in the signal's values: at about two pixels per texel, between which
  /// they are interpolated, so that a texel is a mean over about its own size.
  Image<float> picture(std::size_t view) const {
    PhotographLight photograph = PhotographLight::read(photographs[view]);
    photograph.light = reduced(photograph.light, std::floor(pixels_per_texel[view] / 2 + 0.25));
    return values.of(photograph, exposed, int(view));
  }

  /// Fills in `result.values` and `result.beyond`; what is masked by alpha becomes unseen.
  void take_colours(PhotographTexture& result, const Progress& progress) const {
    result.values = Signal::Zero(std::ssize(result.labels), signal.channels());
    std::vector<std::vector<int>> own(photographs.size());
    for (std::size_t i = 0; i < result.labels.size(); ++i)
      if (result.labels[i] != unseen) own[std::size_t(result.labels[i])].push_back(int(i));
    Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(signal.channels());
    for (std::size_t v = 0; v < photographs.size(); ++v) {
      const Progress step = step_of(v, 1, progress);
      const std::span<const int> beyond = result.beyond.unknowns_of(int(v));
      result.views[v].texels = std::ssize(own[v]);
      if (own[v].empty() && beyond.empty()) continue;
      const Image<float> shown = picture(v);
      const Signal sampled = projector.sampled(cameras[v], shown, own[v]);
      const Signal own_values = values.with_alpha(sampled);
      const bool masked = has_alpha(shown.channels());
      for (std::size_t k = 0; k < own[v].size(); ++k) {
        if (masked && sampled(Eigen::Index(k), sampled.cols() - 1) < opaque) {
          result.labels[std::size_t(own[v][k])] = unseen;
          --result.views[v].texels;
          continue;
        }
        result.values.row(own[v][k]) = own_values.row(Eigen::Index(k));
        sum += own_values.row(Eigen::Index(k));
      }
      const Partial others = projector.project(cameras[v], shown, beyond, plain_projection(), step);
      const Signal other_values = values.with_alpha(others.values);
      for (std::size_t k = 0; k < beyond.size(); ++k)
        if (others.confidence[k] > 0) result.beyond.put(int(v), beyond[k], other_values.row(Eigen::Index(k)));
    }
    const std::int64_t seen = std::ssize(result.labels) - std::ranges::count(result.labels, unseen);
    if (seen == 0) return;
    for (std::size_t i = 0; i < result.labels.size(); ++i)
      if (result.labels[i] == unseen) result.values.row(Eigen::Index(i)) = sum / double(seen);
  }

  /// The part of `share` of the progress that one photograph has.
  Progress step_of(std::size_t view, double share, const Progress& progress) const {
    return progress.step(photographs[view].picture.filename().string(), share / double(photographs.size()));
  }

  const TextureSignal& signal;
  std::span<const Photograph> photographs;
  const PhotographTextureOptions options;
  PhotographValues values;
  Projector projector;
  Patches patches;
  Observations observations;             ///< exposures are evened out once there is a choice
  std::vector<int> chosen;               ///< of each patch the number of its observation
  std::vector<PinholeCamera> cameras;    ///< of the pictures as they are
  std::vector<double> moved;             ///< by alignment
  Exposures exposed;
  std::vector<double> pixels_per_texel;
};

PhotographTexturing::PhotographTexturing(const TexturedModel& model, const TextureSignal& signal,
                                         std::span<const Photograph> photographs,
                                         const PhotographTextureOptions& options, Messages& messages,
                                         const Progress& progress) {
  require(!photographs.empty(), "a texture of photographs needs one at least");
  work_ = std::make_unique<Work>(model, signal, photographs, options, progress.step("places", 0.15));
  const Looks looks(work_->patches);
  if (options.align) work_->align(looks, messages, progress.step("align", 0.5));
  work_->look(looks, messages, progress.step("look", options.align ? 0.3 : 0.75));
  work_->choose(messages, progress.step("choose", 0.05));
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
  std::vector<int> chosen = labels(wanted, progress.step("what is hidden", 0.3));
  BeyondBorders beyond(work_->signal.space(), chosen, work_->signal.channels());
  PhotographTexture result{.values = {},
                           .labels = std::move(chosen),
                           .beyond = std::move(beyond),
                           .offset = {},
                           .falloff = work_->exposed.falloff,
                           .views = std::vector<PhotographTexture::View>(work_->photographs.size()),
                           .seen_by = {}};
  for (std::size_t v = 0; v < result.views.size(); ++v) {
    result.views[v].gain = work_->exposed.gains[v];
    result.views[v].moved = work_->moved[v];
  }
  count_views(work_->patches, work_->observations, result);
  result.offset = offset(result.labels);
  work_->take_colours(result, progress.step("colours", 0.7));
  return result;
}

Partial PhotographTexturing::partial(int photograph, const Progress& progress) const {
  const auto view = std::size_t(photograph);
  require(photograph >= 0 && view < work_->photographs.size(),
          fmt::format("found photograph {} of {}", photograph, work_->photographs.size()));
  std::vector<int> all(std::size_t(work_->signal.space().size()));
  std::iota(all.begin(), all.end(), 0);
  Partial shown = work_->projector.project(work_->cameras[view], work_->picture(view), all,
                                           work_->options.projection, progress);
  shown.values = work_->values.with_alpha(shown.values);
  return shown;
}

Signal PhotographTexturing::offset(std::span<const int> labels) const {
  const Observations& observations = work_->observations;
  Signal result = Signal::Zero(std::ssize(labels), work_->signal.channels());
  // Of each observation its own colour and that which is agreed on, as pixels of a picture.
  std::vector<LightColour> colours(observations.all.size() * 2);
  const std::vector<std::optional<LightColour>> agreed = agreed_colours(observations);
  for (int p = 0; p < work_->patches.count(); ++p)
    for (std::int64_t k = observations.offsets[p]; k < observations.offsets[p + 1]; ++k) {
      const LightColour& own = observations.all[std::size_t(k)].colour;
      colours[2 * std::size_t(k)] = own;
      colours[2 * std::size_t(k) + 1] = agreed[std::size_t(p)].value_or(own);
    }
  const Signal worked = work_->values.of_colours(colours);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (labels[i] == unseen) continue;
    const int p = work_->patches.of[i];
    const auto views = observations.of(p);
    const auto at = std::ranges::lower_bound(views, labels[i], {}, &Observation::view);
    if (at == views.end() || at->view != labels[i]) continue;
    const Eigen::Index row = 2 * Eigen::Index(observations.offsets[p] + (at - views.begin()));
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

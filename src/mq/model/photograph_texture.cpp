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
#include "mq/mesh/geometry.h"
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

/// Display brightness, at no more than about a pixel per texel and a million pixels.
Image<float> picture_to_align(const Image<float>& light, double pixels_per_texel) {
  constexpr double most_pixels = 1e6;
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

std::vector<Observations::OfPatch> observe(const Looks& looks, const Partial& shown, int view) {
  std::vector<Observations::OfPatch> result;
  for (std::size_t p = 0; p + 1 < looks.offsets.size(); ++p) {
    double weight = 0, detail = 0;
    std::array<double, 3> colour{};
    for (int k = looks.offsets[p]; k < looks.offsets[p + 1]; ++k) {
      const double w = shown.confidence[std::size_t(k)] * shown.values(k, 4);
      if (!(w > 0)) continue;
      weight += w, detail += w * shown.values(k, 3);
      for (int c = 0; c < 3; ++c) colour[std::size_t(c)] += w * shown.values(k, c);
    }
    if (!(weight > 0)) continue;
    Observation o{view, float(weight / (looks.offsets[p + 1] - looks.offsets[p])),
                  float(std::sqrt(detail / weight)), {}};
    for (std::size_t c = 0; c < 3; ++c) o.colour[c] = float(colour[c] / weight);
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

/// Per texel the first of the views that its patch asks which shows it.
std::vector<int> labels_by_texel(const Projector& projector, const Patches& patches,
                                 const std::vector<std::vector<int>>& asked,
                                 std::span<const PinholeCamera> cameras, const PhotographOptions& options,
                                 const Progress& progress) {
  constexpr std::size_t most_rounds = 16;
  std::vector<int> labels(patches.of.size(), unseen), open(patches.of.size());
  std::iota(open.begin(), open.end(), 0);
  for (std::size_t round = 0; round < most_rounds && !open.empty(); ++round) {
    std::vector<std::vector<int>> of_view(cameras.size());
    for (const int i : open)
      if (const std::vector<int>& views = asked[std::size_t(patches.of[i])]; round < views.size())
        of_view[std::size_t(views[round])].push_back(i);
    open.clear();
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
  return labels;
}

/// Values of the space's unknowns for what is to be added to their patch's chosen light.
Signal offsets_by_texel(const TextureSignal& signal, const Patches& patches, const Observations& observations,
                        std::span<const int> labels, const PhotographValues& values) {
  Signal result = Signal::Zero(std::ssize(labels), signal.channels());
  // Of each patch and view that is the label of one of its texels: two colours, as pixels of a picture.
  std::vector<LightColour> colours(observations.all.size() * 2);
  std::vector<int> chosen(std::size_t(patches.count()), 0);
  for (int p = 0; p < patches.count(); ++p) {
    const auto views = observations.of(p);
    if (views.empty()) chosen[std::size_t(p)] = -1;
  }
  const std::vector<LightColour> to_mean = offsets_to_mean(observations, chosen);
  for (int p = 0; p < patches.count(); ++p) {
    const auto views = observations.of(p);
    for (std::size_t k = 0; k < views.size(); ++k) {
      const std::size_t at = 2 * std::size_t(observations.offsets[p] + std::int64_t(k));
      colours[at] = views[k].colour;
      for (std::size_t c = 0; c < 3; ++c)
        colours[at + 1][c] = std::max(0.0F, views[0].colour[c] + to_mean[std::size_t(p)][c]);
    }
  }
  const Signal worked = values.of_colours(colours);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (labels[i] == unseen) continue;
    const int p = patches.of[i];
    const auto views = observations.of(p);
    const auto at = std::ranges::lower_bound(views, labels[i], {}, &Observation::view);
    if (at == views.end() || at->view != labels[i]) continue;
    const Eigen::Index row = 2 * Eigen::Index(observations.offsets[p] + (at - views.begin()));
    result.row(Eigen::Index(i)).head(worked.cols()) = worked.row(row + 1) - worked.row(row);
  }
  return result;
}

/// The work on one set of photographs.
class Photographing {
 public:
  Photographing(const TexturedModel& model, const TextureSignal& signal, std::span<const Photograph> photographs,
                const PhotographTextureOptions& options, Messages& messages, const Progress& progress)
      : signal_(signal),
        photographs_(photographs),
        options_(options),
        messages_(messages),
        values_(model, signal),
        projector_(model.surface, signal.space().positions(), model.atlas->texel_spacing(), progress),
        cameras_(photographs.size()),
        moved_(photographs.size(), 0.0),
        pixels_per_texel_(photographs.size(), 0.0) {}

  void align(const Looks& looks, const Progress& progress) {
    std::vector<AlignedPhotograph> aligned;
    for (std::size_t v = 0; v < photographs_.size(); ++v) {
      const Progress step = step_of(v, 0.6, progress);
      const PhotographLight photograph = PhotographLight::read(photographs_[v]);
      const double fine = projector_.pixels_per_spacing(photograph.camera, looks.places);
      AlignedPhotograph& one = aligned.emplace_back();
      one.camera = photograph.camera;
      one.grey = picture_to_align(photograph.light, fine);
      const std::vector<double> shown = projector_.confidences(one.camera, looks.places, options_.projection, step);
      for (std::size_t k = 0; k < shown.size(); ++k)
        if (shown[k] > 0) one.places.push_back(looks.places[k]), one.weights.push_back(float(shown[k]));
    }
    align_photographs(projector_.places(), aligned, progress.step("align", 0.4));
    for (std::size_t v = 0; v < photographs_.size(); ++v) {
      constexpr double far = 10;
      cameras_[v] = aligned[v].camera;
      moved_[v] = aligned[v].moved;
      if (moved_[v] > far)
        messages_.warning(fmt::format("{}: alignment moved it by {:.0f} pixels: check its camera",
                                      photographs_[v].picture.string(), moved_[v]));
    }
  }

  Observations look(const Patches& patches, const Looks& looks, const Progress& progress) {
    std::vector<std::vector<Observations::OfPatch>> of_view(photographs_.size());
    for (std::size_t v = 0; v < photographs_.size(); ++v) {
      const Progress step = step_of(v, 1, progress);
      const PhotographLight photograph = PhotographLight::read(photographs_[v]);
      if (!options_.align) cameras_[v] = photograph.camera;
      if (!photograph.remark.empty()) messages_.remark(photograph.remark);
      pixels_per_texel_[v] = projector_.pixels_per_spacing(cameras_[v], looks.places);
      const Image<float> picture = picture_to_look_at(photograph.light, pixels_per_texel_[v]);
      of_view[v] = observe(looks, projector_.project(cameras_[v], picture, looks.places, options_.projection, step),
                           int(v));
      if (of_view[v].empty())
        messages_.warning(photographs_[v].picture.string() + ": shows nothing of the model: check its camera");
    }
    return Observations::gather(patches.count(), of_view);
  }

  std::vector<int> labels(const Patches& patches, const Observations& observations, std::span<const int> chosen,
                          const Progress& progress) const {
    return labels_by_texel(projector_, patches, views_to_ask(patches, observations, chosen), cameras_,
                           options_.projection, progress);
  }

  /// Fills in `result.values` and `result.beyond`; what is masked by alpha becomes unseen.
  void take_colours(PhotographTexture& result, const Progress& progress) const {
    result.values = Signal::Zero(std::ssize(result.labels), signal_.channels());
    std::vector<std::vector<int>> own(photographs_.size());
    for (std::size_t i = 0; i < result.labels.size(); ++i)
      if (result.labels[i] != unseen) own[std::size_t(result.labels[i])].push_back(int(i));
    Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(signal_.channels());
    for (std::size_t v = 0; v < photographs_.size(); ++v) {
      const Progress step = step_of(v, 1, progress);
      const std::span<const int> beyond = result.beyond.unknowns_of(int(v));
      result.views[v].texels = std::ssize(own[v]);
      if (own[v].empty() && beyond.empty()) continue;
      PhotographLight photograph = PhotographLight::read(photographs_[v]);
      photograph.light = reduced(photograph.light, std::floor(pixels_per_texel_[v] + 0.25));
      const Image<float> picture = values_.of(photograph, result.views[v].gain);
      const Signal sampled = projector_.sampled(cameras_[v], picture, own[v]);
      const Signal values = values_.with_alpha(sampled);
      const bool masked = has_alpha(picture.channels());
      for (std::size_t k = 0; k < own[v].size(); ++k) {
        if (masked && sampled(Eigen::Index(k), sampled.cols() - 1) < opaque) {
          result.labels[std::size_t(own[v][k])] = unseen;
          --result.views[v].texels;
          continue;
        }
        result.values.row(own[v][k]) = values.row(Eigen::Index(k));
        sum += values.row(Eigen::Index(k));
      }
      const Partial others = projector_.project(cameras_[v], picture, beyond, options_.projection, step);
      const Signal other_values = values_.with_alpha(others.values);
      for (std::size_t k = 0; k < beyond.size(); ++k)
        if (others.confidence[k] > 0) result.beyond.put(int(v), beyond[k], other_values.row(Eigen::Index(k)));
    }
    const std::int64_t seen = std::ssize(result.labels) - std::ranges::count(result.labels, unseen);
    if (seen == 0) return;
    for (std::size_t i = 0; i < result.labels.size(); ++i)
      if (result.labels[i] == unseen) result.values.row(Eigen::Index(i)) = sum / double(seen);
  }

  const PhotographValues& values() const { return values_; }
  double moved(std::size_t view) const { return moved_[view]; }

 private:
  /// The part of `share` of the progress that one photograph has.
  Progress step_of(std::size_t view, double share, const Progress& progress) const {
    return progress.step(photographs_[view].picture.filename().string(), share / double(photographs_.size()));
  }

  const TextureSignal& signal_;
  std::span<const Photograph> photographs_;
  const PhotographTextureOptions& options_;
  Messages& messages_;
  PhotographValues values_;
  Projector projector_;
  std::vector<PinholeCamera> cameras_;  ///< of the pictures as they are
  std::vector<double> moved_;           ///< by alignment
  std::vector<double> pixels_per_texel_;
};

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

PhotographTexture texture_of_photographs(const TexturedModel& model, const TextureSignal& signal,
                                         std::span<const Photograph> photographs,
                                         const PhotographTextureOptions& options, Messages& messages,
                                         const Progress& progress) {
  require(!photographs.empty(), "a texture of photographs needs one at least");
  Photographing work(model, signal, photographs, options, messages, progress.step("places", 0.1));
  const Patches patches = make_patches(signal.space().texels(), signal.space().stiffness(), options.patch);
  const Looks looks(patches);
  if (options.align) work.align(looks, progress.step("align", 0.3));
  Observations observations = work.look(patches, looks, progress.step("look", options.align ? 0.2 : 0.35));
  std::vector<LightColour> gains(photographs.size(), LightColour{1, 1, 1});
  if (options.match_exposure) gains = exposures(observations, int(photographs.size()));
  multiply_light(gains, observations);
  if (options.reject_outliers) {
    reject(patches, options.rejection, observations);
    leave_out_strangers(photographs, observations, messages);
  }
  const std::vector<int> chosen = choose_views(patches, observations, options.choice, progress.step("choose", 0.05));
  std::vector<int> labels = work.labels(patches, observations, chosen, progress.step("what is hidden", 0.1));
  BeyondBorders beyond(signal.space(), labels, signal.channels());
  PhotographTexture result{.values = {},
                           .labels = std::move(labels),
                           .beyond = std::move(beyond),
                           .offset = {},
                           .views = std::vector<PhotographTexture::View>(photographs.size()),
                           .seen_by = {}};
  for (std::size_t v = 0; v < photographs.size(); ++v) {
    result.views[v].gain = gains[v];
    result.views[v].moved = work.moved(v);
  }
  count_views(patches, observations, result);
  result.offset = offsets_by_texel(signal, patches, observations, result.labels, work.values());
  work.take_colours(result, progress.step("colours", 0.25));
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

int side_for_photographs(const Surface& surface, std::span<const Photograph> photographs, double occupancy) {
  struct Seen {
    double pixel;  ///< model units
    double area;
  };
  std::vector<Seen> seen;
  double all = 0;
  for (int t = 0; t < int(surface.mesh.triangles.size()); ++t) {
    const Mesh& mesh = surface.mesh;
    const Vector3 a = mesh.position(t, 0), b = mesh.position(t, 1), c = mesh.position(t, 2);
    const Vector3 normal = (b - a).cross(c - a), middle = (a + b + c) / 3;
    double pixel = 0;
    for (const Photograph& photograph : photographs) {
      const PinholeCamera& camera = photograph.camera;
      if (!(normal.dot(camera.center() - middle) > 0) || !camera.project(middle)) continue;
      const double size = (camera.rotation * middle + camera.translation).z() / camera.fx;
      if (pixel == 0 || size < pixel) pixel = size;
    }
    if (pixel > 0) seen.push_back({pixel, normal.norm() / 2});
    if (pixel > 0) all += normal.norm() / 2;
  }
  constexpr int least = 256, most = 8192, usual = 1024;
  if (!(all > 0)) return usual;
  std::ranges::sort(seen, {}, &Seen::pixel);
  double below = 0, pixel = seen.back().pixel;
  for (const Seen& one : seen) {
    below += one.area;
    if (below >= all / 2) {
      pixel = one.pixel;
      break;
    }
  }
  const double side = std::sqrt(surface.area / occupancy) / pixel;
  const double nearest = std::exp2(std::round(std::log2(std::clamp(side, 1.0, 1e6))));
  return std::clamp(int(nearest), least, most);
}

}  // namespace mq

#include "mq/model/detail/photograph_looks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "mq/model/detail/photograph_light.h"
#include "mq/model/detail/photograph_pictures.h"

namespace mq {

Looks::Looks(const Patches& patches) {
  for (int p = 0; p < patches.count(); ++p) {
    const std::vector<int> some = patches.samples(p, Print::places);
    places.insert(places.end(), some.begin(), some.end());
    offsets.push_back(int(places.size()));
  }
}

std::vector<Observations::OfPatch> observe(const Looks& looks, const Partial& shown, std::span<const Vector3> points,
                                           const PinholeCamera& camera, int view) {
  std::vector<Observations::OfPatch> result;
  for (std::size_t p = 0; p + 1 < looks.offsets.size(); ++p) {
    double weight = 0, detail = 0, radius = 0;
    std::array<double, 3> colour{};
    for (int k = looks.offsets[p]; k < looks.offsets[p + 1]; ++k) {
      const double w = shown.confidence[std::size_t(k)] * shown.values(k, channel_of_alpha);
      if (!(w > 0)) continue;
      weight += w, detail += w * shown.values(k, channel_of_detail);
      if (const auto place = camera.project(points[std::size_t(looks.places[std::size_t(k)])]))
        radius += w * radius_in(camera.width, camera.height, *place);
      for (int c = 0; c < 3; ++c) colour[std::size_t(c)] += w * shown.values(k, c);
    }
    if (!(weight > 0)) continue;
    Observation o{view, float(weight / (looks.offsets[p + 1] - looks.offsets[p])),
                  float(std::sqrt(detail / weight)), {}};
    for (std::size_t c = 0; c < 3; ++c) o.colour[c] = float(colour[c] / weight);
    o.radius = float(radius / weight);
    const double mean = (colour[0] + colour[1] + colour[2]) / weight;
    for (int k = looks.offsets[p]; k < looks.offsets[p + 1]; ++k)
      if (shown.confidence[std::size_t(k)] * shown.values(k, channel_of_alpha) > 0)
        o.print.put(k - looks.offsets[p], shown.values.row(k).head(3).sum() / 3, mean / 3);
    result.push_back({int(p), o});
  }
  return result;
}

void weigh_by_sharpness(std::span<const std::vector<float>> details, std::size_t places,
                        std::vector<AlignedPhotograph>& photographs) {
  std::vector<std::vector<float>> of_place(places);
  for (std::size_t v = 0; v < photographs.size(); ++v)
    for (std::size_t k = 0; k < details[v].size(); ++k)
      of_place[std::size_t(photographs[v].places[k])].push_back(details[v][k]);
  for (std::vector<float>& found : of_place)
    std::nth_element(found.begin(), found.begin() + std::ssize(found) / 2, found.end());
  for (std::size_t v = 0; v < photographs.size(); ++v)
    for (std::size_t k = 0; k < details[v].size(); ++k) {
      constexpr float least = 0.05F * 0.05F;
      const std::vector<float>& found = of_place[std::size_t(photographs[v].places[k])];
      const float usual = found[found.size() / 2];
      if (usual > 0) photographs[v].weights[k] *= std::clamp(details[v][k] / usual, least, 1.0F);
    }
}

std::vector<char> strangers(std::span<const Photograph> photographs, const Observations& observations, Messages& messages) {
  constexpr double nearly_everywhere = 0.7;
  std::vector<double> all(photographs.size(), 0.0), rejected(photographs.size(), 0.0);
  for (const Observation& o : observations.all) {
    all[std::size_t(o.view)] += 1;
    rejected[std::size_t(o.view)] += o.rejected;
  }
  std::vector<char> found(photographs.size(), 0);
  for (std::size_t v = 0; v < photographs.size(); ++v) {
    found[v] = rejected[v] > nearly_everywhere * all[v];
    if (found[v])
      messages.warning(fmt::format("{}: disagrees with the other photographs on {:.0f} % of what it shows and is left "
                                   "out where others show that: check it and its camera",
                                   photographs[v].picture.string(), 100 * rejected[v] / all[v]));
  }
  return found;
}

ObservationsOfOthers::ObservationsOfOthers(const Observations& all, std::span<const char> left_out) {
  observations.offsets.assign(1, 0);
  for (int p = 0; p < all.patches(); ++p) {
    for (auto k = std::size_t(all.offsets[p]); k < std::size_t(all.offsets[p + 1]); ++k)
      if (!left_out[std::size_t(all.all[k].view)]) {
        observations.all.push_back(all.all[k]);
        places.push_back(k);
      }
    observations.offsets.push_back(std::ssize(observations.all));
  }
}

void take_strangers_alone(std::span<const char> strange, Observations& observations) {
  for (int p = 0; p < observations.patches(); ++p) {
    const std::span<Observation> views = observations.of(p);
    if (std::ranges::all_of(views, [&](const Observation& o) { return strange[std::size_t(o.view)] != 0; }))
      for (Observation& o : views) o.rejected = false;
  }
}

void count_views(const Patches& patches, const Observations& observations, const RejectOptions& options,
                 PhotographTexture& result) {
  result.patches = patches.count();
  result.agreement = agreement(observations);
  for (const Observation& o : observations.all) {
    ++result.views[std::size_t(o.view)].patches;
    result.views[std::size_t(o.view)].rejected += o.rejected;
  }
  result.seen_by.assign(result.views.size() + 1, 0);
  const std::vector<char> in_doubt = undecided(patches, observations, options);
  for (int p = 0; p < patches.count(); ++p) {
    result.seen_by[observations.of(p).size()] += patches.size(p);
    if (in_doubt[std::size_t(p)]) result.undecided += patches.size(p);
  }
  for (const int p : patches.of) {
    result.shown_by.push_back(int(observations.of(p).size()));
    result.rejected_by.push_back(int(std::ranges::count(observations.of(p), true, &Observation::rejected)));
  }
}

}  // namespace mq

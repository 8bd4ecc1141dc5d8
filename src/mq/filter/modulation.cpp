// β = 1 + (β₀ − 1) max(m, 0) + min(m, 0),  m the mask.
//
// Thesis 5.9.1 gives a β to each cell; ours is given at the unknowns, and a cell or triangle has
// the mean over its unknowns (`SignalSpace::stiffness_times`), so that one mask serves every space.

#include "mq/filter/modulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/image/colour.h"
#include "mq/image/resample.h"
#include "mq/mesh/closest_point.h"

namespace mq {
namespace {

/// Refuses NaN by its place.
double strength(double value, double least, const auto& place) {
  require(!std::isnan(value), "the mask at " + place() + " is not a number");
  return std::clamp(value, least, 1.0);
}

}  // namespace

std::vector<double> modulation(std::span<const double> mask, double beta) {
  std::vector<double> result(mask.size());
  std::ranges::transform(mask, result.begin(), [&](double m) { return m < 0 ? 1 + m : std::lerp(1.0, beta, m); });
  return result;
}

double mask_at(const Image<float>& picture, const TextureSize& size, int x, int y, double least) {
  float values[64];
  const int channels = std::min(picture.channels(), 64), colours = colour_channels(channels);
  const double column = (x + 0.5) * picture.width() / size.width - 0.5;
  const double row = (y + 0.5) * picture.height() / size.height - 0.5;
  sample(picture, column, row, size.wrap, {values, std::size_t(channels)});
  double sum = 0;
  for (int c = 0; c < colours; ++c) sum += values[c];
  return strength(sum / colours, least, [&] { return fmt::format("texel ({}, {})", x, y); });
}

std::vector<double> mask_of_pictures(const Texels& texels, std::span<const TextureSize> textures,
                                     std::span<const Image<float>> pictures, double least) {
  require(pictures.size() == textures.size(),
          fmt::format("{} mask pictures for {} textures: give one each", pictures.size(),
                      textures.size()));
  for (std::size_t k = 0; k < pictures.size(); ++k)
    require(!pictures[k].empty(), fmt::format("mask picture {} has no pixels", k));
  std::vector<double> mask(std::size_t(texels.size()));
  parallel_for(texels.size(), [&](std::int64_t i) {
    const Texels::Place& at = texels.places[i];
    mask[i] = mask_at(pictures[at.texture], textures[at.texture], at.x, at.y, least);
  });
  return mask;
}

std::vector<double> mask_of_vertices(const Mesh& mesh, std::span<const double> values,
                                     std::span<const Vector3> places, double least,
                                     const Progress& progress) {
  require(std::ssize(values) == mesh.vertex_count(),
          fmt::format("a mask of {} values was given for {} vertices", values.size(),
                      mesh.vertex_count()));
  const ClosestPointFinder closest(mesh);
  const std::vector<ClosestPoint> points = closest(places, progress);
  std::vector<double> mask(places.size());
  parallel_for(std::ssize(places), [&](std::int64_t i) {
    double sum = 0;
    for (int k = 0; k < 3; ++k)
      sum += points[i].barycentric[k] * values[mesh.triangles[points[i].triangle][k]];
    mask[i] = strength(sum, least, [&] { return fmt::format("place {}", i); });
  });
  return mask;
}

double paint_at(const Spot& spot, const Vector3& place) {
  double squared = (place - spot.center).squaredNorm() / (spot.radius * spot.radius);
  if (spot.hardness > 0 && squared < 1) {
    const double t = std::max(0.0, std::sqrt(squared) - spot.hardness) / std::max(1 - spot.hardness, 1e-300);
    squared = std::min(1.0, t * t);
  }
  const double inside = 1 - squared;
  return inside > 0 ? spot.strength * inside * inside : 0;
}

std::int64_t add_spots(std::span<const Spot> spots, std::span<const Vector3> places,
                       std::vector<double>& mask) {
  require(mask.size() == places.size(), "a mask needs one place for each of its values");
  std::int64_t changes = 0;
  for (const Spot& spot : spots) {
    require(
        spot.center.allFinite() && std::isfinite(spot.radius) && spot.radius > 0 &&
            std::isfinite(spot.strength),
        fmt::format("a spot at ({}, {}, {}) has radius {} and strength {}: the radius must be "
                    "positive, all numbers finite",
                    spot.center.x(), spot.center.y(), spot.center.z(), spot.radius, spot.strength));
    changes += parallel_sum(std::ssize(places), std::int64_t(0), [&](auto begin, auto end) {
      std::int64_t count = 0;
      for (auto i = begin; i < end; ++i) {
        const double before = mask[i];
        mask[i] = std::clamp(before + paint_at(spot, places[i]), std::min(before, 0.0), 1.0);
        count += mask[i] != before;
      }
      return count;
    });
  }
  return changes;
}

}  // namespace mq

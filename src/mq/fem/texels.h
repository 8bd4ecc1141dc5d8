#pragma once
/// The texels that carry unknowns of a texel space, and what a solver may know of where they lie.

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <vector>

namespace mq {

/// Unknown k is texel k here. Texels are ordered by texture, row and column, so that texels
/// adjacent in a row are adjacent here.
struct Texels {
  struct Place {
    int texture = 0;
    int x = 0;  ///< column of the picture
    int y = 0;  ///< row of the picture, 0 on top
  };
  std::vector<Place> places;
  /// What positions count from: 0, but a place of the surface where that lies so far from 0, in a
  /// country's coordinates, that single precision would not tell its texels apart.
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  std::vector<std::array<float, 3>>
      positions;           ///< on the surface, from `origin`; outside its chart, the affine
                           ///< extrapolation of a triangle near it; model units
  std::vector<int> chart;  ///< the chart whose cells touch the texel (where several do, of the
                           ///< earliest turn)
  std::vector<char> interior;  ///< 1: its four cells lie wholly in that chart, away from any seam,
                               ///< so that its matrix row is a 3 × 3 stencil over grid neighbours

  int size() const { return int(places.size()); }

  /// The unknown of a texel, −1 where it has none.
  int find(const Place& texel) const {
    const auto raster = [](const Place& p) { return std::tuple(p.texture, p.y, p.x); };
    const auto at = std::ranges::lower_bound(places, raster(texel), {}, raster);
    return at != places.end() && raster(*at) == raster(texel) ? int(at - places.begin()) : -1;
  }

  int chart_count() const {
    int count = 0;
    for (const int c : chart) count = std::max(count, c + 1);
    return count;
  }

  /// In the model's coordinates.
  Eigen::Vector3d position(int k) const {
    const auto& [x, y, z] = positions[std::size_t(k)];
    return origin + Eigen::Vector3d(x, y, z);
  }

  double squared_distance(int a, int b) const {
    double squared = 0;
    for (int i = 0; i < 3; ++i) squared += std::pow(double(positions[a][i]) - positions[b][i], 2);
    return squared;
  }
  double distance(int a, int b) const { return std::sqrt(squared_distance(a, b)); }
};

}  // namespace mq

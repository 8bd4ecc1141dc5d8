#include "mq/fem/point_bins.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "fem/cut_squares.h"
#include "mq/base/error.h"

namespace mq {
namespace {

struct Square {
  fixtures::Cut cut = fixtures::cut("turned", fixtures::turned(fixtures::odd_angle), {96, 96});
  TexelSpace space{cut.model->surface, cut.model->atlas};
  const Texels& texels = space.texels();
  double spacing = space.scale().texel_spacing;
};

std::vector<int> points_of(const PointBins& bins, const std::vector<int>& some, int count) {
  RowSet set(count);
  bins.add(some, set);
  return set.rows();
}

TEST(PointBins, HoldEveryPointOnce) {
  const Square s;
  const PointBins bins(s.texels.positions, 5 * s.spacing);
  std::vector<int> held(std::size_t(s.texels.size()), 0);
  for (int bin = 0; bin < bins.bin_count(); ++bin) {
    EXPECT_TRUE(std::ranges::is_sorted(bins.points_of(bin)));
    for (const int k : bins.points_of(bin)) ++held[std::size_t(k)];
  }
  EXPECT_TRUE(std::ranges::all_of(held, [](int count) { return count == 1; }));
}

TEST(PointBins, FindAllWithinReachAndLittleBeyond) {
  const Square s;
  for (const double side : {1.5, 4.0, 30.0, 1000.0})
    for (const double reach : {0.0, 3.0, 8.0}) {
      const PointBins bins(s.texels.positions, side * s.spacing);
      const std::vector<int> from = {17, s.texels.size() / 2};
      const std::vector<int> found =
          points_of(bins, bins.around(from, reach * s.spacing), s.texels.size());
      for (int k = 0; k < s.texels.size(); ++k) {
        const double away =
            std::min(s.texels.distance(k, from[0]), s.texels.distance(k, from[1])) / s.spacing;
        const bool is_found = std::ranges::binary_search(found, k);
        if (away <= reach) { ASSERT_TRUE(is_found) << k << ", " << away; }
        // Two bins' diagonals, in the plane, may be added.
        if (is_found) { ASSERT_LE(away, reach + 2 * std::sqrt(2) * side) << k; }
      }
    }
}

TEST(PointBins, WantASide) {
  const Square s;
  EXPECT_THROW(PointBins(s.texels.positions, 0), InvalidInput);
}

}  // namespace
}  // namespace mq

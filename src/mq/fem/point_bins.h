#pragma once
/// Which of many points lie near some of them, at a cost of those found.

#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "mq/linear/row_set.h"

namespace mq {

/// Points sorted into cubes of space, where unknowns lie on a surface. Distances are straight ones, which
/// are never longer than those on it. Holds 8 bytes per point, and no reference to them.
class PointBins {
 public:
  /// `side` is that of a cube, in model units; positive and finite.
  PointBins(std::span<const std::array<float, 3>> points, double side);

  /// The bins that hold a point no farther than `reach` from one of those that hold `points`, increasing.
  /// Boxes around the points of a bin stand for it, so that some are a little farther away.
  std::vector<int> around(std::span<const int> points, double reach) const;

  /// The same for those near one bin, in any order.
  std::vector<int> around_bin(int bin, double reach) const;

  int bin_of(int point) const { return bin_of_[std::size_t(point)]; }

  /// The points of a bin, increasing.
  std::span<const int> points_of(int bin) const {
    return std::span(members_).subspan(std::size_t(starts_[bin]),
                                       std::size_t(starts_[bin + 1] - starts_[bin]));
  }

  /// The points of some bins.
  void add(std::span<const int> bins, RowSet& to) const;

  int bin_count() const { return int(boxes_.size()); }

 private:
  using Cube = std::array<int, 3>;
  struct Box {
    std::array<float, 3> low, high;
  };
  static std::uint64_t key_of(const Cube& cube);
  static double distance(const Box& a, const Box& b);

  double side_;
  std::vector<Cube> cubes_;                         ///< per bin
  std::vector<Box> boxes_;                          ///< per bin, around its points
  std::unordered_map<std::uint64_t, int> bin_at_;   ///< of a cube
  std::vector<int> bin_of_;                         ///< per point
  std::vector<int> starts_, members_;
};

}  // namespace mq

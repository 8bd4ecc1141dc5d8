#pragma once
/// Which texels lie near some place of the surface, at a cost of those found.

#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "mq/fem/texels.h"
#include "mq/linear/row_set.h"

namespace mq {

/// Texels sorted into cubes of space. Distances are straight ones, which are never longer than those on
/// the surface. Holds 8 bytes per texel, and no reference to the texels.
class TexelBins {
 public:
  /// `side` is that of a cube, in model units; positive and finite.
  TexelBins(const Texels& texels, double side);

  /// The bins that hold a texel no farther than `reach` from one of those that hold `texels`, increasing.
  /// Boxes around the texels of a bin stand for it, so that some are a little farther away.
  std::vector<int> around(std::span<const int> texels, double reach) const;

  /// The texels of a bin, increasing.
  std::span<const int> texels_of(int bin) const {
    return std::span(members_).subspan(std::size_t(starts_[bin]),
                                       std::size_t(starts_[bin + 1] - starts_[bin]));
  }

  /// The texels of some bins.
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
  std::vector<Box> boxes_;                          ///< per bin, around its texels
  std::unordered_map<std::uint64_t, int> bin_at_;   ///< of a cube
  std::vector<int> bin_of_;                         ///< per texel
  std::vector<int> starts_, members_;
};

}  // namespace mq

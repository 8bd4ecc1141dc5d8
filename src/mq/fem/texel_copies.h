#pragma once
/// Which texel of the pictures each unknown is a copy of, where charts that share texels are laid
/// apart.

#include <span>
#include <vector>

#include "mq/atlas/separate_overlaps.h"
#include "mq/fem/texel_space.h"

namespace mq {

/// Between pictures and a texel space on `SeparatedAtlas::atlas`. A texel that stands for several
/// places of the surface has a copy there for each, and can show the value of one: of the copy in
/// the chart that covers the texel's centre; where charts overlap, in that of the earliest turn
/// among them; where none covers it, of the copy of the largest mass.
class TexelCopies {
 public:
  /// All three must outlive the object.
  TexelCopies(const Surface& surface, const SeparatedAtlas& apart, const TexelSpace& space);

  /// Texels of the pictures that have several copies; in order.
  const std::vector<Texels::Place>& shared() const { return shared_; }

  /// The texel of the pictures whose copy an unknown is.
  Texels::Place home(int unknown) const;

  /// The copies of a texel in the charts that cover its centre; if none does, the one that is
  /// shown; none where no chart reads it.
  std::vector<int> meant(const Texels::Place& texel) const;

  /// Whether the picture shows this copy.
  bool is_shown(int unknown) const { return is_shown_[std::size_t(unknown)] != 0; }

  /// Values of unknowns to the texels that show them; changes no other texel.
  void scatter(const Signal& signal, std::span<Image<float>> pictures) const;

 private:
  struct Copy {
    std::int64_t texel;  ///< of all pictures, row by row
    int unknown;
    int rank;  ///< 0: covers the centre, 1: lies there, 2: in the border texel next to it
  };
  std::int64_t number(const Texels::Place& texel) const;

  const SeparatedAtlas& apart_;
  const TexelSpace& space_;
  std::vector<std::int64_t> offsets_;  // per picture
  std::vector<Copy> copies_;           // by texel, those that are shown first
  std::vector<Texels::Place> shared_;
  std::vector<char> is_shown_;  // per unknown
};

}  // namespace mq

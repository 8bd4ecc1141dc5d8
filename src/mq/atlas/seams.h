#pragma once
/// What is one point on the surface and several in the textures, and the value that a function
/// bilinear in each chart is given there (thesis 5.5, step 2, extended: see `Seams::add_value`).

#include <span>
#include <vector>

#include "mq/atlas/atlas.h"

namespace mq {

/// A place in a texture: texel coordinates split into cell and fraction in [0, 1).
struct TexturePlace {
  int texture = 0;
  int column = 0, row = 0;
  double x = 0, y = 0;
};

/// One term of a value along a seam: (weight + rate·(s − s₀)) times the bilinear interpolation at a
/// place that moves by (x_rate, y_rate) texels per unit of s and is at `place` for s = s₀.
struct SeamTerm {
  TexturePlace place;
  double weight = 0, rate = 0;
  double x_rate = 0, y_rate = 0;
};

/// The seams of an atlas. Seam e joins two half-edges; its parameter s runs from 0 to 1 along the
/// first of them and from 1 to 0 along the second.
class Seams {
 public:
  /// Distance in texels over which seam values blend into the bilinear ones next to them. It bounds
  /// the conditioning: a unit step over a node at distance d from a seam costs 1/d energy
  /// otherwise.
  static constexpr double blend = 0.25;

  Seams(const Surface& surface, const Atlas& atlas);

  int count() const { return int(first_.size()); }

  /// The seam of a half-edge, -1 where it is none, and whether it is the first of the two.
  int seam(HalfEdge h) const { return seam_[h]; }
  bool is_first(HalfEdge h) const { return first_[seam_[h]] == h; }
  std::array<HalfEdge, 2> half_edges(int seam) const { return {first_[seam], second_[seam]}; }

  /// Where either side crosses a texel line, and where the blending at the ends ends: increasing, 0
  /// and 1 included. Both sides are cut at all of them, so that between two of them the values of
  /// both and of `add_value` are one quadratic in s.
  std::span<const double> breaks(int seam) const {
    return {breaks_.data() + offsets_[seam], std::size_t(offsets_[seam + 1] - offsets_[seam])};
  }

  /// The place of parameter s on the side of half-edge h.
  TexturePlace place(HalfEdge h, double s) const;

  /// Adds the terms of the value σ near parameter s₀ of a seam: the mean of both sides, blended
  /// near either end into the mean over all places of that vertex where more than two meet. Weights
  /// sum to 1; exact for functions that are linear on a flat surface; Lipschitz in s. The same from
  /// both sides. The terms hold between the breaks around s₀; the first two are those of the sides, in the order of
  /// `half_edges`.
  void add_value(int seam, double s0, std::vector<SeamTerm>& value) const;

 private:
  std::span<const TexturePlace> copies(int corner) const;
  void find_vertices();
  void find_breaks();
  void add_end(int seam, double s0, int end, std::vector<SeamTerm>& value) const;
  bool blends(int seam, int end) const;
  double blend_rate(int seam) const;
  TexelPoint end_point(HalfEdge h, int end) const;
  SeamTerm side(HalfEdge h, double s0, double weight) const;

  const Surface& surface_;
  const Atlas& atlas_;
  std::vector<int> seam_;  // per half-edge
  std::vector<HalfEdge> first_, second_;
  std::vector<double> length_;  // of the shorter side, texels
  std::vector<double> breaks_;
  std::vector<int> offsets_;
  std::vector<int> class_;  // per corner: class of shared places, or -1
  std::vector<int> class_offsets_;
  std::vector<TexturePlace> copies_;  // the distinct places of each class
};

}  // namespace mq

#pragma once
/// Tangent vector fields on a texture: one vector per texel, carried from texel to texel and over seams.

#include <array>
#include <complex>
#include <span>
#include <vector>

#include "mq/atlas/atlas.h"
#include "mq/fem/tangent_fields.h"
#include "mq/fem/texel_space.h"
#include "mq/linear/block_multigrid.h"

namespace mq {

/// A tangent plane: its normal, and two axes in it that are a function of the normal alone.
struct TangentPlane {
  Vector3 normal, first, second;

  /// Of any vector but 0, normalised.
  explicit TangentPlane(const Vector3& normal);

  /// The unit complex number that takes components in this plane to those in another one, by the least rotation in space
  /// that takes normal to normal. 1 between opposite planes, for which there is none.
  std::complex<double> turn(const TangentPlane& to) const;

  Vector3 in_space(double x, double y) const { return x * first + y * second; }
};

/// The vector space that goes with a texel space {φ_t} (the open problem of the thesis' chapter 7): a complex number z_t
/// per texel, stored as (z_2t, z_2t+1), its components in the texel's tangent plane. With r_t(p) the turn from there to
/// the plane at p the field is
///
///     X(p) = Σ_t φ_t(p) r_t(p) z_t.
///
/// The plane of a texel is that of the triangles that cover most of the cells around it. On a flat surface all turns are
/// the same number, however it is cut into charts and these are turned, so that constant and linear fields are exact
/// there; on a curved one X is continuous up to the curvature inside a cell, and all below is of second order in its
/// size. Fields that go round along a loop come back turned by the curvature in it, whichever charts it crosses. As the
/// turns are those of the surface in space, so are parallel fields, also where lengths and angles are measured by
/// `TexelSpaceOptions::metrics`.
///
/// Where charts lie upon each other texels have the plane of the one of the earliest turn, as `Texels::chart` has it.
/// 12 bytes per texel.
class TexelVectorSpace {
 public:
  /// All must outlive the object.
  TexelVectorSpace(const Surface& surface, const Atlas& atlas, const TexelSpace& space);

  const TexelSpace& space() const { return *space_; }
  const Surface& surface() const { return *surface_; }
  const Atlas& atlas() const { return *atlas_; }
  int size() const { return space_->size(); }
  TangentPlane plane(int texel) const;
  Vector3 normal(int texel) const;  ///< of that
  TangentPlane plane_of(int triangle) const;  ///< of a triangle of a chart

  /// a·M + b·L by blocks, Hermitian as a matrix of complex numbers, with the pattern of S:
  ///
  ///     M_ij = Σ_e conj(r_i) r_j ∫_e φ_i φ_j dA,   L_ij = Σ_e c_e conj(r_i) r_j ∫_e ⟨∇φ_i, ∇φ_j⟩ dA,
  ///
  /// e the elements of the space and r the turns to the plane of e, the mean of its texels'. ⟨z, M·z⟩ ≈ ∫ |X|², ⟨z, L·z⟩ ≈
  /// ∫ c |∇X|² (the connection Laplacian). M is definite, L semidefinite, each element's part by itself; the null space
  /// of L are parallel fields. No conductivity: c = 1.
  BlockMatrix<double> system(double a, double b, std::span<const float> conductivity = {}) const;

  /// What to solve with in its place: with the trace of smoothness that `TexelSpace::regularised_system` adds to texels
  /// that hardly any point of the surface shows, between vectors carried to each other.
  BlockMatrix<double> regularised_system(double a, double b, std::span<const float> conductivity = {}) const;

  /// Conductivities with which no element couples its texels more than a square cell stretched so many times to one would:
  /// 1 for most.
  std::vector<float> bounded(double stretch) const;

  /// Per element √(∫_e |∇X|² dA / area_e).
  std::vector<float> gradient_norms(const Vector& z) const;

  /// ⟨z, L·z⟩ ≈ ∫ c |∇X|² dA, see `system`.
  double smoothness_energy(const Vector& z, std::span<const float> conductivity = {}) const;

  /// X at a point of a triangle of a chart, in space.
  Vector3 value(const Vector& z, int triangle, const Vector3& barycentric) const;

  /// A vector per triangle, in space: the mean of X over points about a texel apart; 0 without a chart.
  TangentField on_triangles(const Vector& z) const;

  /// The other way: around each texel the mean of the vectors of triangles, by ∫ φ_t dA; at seams those of both sides.
  Vector from_triangles(const TangentField& field) const;

  /// Per texel the unit complex number in its plane along which u grows in its chart, the pictures' way to the right.
  std::vector<std::complex<double>> rightward() const;

  /// A vector per cell of `TexelGrid` in its chart, texels per unit of time to the right and down: X in its middle,
  /// in the chart of the triangle that covers most of it. 0 where no chart is. What `AtlasFlow::along` follows.
  std::vector<std::array<double, 2>> velocities(const Vector& z) const;

  /// ∇ψ as fields, one per channel in columns: around each texel the mean of the gradients in the middle of its cells, by
  /// their area. Of first order; exact for functions linear on a flat surface, but next to seams only where
  /// texels beside the charts go on as these do.
  Signal gradient(const Signal& psi) const;

  /// P of a multigrid cycle: rows of scalar transfers from level to level, with turns. Levels are those that
  /// `TexelSpace::multigrid` has for a·M + b·S; coarse unknowns have the mean plane of those they are made of.
  std::vector<std::shared_ptr<const BlockTransfer>> transfers(double a, double b, const Progress& progress = {}) const;

 private:
  template <class Visit>
  void for_each_energy(const Vector& z, const Visit& visit) const;
  template <class Counts>
  Vector mean_around(const TangentField& field, const Counts& counts) const;

  const Surface* surface_;
  const Atlas* atlas_;
  const TexelSpace* space_;
  std::vector<std::array<float, 3>> normals_;
};

}  // namespace mq

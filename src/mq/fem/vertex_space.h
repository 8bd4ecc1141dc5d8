#pragma once
/// The hat functions of a triangle mesh.

#include <span>
#include <vector>

#include "mq/fem/flat_triangle.h"
#include "mq/fem/space.h"

namespace mq {

/// One unknown per vertex of the surface; φ_i is 1 at vertex i, 0 at the others, linear in each
/// triangle. With |t| the area and θ the angle opposite an edge, per triangle
///
///     M_ii += |t|/6,  M_ij += |t|/12,        S_ij −= ½ cot θ,  S_ii = −Σ_j S_ij.
///
/// Triangles without area take no part. A vertex that only such triangles use, or none, is a
/// component of its own: its row of S is 0, its mass is 10⁻¹² of the mean, so that M + w·S stays
/// definite and a filter leaves its value alone.
///
/// Matrices do not depend on where the surface lies, only on the shapes of its triangles, which may be
/// given: another metric, constant per triangle. Thesis 2.3.2.3.
class VertexSpace final : public SignalSpace {
 public:
  /// With the metric of the surface in space. Throws `InvalidInput` when it has no area.
  explicit VertexSpace(const Surface& surface);
  /// With another metric, a shape per triangle.
  VertexSpace(const Surface& surface, std::vector<FlatTriangle> shapes);

  int size() const override { return int(incident_begin_.size()) - 1; }
  SparseMatrix system(double a, double b, const Progress& progress = {}) const override;
  Signal stiffness_times(const Signal& psi, std::span<const double> beta = {}) const override;

  /// Some rows of `stiffness_times(psi, beta)`, in the order asked for; no rows: all of them. Costs
  /// what those rows cost.
  Signal stiffness_rows(std::span<const int> rows, const Signal& psi,
                        std::span<const double> beta = {}) const;

  Signal edge_divergence(const std::vector<std::array<int, 2>>& edges, const Signal& z) const override;
  Vector lumped_mass() const override;
  SurfaceScale scale() const override { return {.area = area_, .texel_spacing = 0}; }
  std::vector<Vector3> positions() const override { return positions_; }

  /// The vertices of edges with one triangle.
  std::vector<int> boundary() const override { return boundary_; }

  /// The corners of the triangle.
  std::vector<BasisWeight> basis_at(int triangle, const Vector3& barycentric) const override;
  double largest_shown(const Vector& values) const override;
  SolverFactory multigrid(const StoppingRule& stop = {}) const override;

  /// Elements are the triangles.
  int element_count() const override { return triangle_count(); }
  std::vector<float> gradient_norms(const Signal& psi) const override;
  Signal weighted_stiffness_times(const Signal& psi,
                                  std::span<const float> conductivity) const override;
  SparseMatrix weighted_system(double a, double b, std::span<const float> conductivity,
                               const Progress& progress = {}) const override;
  void for_each_mixed_element(std::span<const int> labels,
                              const std::function<void(const Element&)>& visit) const override;

  int triangle_count() const { return int(triangles_.size()); }
  const std::vector<Triangle>& triangles() const { return triangles_; }
  const std::vector<FlatTriangle>& shapes() const { return shapes_; }

  /// Corners 3·triangle + k at a vertex, of triangles with area, ascending.
  const int* corners_begin(int v) const { return incident_.data() + incident_begin_[v]; }
  const int* corners_end(int v) const { return incident_.data() + incident_begin_[v + 1]; }

  /// The pattern of M and S: of each row the vertex and the other corners of its triangles,
  /// ascending.
  const std::vector<int>& row_starts() const { return row_begin_; }
  const std::vector<int>& columns() const { return column_; }

  /// ∇φ, constant per triangle: 2·triangles × channels, rows 2t and 2t + 1 in triangle t's frame.
  Signal gradient(const Signal& phi) const;

  /// ∫ ⟨X, ∇φ_i⟩ dA of a field constant per triangle (2·triangles × channels): size() × channels.
  /// It is the weak form of −div X, with the flux out of the boundary added there; it sums to 0.
  /// gradient_moments(gradient(φ)) = S·φ.
  Signal gradient_moments(const Signal& field) const;

  /// The gradient as a matrix G, 2·triangles × size(): S = Gᵀ·M₁·G, M₁ the area of each triangle.
  SparseMatrix gradient_matrix() const;

 private:
  void find_incident_corners();
  void find_pattern();
  template <class Factor>
  SparseMatrix assemble(double a, const Factor& factor, const Progress& progress) const;
  template <class Factor>
  Signal stiffness_product(std::span<const int> rows, const Signal& psi,
                           const Factor& factor) const;

  std::vector<Triangle> triangles_;
  std::vector<Vector3> positions_;
  std::vector<int> boundary_;
  std::vector<FlatTriangle> shapes_;
  double area_ = 0;
  std::vector<int> incident_begin_;  ///< per vertex where its corners begin in `incident_`
  std::vector<int> incident_;        ///< corners 3·triangle + k, triangles with area only
  std::vector<int> row_begin_;       ///< the pattern of M and S
  std::vector<int> column_;
};

}  // namespace mq

#pragma once
/// The signal space of a texture atlas (thesis 5.5 to 5.7): one unknown per texel, functions
/// bilinear inside charts and continuous across every seam.

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "mq/atlas/atlas.h"
#include "mq/base/defect.h"
#include "mq/fem/space.h"
#include "mq/fem/texels.h"
#include "mq/image/image.h"

namespace mq {

struct TexelSpaceOptions {
  enum class Seams {
    continuous,  ///< thesis 5.5: the same value on both sides
    soft         ///< thesis 5.5.1: bilinear on each side, differences penalised; to compare with
  } seams = Seams::continuous;

  /// Weight of ∫ (φ_left − φ_right)² ds over the seams, soft ones only, per length of the model's
  /// unit; enters the stiffness.
  double seam_penalty = 0;

  /// One metric per triangle, constant on it, in place of the immersion metric (`texel_metric`).
  /// Positive definite with a·c − b² = 1, or `InvalidInput` is thrown.
  std::vector<TexelMetric> metrics;

  /// Per cell of the atlas' `TexelGrid` 1, or 0 for one that is left out, as if no chart were there: what a
  /// part of a space needs of the whole (texel_part.h). Empty: all.
  std::vector<char> cells = {};
};

/// Basis functions φ_t at a few points of one triangle, for integrals nobody foresaw. Row q of each
/// matrix is a point, column k the texel texels[k]; derivatives are per texel of x and y.
struct TexelSamples {
  int triangle = 0;
  std::span<const int> texels;
  Signal values, dx, dy;
  Vector weights;      ///< texels²; times `TexelMetric::density` an area of the surface
  Signal barycentric;  ///< where the points are in the triangle, three columns
};

/// Unknowns are the texels whose function does not vanish everywhere: those with a bilinear
/// footprint on the surface, and those that a seam couples in. Texels that several charts share are
/// one unknown. Σφ_t = 1 everywhere on the charts; φ_t is the bilinear kernel wherever no seam is
/// within a quarter of a texel of the cell; S vanishes on constants, per connected component.
class TexelSpace : public SignalSpace {
 public:
  /// g⁻¹ of a cell between texels, its mean over what charts cover there: the gradient of ψ has the parts
  /// (xx·∂ψ/∂x + xy·∂ψ/∂y, xy·∂ψ/∂x + yy·∂ψ/∂y) in texels, texels²/length². 0 where no chart is.
  struct CellMetric {
    double xx = 0, xy = 0, yy = 0;

    /// ⟨a, b⟩ on the surface, length², of two ways in texels.
    double product(const Vector2& a, const Vector2& b) const {
      return (yy * a.x() * b.x() - xy * (a.x() * b.y() + a.y() * b.x()) + xx * a.y() * b.y()) / (xx * yy - xy * xy);
    }
  };

  /// Surface and atlas must outlive the space. Throws `InvalidInput` when the atlas holds refused
  /// defects (the message lists them) or nothing is left to integrate, and `OutOfMemory` where texels alone would take
  /// more than there is. O(texels + crossings).
  TexelSpace(const Surface& surface, const Atlas& atlas, const TexelSpaceOptions& options = {},
             const Progress& progress = {});
  ~TexelSpace() override;
  TexelSpace(TexelSpace&&) noexcept;

  int size() const override;
  SparseMatrix system(double a, double b, const Progress& progress = {}) const override;
  Signal stiffness_times(const Signal& psi, std::span<const double> beta = {}) const override;

  /// Some rows of `stiffness_times(psi, beta)`, in the order asked for; no rows: all of them. Costs
  /// what those rows cost.
  Signal stiffness_rows(std::span<const int> rows, const Signal& psi,
                        std::span<const double> beta = {}) const;

  /// a·M + b·S + τ (a·texel area + b) Σ (φ_i − φ_j)² over pairs of texels next to each other of
  /// which one is weak: its kernel meets little of the surface, M_tt < 10⁻³ of a texel's area (on
  /// the surface, in the cells around it). Such
  /// texels, alone or together, could take on huge values that no point of the surface shows, and
  /// make columns of M and S nearly dependent; τ = 10⁻⁴ holds them to their neighbours. Same
  /// pattern as `system`; the sum of each row too, so that means are kept.
  SparseMatrix regularised_system(double a, double b, const Progress& progress = {}) const override;
  std::optional<StencilSystem> stencil_system(double a, double b, const Progress& progress = {}) const override;
  Vector lumped_mass() const override;
  SurfaceScale scale() const override;

  /// Elements are the cells of all textures, then the strips within a quarter of a texel of a seam.
  int element_count() const override;
  std::vector<float> gradient_norms(const Signal& psi) const override;

  /// What `regularised_system(a, b)` is the sum of: visit(unknowns, matrix row by row).
  void for_each_summand(double a, double b,
                        const std::function<void(std::span<const int>, std::span<const double>)>& visit) const;

  /// Per element the first of the texels that it couples; −1 where no chart reaches.
  std::vector<int> first_texels() const;

  /// ∫ f φ_t dA / ∫ φ_t dA of an f constant on each element: around each texel its mean.
  Vector means_around(std::span<const float> elements) const;
  Signal weighted_stiffness_times(const Signal& psi,
                                  std::span<const float> conductivity) const override;
  SparseMatrix weighted_system(double a, double b, std::span<const float> conductivity,
                               const Progress& progress = {}) const override;

  /// One per cell of `TexelGrid`. Does not depend on how the surface is cut into triangles.
  std::vector<CellMetric> cell_metrics() const;

  /// Where the unknowns lie in the pictures and on the surface.
  const Texels& texels() const;

  std::vector<Vector3> positions() const override;
  std::vector<int> boundary() const override;

  /// At the centres of texels that triangles cover, at the corners of triangles, along boundaries.
  double largest_shown(const Vector& values) const override;

  SolverFactory multigrid(const StoppingRule& stop = {}) const override;

  /// Charts that overlap, texels that several charts share, pieces too small to matter.
  const Defects& defects() const;

  /// Values of the texels, one picture per texture, all of one channel count; and back. `scatter`
  /// changes no other texel.
  Signal gather(std::span<const Image<float>> pictures) const;
  void scatter(const Signal& signal, std::span<Image<float>> pictures) const;

  /// The triangle must have a chart.
  std::vector<BasisWeight> basis_at(int triangle, const Vector3& barycentric) const override;

  /// The same at a place of a chart: in the cell at this column and row of its texture (wrapped or not where that
  /// repeats), x and y from 0 to 1. Not within triangles of the chart too, where functions go on beside them.
  std::vector<BasisWeight> basis_in(int chart, int column, int row, double x, double y) const;

  /// b_t = ∫ ⟨X, ∇φ_t⟩ dA for a field X constant on each triangle, one vector in space each (its
  /// normal part is ignored). The weak divergence: −∫ (div X) φ_t and flux through boundaries. Sums
  /// to 0. One column per field. It is the change of φ_t along X, whatever the metric, integrated
  /// with the metric's density; so X = ∇ψ gives S·ψ where ∇ is that of the metric: with the
  /// surface's gradient only under the surface's own metric (no `TexelSpaceOptions::metrics`), and
  /// not on triangles stretched beyond `max_stretch`, where S is that of the limit.
  Signal divergence(const std::vector<std::vector<Vector3>>& fields) const;

  /// Pairs (i, j), i < j, of texels that S couples, sorted: the edges of thesis 5.6.
  std::vector<std::array<int, 2>> edges() const;

  Signal edge_divergence(const std::vector<std::array<int, 2>>& edges, const Signal& z) const override;

  /// The same as a matrix, texels × edges: times the differences over edges, (d₀ψ)_ij = ψ_j − ψ_i, it
  /// is S. Costs about 24 entries per piece of a triangle in a cell while it is made.
  SparseMatrix edge_divergence_matrix(const std::vector<std::array<int, 2>>& edges) const;

  /// Calls visit(samples) for the pieces of all triangles, with points and weights of a rule that
  /// is exact where the integrand is a polynomial of degree 4 (products of two bilinear functions
  /// and more); next to seams it defines the matrices. In a fixed order, on the calling thread.
  void for_each_piece(const std::function<void(const TexelSamples&)>& visit) const;

  /// The texels of a seam's other side are not an element's own.
  void for_each_mixed_element(std::span<const int> labels,
                              const std::function<void(const Element&)>& visit) const override;

  /// Lets go of what matrices, products with them and functions are made of, most of the space's memory, once the last of
  /// them is made: until `integrate_again` they throw `InvalidInput`. Nothing is let go of where seams are soft.
  /// None of these may be called while others use the space.
  void let_go_of_integrals() const;

  /// The same, and of what `texels()` has, which a multigrid solver is made with: until `place_again` there are none.
  void let_go_of_texels() const;

  /// Has places in pictures again, so that values can be gathered and scattered; cheap. Of `texels()` the rest is gone.
  void place_again() const;

  /// Has everything again.
  void integrate_again() const;

  /// Bytes held between calls.
  std::int64_t bytes() const;

 private:
  friend class TexelVectorSpace;
  friend class ModulatedStiffness;
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace mq

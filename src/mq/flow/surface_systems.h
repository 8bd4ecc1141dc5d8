#pragma once
/// The quadratic energies that a step of flow minimises, and what solves them.

#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "mq/flow/surface_levels.h"
#include "mq/flow/surface_optical_flow.h"
#include "mq/linear/direct.h"

namespace mq {

/// ∫ Σ_c (δ_c + ⟨Y, ∇μ_c⟩)² dA per triangle as ⟨Y, G·Y⟩ + 2⟨g, Y⟩ + what does not depend on Y. As Y
/// is constant and δ linear in a triangle, the value of δ at the barycentre is exact.
struct DataTerms {
  struct Triangle {
    double xx = 0, xy = 0, yy = 0, x = 0, y = 0;  ///< G and g, in the triangle's frame
  };
  std::vector<Triangle> triangles;
  double trace = 0;  ///< Σ tr G = Σ_c ∫ |∇μ_c|² dA

  /// ⟨g, Y⟩ and ⟨Y, G·Y⟩ of a field constant per triangle.
  std::array<double, 2> products(const Vector& Y) const;

  /// With c·Ḡ·∫ |Y|² dA added to the energy, Ḡ = trace / area and c = 10⁻³. Where a scan has come apart
  /// into pieces of a few triangles smoothness says nothing, and a difference of light over hardly
  /// any slope would move such a piece by any distance.
  DataTerms held(const std::vector<FlatTriangle>& shapes, double area) const;
};

/// `gradient_of` is μ; with `field` differences count less the larger they are there:
/// 1/√(1 + (δ_c + ⟨Y, ∇μ_c⟩)²/ϵ²).
DataTerms data_terms(const VertexSpace& space, const Signal& difference, const Signal& gradient_of,
                     double robust = 0, const Vector* field = nullptr);

/// D + weight·S in the vertex basis as blocks, and b = −Pᵀg. `shares` scales the smoothness of each
/// triangle; empty: 1.
struct VertexSystem {
  BlockMatrix<double> matrix;
  Vector right_hand_side;
};
VertexSystem vertex_system(const FlowMesh& mesh, const DataTerms& data, double weight,
                           const std::vector<double>& shares = {});

/// Per triangle 1/√(1 + |∇Y|²/ϵ²).
std::vector<double> smoothness_shares(const FlowMesh& mesh, const Vector& z, double robust);

/// ⟨z, S·z⟩ of the vertex basis, each triangle's part as often as `shares` says; empty: 1.
double smoothness_energy(const FlowMesh& mesh, const Vector& z, const std::vector<double>& shares = {});

/// What solving one system by a factorisation took.
struct FlowSystemCost {
  std::int64_t unknowns = 0;
  std::int64_t smoothness_entries = 0, entries = 0;  ///< nonzero, of S and of the whole matrix
  double build_seconds = 0, analyse_seconds = 0;     ///< no analysis where one could be kept
  double factor_seconds = 0, substitute_seconds = 0;

  double solve_seconds() const { return analyse_seconds + factor_seconds + substitute_seconds; }
};

/// Any basis, by a factorisation: the minimiser as a vector per triangle.
class DirectFlowSolver {
 public:
  DirectFlowSolver(const FlowMesh& mesh, FlowBasis basis,
                   const std::optional<ThesisFlow>& thesis = {});

  /// PᵀGP + weight·S, or as the thesis weighs it. The weight is for a field in model units. The
  /// first time `analysed` is told of the solver before anything is factored.
  Vector solve(const DataTerms& data, double weight, const Progress& progress = {},
               const std::function<void(const DirectSolver&)>& analysed = {});

  /// Of the last `solve`.
  const FlowSystemCost& cost() const { return cost_; }
  const Vector& coefficients() const { return coefficients_; }
  /// ⟨Y, S·Y⟩ as it was weighed then.
  double smoothness_term() const { return weight_ * smoothness_energy(coefficients_); }

  /// Coefficients are those of the basis.
  Eigen::Index size() const { return smoothness_.rows(); }
  /// The field, a vector per triangle.
  Vector field(const Vector& coefficients) const { return prolongation_ * coefficients; }
  /// What comes near to a complex number per vertex. Not for the gradient basis, whose coefficients are potentials.
  Vector coefficients_of(const Vector& at_vertices) const;
  double smoothness_energy(const Vector& coefficients) const { return coefficients.dot(smoothness_ * coefficients); }

 private:
  const FlowMesh& mesh_;
  FlowBasis basis_;
  std::optional<ThesisFlow> thesis_;
  SparseMatrix prolongation_, transposed_, smoothness_, pins_;
  SparseMatrix circulation_;  ///< of the Whitney basis: its coefficients for a field at vertices
  std::optional<DirectSolver> factor_;
  FlowSystemCost cost_;
  Vector coefficients_;  ///< of the last solution
  double weight_ = 0;    ///< of smoothness in it
};

}  // namespace mq

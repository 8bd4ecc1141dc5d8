#pragma once
/// Optical flow between two signals at the vertices of one mesh (thesis chapter 4 [prada_thesis],
/// first in [prada2016motion]).

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "mq/base/progress.h"
#include "mq/flow/flow_options.h"
#include "mq/linear/matrix.h"
#include "mq/mesh/surface.h"
#include "mq/trace/trace_mesh.h"

namespace mq {

class FlowMesh;
class FlowMeshes;

/// Where a field has its coefficients, and what measures its smoothness (thesis 4.5).
enum class FlowBasis {
  vertex,    ///< one complex number per vertex; connection Laplacian
  triangle,  ///< a vector per triangle; VectorDifferences, between circumcentres but for the
             ///< thesis'
  gradient,  ///< ∇φ_i and J∇φ_i, the latter not on a boundary; CurlAndDiv; no harmonic fields
  whitney    ///< one number per edge; Hodge Laplacian
};

enum class FlowSolver {
  hierarchical,  ///< each scale on the coarsest mesh that shows it, in the vertex basis by multigrid over coarser and
                 ///< coarser meshes, in the others by a factorisation per step; not with the thesis' weights
  direct         ///< a factorisation per step, every scale on the mesh itself
};

/// The published weights and normalisations (thesis 4.4 to 4.6 and what its program does): each
/// channel's details are brought back to its own variance, the data matrix is divided by its
/// Frobenius norm, smoothness counts half, the surface has area 1; the smoothing weight is a
/// quarter of the last level's; one full step per level, whatever the error does.
struct ThesisFlow {
  double epsilon = 1e4;  ///< weight of smoothness; of the vertex basis: that of the triangle basis
                         ///< with its data matrix
};

/// What factorisations on the mesh itself will take, known once the first matrix is analysed.
struct FlowForecast {
  std::int64_t unknowns = 0;
  int factorisations = 0;  ///< at most: a level ends early where a step gains little
  double seconds = 0;      ///< of one of them, within about a factor of two
  std::int64_t bytes = 0;  ///< of one of them, beside all else
};

struct MeshFlowOptions : FlowOptions {
  /// Of each level twice as many steps on coarser meshes, where they cost little. Weights of
  /// smoothness are ℓ²·Ḡ, signals are smoothed by Smooth(φ, ½ℓ²). `smallest` 0: two spacings of the
  /// vertices. `tolerance` is the multigrid solver's.
  MeshFlowOptions()
      : FlowOptions{.detail = {1, Length::Unit::percent},
                    .largest = {10, Length::Unit::percent},
                    .smallest = {0, Length::Unit::model},
                    .steps = 3,
                    .least_gain = 0.05,
                    .tolerance = 1e-3} {}

  FlowBasis basis = FlowBasis::vertex;
  FlowSolver solver = FlowSolver::hierarchical;
  int levels =
      0;  ///< 0: as many as lie between; else so many from `largest` on, all smoothed, but none below `smallest`
  /// At how many places, at least, errors of fields on coarser meshes are taken, see `MeshFlow`.
  int probes = 25000;
  std::optional<ThesisFlow> thesis;
  std::function<void(const FlowForecast&)> foresee;  ///< told once, before the first factorisation on the mesh itself

  bool is_factored() const { return solver == FlowSolver::direct || basis != FlowBasis::vertex; }
};

/// The thesis' seven levels with the weight it states for the basis (4.6.2).
MeshFlowOptions thesis_flow(FlowBasis basis);

/// One level, from large to small; errors are those of `MeshFlow`.
struct MeshFlowLevel : FlowLevel {
  int vertices = 0;  ///< of the mesh it was solved on
  int unknowns = 0;
  double scale = 0;  ///< α* of the last step, (4.8)
  /// E(Y) − E(0) of the last correction Y that was solved for, by its two terms, weights as they were then.
  struct Change {
    double data = 0;        ///< ⟨Y, D·Y⟩ + 2⟨d, Y⟩: below 0
    double smoothness = 0;  ///< ℓ²·Ḡ·⟨Y, S·Y⟩
  } change;
  double smoothness = 0;  ///< ⟨X, S·X⟩ ≈ ∫ |∇X|² dA of X at the end of the level, per area: a number without a unit
  double smooth_seconds = 0, build_seconds = 0, solve_seconds = 0, warp_seconds = 0;
};

/// The field and how it came about.
///
/// Errors are ∫ Σ_c |φ₀(p − X/2) − φ₁(p + X/2)|² dA / (area · channels) of the prepared signals,
/// unsmoothed, on the mesh itself (thesis (4.27) at t = ½): those without light, each brought to
/// variance 1. Of fields on coarser meshes the error is taken at the vertices of one of them
/// that has `MeshFlowOptions::probes` or more, along paths on the mesh itself, as a share of the
/// blend's there: within a few percent of what all vertices would say, at a fraction of the time.
/// Before the first level on the mesh itself, and at the end, the best such field is measured at
/// all vertices; it stays only if its error is below the blend's, and no earlier level's is then
/// listed as lower.
///
/// Within a level a step is taken as far as the error of that level falls (1, ½ or ¼ of α*). Of all
/// fields at the ends of levels the best is returned, so the list never rises. A level that did not
/// lower the error may yet have been on the way to a large motion: the next one goes on from its
/// field or from the best so far, whichever has the lower error at its own scale. (The thesis takes
/// every step whole and returns the last field; its errors are of that.)
struct MeshFlow {
  Vector field;            ///< X: 2 per triangle in its frame (`FlatTriangle`), model units
  double blend_error = 0;  ///< with X = 0
  std::vector<MeshFlowLevel> levels;
  double prepare_seconds = 0;  ///< meshes, operators and signals
  double seconds = 0;

  std::vector<double> errors() const;  ///< the blend's, then after each level
};

/// Finds X with φ₀(p − X/2) ≈ φ₁(p + X/2), where p ± X/2 is the end of the path from p along ±X for
/// half a unit of time. Per level
///
///     E(Y) = Σ_c ∫ ψ((δ_c + ⟨Y, ∇μ_c⟩)²) dA + ℓ²·Ḡ·∫ ψ(|∇Y|²) dA,   Ḡ = Σ_c ∫ |∇μ_c|² dA / area,
///
/// with δ the difference and μ the mean of the signals as warped so far, is minimised a few times,
/// and X ← X + α*Y with the α* ≥ 1 that minimises the first term (thesis 4.2.2). ℓ is a length: the
/// same number means the same at any resolution, in any unit and any range of values.
///
/// `source` and `target` have a row per vertex, any number of channels. Throws `InvalidInput` on
/// sizes that differ, values that are not finite (naming the first), lengths that are not positive,
/// `Unsupported` for the thesis' weights over coarser meshes: they mean another smoothness on each.
MeshFlow mesh_flow(const Surface& surface, const Signal& source, const Signal& target,
                   const MeshFlowOptions& options = {}, const Progress& progress = {});

/// The same for many pairs on one surface, whose coarser meshes are made once. Surface must outlive
/// it. Throws as `mesh_flow` does: what is about options when it is made, what is about signals
/// when they come.
class MeshFlowFinder {
 public:
  explicit MeshFlowFinder(const Surface& surface, const MeshFlowOptions& options = {},
                          const Progress& progress = {});
  ~MeshFlowFinder();
  MeshFlowFinder(MeshFlowFinder&&) noexcept;

  /// `prepare_seconds` of the result are those of the signals alone.
  MeshFlow operator()(const Signal& source, const Signal& target,
                      const Progress& progress = {}) const;

  const FlowMesh& finest() const;  ///< surface_levels.h

 private:
  MeshFlowOptions options_;
  std::unique_ptr<const FlowMeshes> meshes_;
};

/// The signal at time t between 0 (the source) and 1 (the target), thesis (4.26):
///
///     (1 − t)·φ₀(Φ_{−X}(p, t)) + t·φ₁(Φ_X(p, 1 − t)).
///
/// For any signals on the mesh, prepared or not. At t = 0 and 1 they come back bit for bit.
Signal interpolate(const TraceMesh& mesh, const Vector& field, const Signal& source,
                   const Signal& target, double t, const Progress& progress = {});

/// φ₀ and φ₁ as they meet at time t: φ₀(Φ_{−X}(p, t)) and φ₁(Φ_X(p, 1 − t)).
struct WarpedPair {
  Signal source, target;
};
WarpedPair warp_pair(const TraceMesh& mesh, const Vector& field, const Signal& source,
                     const Signal& target, double t, const Progress& progress = {});

}  // namespace mq

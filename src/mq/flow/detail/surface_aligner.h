#pragma once
/// Two signals at the vertices of a mesh, aligned level by level on it and on coarser ones.

#include <vector>

#include "mq/flow/detail/level_aligner.h"
#include "mq/flow/surface_levels.h"
#include "mq/flow/surface_systems.h"

namespace mq {

/// X or a correction Y: two components per triangle, and the coefficients z of the basis. Where systems are factored only
/// the former are brought within reach; the latter say how smooth X is.
struct SurfaceField {
  Vector field, z;
};

/// The surface as `coarse_to_fine` sees it: each level is worked on on the coarsest mesh that shows
/// it. Meshes and options must stay.
class SurfaceAligner final : public LevelAligner<SurfaceField, SurfacePoint> {
 public:
  /// Prepares the signals: without what varies more slowly than `detail` (model units), brought to
  /// scale.
  SurfaceAligner(const FlowMeshes& meshes, const MeshFlowOptions& options, const Signal& source,
                 const Signal& target, double detail);

  /// Puts X = 0 on the mesh of the first scale.
  void begin(const std::vector<FlowScale>& scales);

  FlowLevel& enter(const FlowScale& scale) override;
  int most_steps() const override;
  double correct(const Progress& progress, double share) override;

  Vector take_field() { return std::move(best_.field); }

 private:
  int resolution_of_field(const FlowScale& scale) const override;
  const Vector& masses(int m) const override { return meshes_[m].lumped_mass(); }
  SurfaceField zero(int m) const override;
  Ends ends_along(int m, const SurfaceField& X, const std::vector<SurfacePoint>* starts) const override;
  Signal looked_up(int m, const Signal& signal, const std::vector<SurfacePoint>& places) const override;
  void place_probes(Probes& probes) const override;
  SurfaceField prolongated(int m, const SurfaceField& X) const override;
  void complete(int m, SurfaceField& X) const override;
  void advance(SurfaceField& X, double factor, const SurfaceField& Y) const override;
  void keep_within_reach() override;
  double smoothness_of(const SurfaceField& X) const override;

  const FlowMesh& mesh() const { return meshes_[at_]; }
  bool is_robust() const;
  int most_reweightings() const;
  SurfaceField corrected(const DataTerms& terms, double weight, const std::vector<double>& shares,
                         const Progress& progress);
  SurfaceField estimate(double& scale, const Progress& progress);
  void foresee(const DirectSolver& solver) const;

  const FlowMeshes& meshes_;
  std::vector<DirectFlowSolver> direct_;  ///< one per mesh, where systems are factored
  int factorisations_ = 0;                ///< on the finest mesh, at most
};

}  // namespace mq

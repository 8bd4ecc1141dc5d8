#pragma once
/// Two signals at the vertices of a mesh, aligned level by level on it and on coarser ones.

#include <optional>
#include <string>
#include <vector>

#include "mq/flow/detail/coarse_to_fine.h"
#include "mq/flow/detail/surface_warp.h"
#include "mq/flow/surface_levels.h"
#include "mq/flow/surface_optical_flow.h"
#include "mq/flow/surface_systems.h"

namespace mq {

/// The surface as `coarse_to_fine` sees it: each level is worked on on the coarsest mesh that shows
/// it. See `MeshFlow` for what errors are. Meshes and options must stay.
class SurfaceAligner final : public FlowDomain {
 public:
  /// Prepares the signals: without what varies more slowly than `detail` (model units), brought to
  /// scale.
  SurfaceAligner(const FlowMeshes& meshes, const MeshFlowOptions& options, const Signal& source,
                 const Signal& target, double detail);

  /// Puts X = 0 on the mesh of the first scale.
  void begin(const std::vector<FlowScale>& scales);

  std::string name(const FlowScale& scale) const override;
  double work(const FlowScale& scale) const override;
  double blend_error() const override { return blend_error_; }
  FlowLevel& enter(const FlowScale& scale) override;
  void go_back_if_better() override;
  void look_up() override;
  double level_error() const override { return error_; }
  int most_steps() const override;
  double correct(const Progress& progress, double share) override;
  FlowErrorChange attempt(double factor) override;
  void take() override;
  void leave() override;
  double measure() override;
  void keep() override;
  void forget() override;
  std::optional<double> settled_error() override;
  void finish() override;

  Vector take_field() { return std::move(best_.field); }
  std::vector<MeshFlowLevel> take_levels() { return std::move(levels_); }

 private:
  struct Pair {
    Signal source, target;
  };

  /// X or a correction Y on the mesh at hand: per triangle, and in the vertex basis (hierarchical
  /// only).
  struct Field {
    Vector field, z;
  };

  /// Points of the finest mesh at which errors of fields on coarser ones are taken.
  struct Probes {
    std::vector<SurfacePoint> starts;
    Vector mass;
    double blend_error = 0;
  };

  int mesh_for(const FlowScale& scale) const;
  const FlowMesh& mesh() const { return meshes_[mesh_]; }
  WarpEnds ends_along(const Field& X) const;
  Pair warped(const Pair& pair, const WarpEnds& ends) const;
  double error_of(int m, const Pair& pair, const WarpEnds& ends) const;
  void place_probes();
  double probe(const WarpEnds& ends) const;
  double error_from_coarse(Vector z) const;
  bool is_robust() const;
  int most_reweightings() const;
  Field corrected(const DataTerms& terms, double weight, const std::vector<double>& shares,
                  const Progress& progress);
  Field estimate(double& scale, const Progress& progress);
  void advance(double factor);
  void keep_within_reach();
  void move_to(int m);

  const MeshFlowOptions& options_;
  const FlowMeshes& meshes_;
  std::optional<DirectFlowSolver> direct_;
  std::vector<Pair> raw_;  ///< prepared signals, per mesh
  double blend_error_ = 0;
  int corrections_ = 0;  ///< by the direct solver, at most
  Probes probes_;

  int mesh_ = 0;      ///< the one at hand
  Field now_, best_;  ///< X there, and the one of the least error on the finest mesh
  bool same_ = true;  ///< they are the same, and `ends_` those of both
  bool estimated_ = false;  ///< the error of the best, at the probes
  WarpEnds ends_;           ///< of paths along X

  std::vector<MeshFlowLevel> levels_;
  double length_ = 0;  ///< ℓ of the level
  Pair signals_;       ///< at the level
  Pair met_;           ///< looked up along X
  double error_ = 0;   ///< of these
  std::optional<BlockMultigrid> multigrid_;

  Field Y_;             ///< the correction at hand
  double factor_ = 0;   ///< of it in X, while it is tried
  WarpEnds next_ends_;  ///< then
  Pair next_;
  double next_error_ = 0;
};

}  // namespace mq

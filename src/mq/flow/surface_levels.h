#pragma once
/// Meshes of one surface from fine to coarse, and how signals and fields go between them.

#include <memory>
#include <vector>

#include "mq/fem/vertex_frames.h"
#include "mq/fem/vertex_space.h"
#include "mq/linear/block_multigrid.h"
#include "mq/mesh/coarsen.h"
#include "mq/trace/trace_mesh.h"

namespace mq {

/// A mesh with what flow asks of it. Fields have a complex number z per vertex in its frame.
class FlowMesh {
 public:
  explicit FlowMesh(const Surface& surface, const Progress& progress = {});

  int vertex_count() const { return space_.size(); }
  double area() const { return space_.scale().area; }
  double spacing() const { return spacing_; }  ///< of vertices on a regular mesh of as many
  const Surface& surface() const { return surface_; }
  const VertexSpace& space() const { return space_; }
  const TraceMesh& trace() const { return trace_; }
  const VertexFrames& frames() const { return frames_; }
  const Vector& lumped_mass() const { return mass_; }

  /// cos and sin of `VertexFrames::into_triangle`, per corner.
  const std::vector<std::array<double, 2>>& turns() const { return turns_; }

  /// Per half-edge, its triangle's half of the weight max(0, ½(cot α + cot β)), and cos and sin of
  /// `VertexFrames::along`.
  const std::vector<double>& edge_weights() const { return edge_weights_; }
  const std::vector<std::array<double, 2>>& edge_turns() const { return edge_turns_; }

  /// A vector per triangle, in its frame: the mean of its corners'.
  Vector triangle_field(const Vector& z) const;
  /// A complex number per vertex: the mean of the triangles around it, by area.
  Vector vertex_field(const Vector& X) const;

  /// Twice the diagonal of the box around a vertex' piece of the surface: paths end at the border of
  /// their piece, so what is longer says nothing.
  double reach(int v) const { return reach_[v]; }

  /// Tangent frame of a vertex in space: normal and first axis; 0 where no triangle has area.
  const Vector3& normal(int v) const { return normals_[v]; }
  const Vector3& axis(int v) const { return axes_[v]; }

 private:
  const Surface& surface_;
  VertexSpace space_;
  TraceMesh trace_;
  VertexFrames frames_;
  Vector mass_;
  double spacing_ = 0;
  std::vector<std::array<double, 2>> turns_;
  std::vector<double> edge_weights_;
  std::vector<std::array<double, 2>> edge_turns_;
  std::vector<Vector3> normals_, axes_;
  std::vector<double> reach_;
};

/// Meshes of one surface, each with about twice the spacing of the one before.
class FlowMeshes {
 public:
  /// Down to about `coarsest` vertices; `surface` must outlive the object.
  FlowMeshes(const Surface& surface, int coarsest, const Progress& progress = {});

  int count() const { return int(meshes_.size()); }
  const FlowMesh& operator[](int m) const { return *meshes_[m]; }

  /// Coefficients on mesh m for those on mesh m + 1: z_i = Σ_j w_ij·r_ij·z_j, with places and
  /// weights of `CoarsenedSurface`, vectors turned as their normals turn.
  const std::shared_ptr<const BlockTransfer>& transfer(int m) const { return transfers_[m]; }

  /// Mean values of a signal on mesh m around the vertices of mesh m + 1.
  Signal restricted(int m, const Signal& signal) const;
  /// A signal on mesh m + 1 at the vertices of mesh m.
  Signal prolongated(int m, const Signal& signal) const;

  /// Per vertex of mesh m that vertex of the finest mesh which it is.
  std::vector<int> on_finest(int m) const;

  /// From mesh m on, as many as there are.
  std::vector<std::shared_ptr<const BlockTransfer>> transfers_from(int m) const;

 private:
  std::vector<std::unique_ptr<CoarsenedSurface>> coarser_;  ///< mesh m + 1, as made of mesh m
  std::vector<std::unique_ptr<FlowMesh>> meshes_;
  std::vector<std::shared_ptr<const BlockTransfer>> transfers_;
};

}  // namespace mq

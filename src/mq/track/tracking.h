#pragma once
/// A template that follows a surface from frame to frame, each a mesh of its own (thesis 6.3.1; Li,
/// Sumner, Pauly, Global correspondence optimization for non-rigid registration of depth scans,
/// 2008; colours as in thesis 4.8.2).

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "mq/base/length.h"
#include "mq/base/progress.h"
#include "mq/linear/matrix.h"
#include "mq/mesh/closest_point.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/surface.h"

namespace mq {

/// A mesh fit to be tracked with: vertices welded, triangles that use a vertex twice and parts of
/// less than `least_part` of the area left out, until there are none. Vertices no triangle uses are
/// gone; `source_from_vertex` says which are left. Throws `InvalidInput` where nothing is left.
struct CleanMesh {
  Mesh mesh;
  std::vector<int> source_from_vertex;
  std::vector<int> source_from_triangle;
  Defects defects;  ///< of the mesh as it was: what `make_surface` finds
};
CleanMesh cleaned(const Mesh& mesh, double least_part = 1e-3);

/// A frame to follow, prepared.
class TrackTarget {
 public:
  /// `colours` have a row per vertex of the mesh, or none at all; `measured` 1 per vertex that is
  /// asked for its distance (`surface_distance`), or none at all: all are.
  explicit TrackTarget(const Mesh& mesh, const Signal& colours = {},
                       const std::vector<char>& measured = {});

  const Surface& surface() const { return surface_; }
  const std::vector<Vector3>& normals() const { return normals_; }  ///< of vertices
  const Signal& colours() const { return colours_; }
  const ClosestPointFinder& closest() const { return *closest_; }
  double diagonal() const { return diagonal_; }
  /// Vertices that are asked for their distance, from the lowest on.
  const std::vector<int>& measured() const { return measured_; }
  /// Per triangle of the surface that of the mesh it was made of, which was `cleaned`; and what was
  /// found of that.
  const std::vector<int>& source_from_triangle() const { return source_from_triangle_; }
  const Defects& defects() const { return defects_; }

 private:
  Surface surface_;
  std::vector<Vector3> normals_;
  Signal colours_;
  std::unique_ptr<ClosestPointFinder> closest_;
  double diagonal_ = 0;
  std::vector<int> measured_;
  std::vector<int> source_from_triangle_;
  Defects defects_;
};

/// Positions of a tracked mesh without what is folded over (`unfolded`); what moved with that is
/// brought back onto the target, where this faces alike and no fold comes of it.
std::vector<Vector3> unfolded_onto(const TrackTarget& target, Mesh mesh);

/// Where 95 % of the points are not within this part of the diagonal of the target, a frame is followed
/// again, from where lengths along both surfaces say that its points are (`recognised_positions`); unless
/// 95 % of those of one surface are within half of it: what the other one has besides, such as a handle, was
/// not lost.
inline constexpr double lost_distance = 0.01;

/// How much stiffer a graph usually begins than it ends.
inline constexpr double first_over_last_stiffness = 1000;

struct TrackOptions {
  double node_spacing = 0.05;  ///< of the graph, in √area of the template
  /// Of the graph's edges against the data, from the first to the last level: see
  /// `DeformationGraph::gauss_newton_step`.
  double last_stiffness = 0.03;
  double first_stiffness = first_over_last_stiffness * last_stiffness;
  int levels = 4;
  int iterations = 5;  ///< of each level, at most
  /// How much of the rest shape is kept in each frame, 0 to 1; the rest is that of the last.
  double elasticity = 0.1;
  double most_angle = 60;  ///< degrees between normals that may correspond
  /// Weights α of the screened Poisson equation that brings vertices onto the surface, one pass
  /// each, on the surface scaled to area 1.
  std::vector<double> snaps{1e-3, 1e-4, 1e-5};
  enum class Prediction { none, constant_velocity } prediction = Prediction::constant_velocity;
  int colour_cycles = 0;        ///< of registration by colour; 0: geometry alone
  double colour_weight = 1;     ///< of their pull along the surface, against that of distances
  double colour_stiffness = 1;  ///< of the graph's edges while colours pull
  /// How far flow of colours looks, and how smooth it is in the end.
  Length colour_largest{10, Length::Unit::percent};
  Length colour_smallest{6, Length::Unit::percent};
};

/// Distances as fractions of the diagonal of the target's bounding box, of the vertices of each to
/// the surface of the other (of the target those that are `measured`): the larger of both ways.
struct SurfaceDistance {
  double mean = 0, p95 = 0, max = 0;
};
SurfaceDistance surface_distance(const Mesh& tracked, const TrackTarget& target);

/// The same where closest points are known: of the tracked vertices on the target, and of all of the target's vertices
/// on what is tracked.
SurfaceDistance surface_distance(const std::vector<ClosestPoint>& there, const std::vector<ClosestPoint>& back,
                                 const TrackTarget& target);

/// The smaller of both ways, number by number: what one of the surfaces has and the other has not does not count.
SurfaceDistance mutual_distance(const std::vector<ClosestPoint>& there, const std::vector<ClosestPoint>& back,
                                const TrackTarget& target);

/// What has become of the triangles: max(σ₁, 1/σ₂) of the map from their rest shape, σ₁ ≥ σ₂
/// its singular values; 1: unchanged. Mean and 95th percentile by area at rest.
struct Distortion {
  double mean = 1, p95 = 1;
};
Distortion distortion(const std::vector<Triangle>& triangles, std::span<const Vector3> rest,
                      std::span<const Vector3> now);

struct TrackedFrame {
  std::vector<Vector3> positions;
  SurfaceDistance distance;
  Distortion distortion;
  double matched = 0;      ///< share of the area whose closest points were accepted in the end
  bool predicted = false;  ///< whether the constant velocity was nearer than standing still
  /// Whether closest points alone had lost it, by more than `lost_distance`, and what was recognised by
  /// lengths along the surfaces brought it nearer.
  bool recognised = false;
  bool known = false;  ///< whether the motion was known (`SurfaceTracker::follow_known`)
  struct Seconds {
    double correspond = 0, solve = 0, colour = 0, snap = 0, measure = 0, total = 0;
  } seconds;
};

/// Follows one template. Nothing but positions is carried from frame to frame, so that a run can go
/// on from any frame.
class SurfaceTracker {
 public:
  /// `rest` is the template as it was made; `colours` have a row per vertex, or none at all.
  /// Throws `InvalidInput` where the mesh has no area.
  SurfaceTracker(const Mesh& rest, const Signal& colours = {}, const TrackOptions& options = {});
  ~SurfaceTracker();

  int node_count() const;

  /// The template, now at `current`, deformed to lie on the target; `previous` are the positions of
  /// the frame before, empty where there are none. Throws `InvalidInput` on sizes that do not fit.
  TrackedFrame follow(std::span<const Vector3> current, std::span<const Vector3> previous,
                      const TrackTarget& target, const Progress& progress = {});

  /// The same where it is known that the template, now at `current`, moved to `moved`: that is brought onto the target
  /// as the end of `follow` does, with some of the rest shape. Where colours are used it goes half of the way that they
  /// say before, in one registration whatever `colour_cycles`. The graph is not pulled onto the target step by step,
  /// which is what takes the time.
  TrackedFrame follow_known(std::span<const Vector3> current, std::vector<Vector3> moved, const TrackTarget& target,
                            const Progress& progress = {});

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace mq

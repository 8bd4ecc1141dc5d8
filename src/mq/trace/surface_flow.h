#pragma once
/// Integral curves on a mesh of a field that is constant on each triangle, without steps, and
/// signals carried along them.

#include <span>
#include <vector>

#include "mq/base/progress.h"
#include "mq/linear/matrix.h"
#include "mq/mesh/surface_point.h"
#include "mq/trace/path_counts.h"
#include "mq/trace/trace_mesh.h"

namespace mq {

/// Where paths end, and what they did on the way.
struct Traced {
  std::vector<SurfacePoint> ends;
  PathCounts counts;
};

/// A signal as it is found at the ends of paths that begin at the vertices.
struct Advected {
  Signal signal;
  PathCounts counts;
};

/// A field X constant on each triangle, prepared to be followed: dp/dt = X(p). Inside triangles
/// paths are straight; all of the following is exact to rounding, no step is chosen anywhere.
///
/// - **Edges.** A path goes through an edge behind which the field leads on. Where it leads back (or
///   along the edge), the path slides along it with the combination of both vectors that has no
///   part across (Filippov [filippov1988discontinuous]), until the edge ends. Where the field leads
///   away from an edge on both sides, a path that begins on it takes the side with the longer
///   vector, of equal ones (to 10⁻⁹: rounding must not decide) the triangle first in the order of
///   `TraceMesh`.
/// - **Vertices.** Of the triangles around into which their own vector, placed at the vertex, points,
///   and of the edges that paths slide along away from it, the fastest is taken; of equally fast
///   ones (to 10⁻⁹) that of the first triangle in the file. If there is none the path has come to
///   rest.
/// - **Boundaries** (also edges that the surface was cut along because they are not manifold, and
/// those
///   of triangles without area): the path slides along with the part of X along the edge. It rests
///   where that is 0, and otherwise is treated as at any vertex at the edge's end.
/// - Triangles where X is 0 are places of rest. A path that begins in a triangle without area, or
/// at a
///   vertex that no triangle with area uses, rests where it is.
///
/// For X = −∇P, P linear on triangles (`downhill`), the part of X along an edge is the same from
/// both sides, so that sliding needs no combination. P then falls strictly along every path; paths
/// are finite, never meet themselves, and come to rest at vertices that are minima of P among their
/// neighbours (or where P is constant on a whole edge or triangle). No path can turn around a
/// vertex for ever, as P is a function. Among paths of other fields some go round for ever:
/// of whole turns, back to the same place to 10⁻⁹, only the time is counted, so that they end where
/// they should. Paths that wind for ever without closing, and those that go round for a time that is
/// infinite, are stopped, after 2²⁴ crossings at most, and counted in `PathCounts::cut_short`.
class SurfaceFlow {
 public:
  /// X = −∇P of values at the vertices of the surface that `mesh` was made of; the mesh must
  /// outlive the flow. Throws `InvalidInput` where P has the wrong size or is not finite.
  static SurfaceFlow downhill(const TraceMesh& mesh, const Vector& potential);

  /// Any field: rows 2t and 2t + 1 in triangle t's frame (`FlatTriangle`), of the surface's
  /// triangles; model units per unit of time.
  static SurfaceFlow along(const TraceMesh& mesh, const Vector& field);

  /// Follows each start for `time` (not negative, may be infinite). Paths are worked on in the
  /// order of the mesh, whatever the order of the starts. Throws `InvalidInput` on starts that are
  /// no points of the surface.
  Traced trace(std::span<const SurfacePoint> starts, double time,
               const Progress& progress = {}) const;

  /// The same from every vertex of the surface, in its order; no triangle for one that none uses.
  Traced trace_vertices(double time, const Progress& progress = {}) const;

  /// φ′_i = φ(end of the path from vertex i), linear between vertices; a row per vertex of the
  /// surface, any number of channels. No value lies outside those at the corners of the triangle it
  /// is taken from, so none leaves the signal's range; a path that rests at its vertex leaves its
  /// values alone bit for bit. About 20 ns per triangle crossed and thread. Thesis 3.3.2 (Advect).
  Advected advect(const Signal& signal, double time, const Progress& progress = {}) const;

  const TraceMesh& mesh() const { return *mesh_; }

  // What `walk::follow` asks for.
  std::array<double, 3> rates(int t) const {
    const Record& r = records_[t];
    return {-(r.rate1 + r.rate2), r.rate1, r.rate2};
  }
  int leave(int t, int k) const { return records_[t].leave[k]; }
  int across(int t, int k) const { return mesh_->across(t, k); }
  double slide_rate(int t, int k) const { return slide_rates_[t][k]; }
  int exit(int t, int k) const { return exits_[mesh_->corners(t)[k]]; }
  double speed(int t) const;
  void prefetch(int t) const { __builtin_prefetch(&records_[t]); }

 private:
  /// How fast the weights of corners 1 and 2 change (that of corner 0: so that all sum to 0), and
  /// `TraceMesh::across` where a path goes through the edge opposite a corner, −1 where it slides.
  struct alignas(32) Record {
    double rate1 = 0, rate2 = 0;
    std::array<int, 3> leave{-1, -1, -1};
  };

  explicit SurfaceFlow(const TraceMesh& mesh) : mesh_(&mesh) {}
  template <class SlideRate>
  void finish(const SlideRate& slide_rate);
  int find_exit(int v) const;

  const TraceMesh* mesh_;
  std::vector<Record> records_;
  std::vector<std::array<double, 3>> slide_rates_;  ///< of the weight of corner k + 2 on edge k
  std::vector<int> exits_;                          ///< per vertex, see walk::exit_code
};

/// Throws `InvalidInput` naming the first of these that is no point of the surface.
void require_points(const TraceMesh& mesh, std::span<const SurfacePoint> points);

}  // namespace mq

#pragma once
/// What is known of a template beside where it is, carried from one segment to the next.

#include <array>
#include <span>
#include <vector>

#include "mq/evolving/evolving_mesh.h"
#include "mq/remesh/remesh.h"
#include "mq/track/track_truth.h"
#include "mq/track/tracking.h"

namespace mq {

struct TrackTemplate {
  EvolvingSegment segment;
  std::vector<Vector3> start;     ///< where its vertices were at the segment's first frame
  Signal colours;                 ///< a row per vertex, as when it was added; or none
  std::vector<Vector3> material;  ///< per vertex; empty: not known
  std::vector<std::array<Vector3, 3>> rest;  ///< per triangle its corners when it was added

  Mesh mesh() const { return mesh_of(segment, start); }
};

/// A frame's own mesh (`cleaned`, at `positions`) as a template, with ids from the given ones on.
/// `colours` and `material` have a row per vertex, or none.
TrackTemplate new_template(const Mesh& mesh, const Signal& colours,
                           const std::vector<Vector3>& material, int first_vertex_id,
                           int first_triangle_id);

/// The segment that remeshing made of another: what was kept keeps its id.
EvolvingSegment remeshed_segment(const Remeshed& remeshed, const EvolvingSegment& before,
                                 int first_vertex_id, int first_triangle_id);

/// The template of the next segment, at `positions` in its first frame. Vertices and triangles with
/// ids that were there before keep what was known of them; those that are new get the colours, and
/// the material, of the nearest point of the frame. `truth` may be null.
TrackTemplate carried(const TrackTemplate& before, const EvolvingSegment& after,
                      const std::vector<Vector3>& positions, const TrackTarget& frame,
                      const MaterialFrame* truth);

/// Where the vertices of a segment would have been in the frame before its first: those with ids of
/// that frame's segment were at `positions_before`; the others moved as their nearest neighbours
/// along edges did, on average, and those that have none did not.
std::vector<Vector3> positions_before(const EvolvingSegment& before,
                                      std::span<const Vector3> positions_before,
                                      const EvolvingSegment& after,
                                      std::span<const Vector3> positions);

/// `distortion` of triangles against their own rest shapes.
Distortion distortion(const TrackTemplate& tracked, std::span<const Vector3> now);

}  // namespace mq

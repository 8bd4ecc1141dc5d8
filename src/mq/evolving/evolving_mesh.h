#pragma once
/// A surface in motion whose triangulation changes only here and there (thesis 6.3).
///
/// Frames with one connectivity form a segment. Between two segments most triangles live on: those
/// with the same id are the same piece of the surface, t_i ↦ t_{i+1} in the thesis' words.

#include <vector>

#include "mq/mesh/mesh.h"

namespace mq {

/// The connectivity of consecutive frames.
struct EvolvingSegment {
  std::vector<int> vertex_ids;       ///< per vertex, persistent; none twice
  std::vector<Triangle> triangles;   ///< indices into the segment's own vertices
  std::vector<int> triangle_ids;     ///< per triangle, persistent; none twice
  std::vector<Vector2> uvs;          ///< pool of texture coordinates, constant over the segment
  std::vector<Triangle> corner_uvs;  ///< per corner an index into `uvs`, or -1; empty: no UVs

  int vertex_count() const { return int(vertex_ids.size()); }
  int triangle_count() const { return int(triangles.size()); }
};

/// Where the vertices are at one moment.
struct EvolvingFrame {
  int number = 0;                  ///< as its file was called, increasing
  int segment = 0;                 ///< the segment it belongs to, never decreasing
  std::vector<Vector3> positions;  ///< per vertex of that segment, model units
};

struct EvolvingMesh {
  std::vector<EvolvingSegment> segments;
  std::vector<EvolvingFrame> frames;

  /// The mesh of one frame, counted from 0.
  Mesh mesh(int frame) const;
};

/// The mesh of a segment at these positions.
Mesh mesh_of(const EvolvingSegment& segment, std::vector<Vector3> positions);

/// A segment of its own for a mesh, with vertices and triangles numbered from the given ids on.
EvolvingSegment segment_of(const Mesh& mesh, int first_vertex_id = 0, int first_triangle_id = 0);

/// One more than the largest id in use; 0 where there is none.
int next_vertex_id(const EvolvingMesh& evolving);
int next_triangle_id(const EvolvingMesh& evolving);

/// The frames in which a triangle is part of the surface.
struct Lifespan {
  int id = 0;     ///< of the triangle
  int first = 0;  ///< frame, counted from 0
  int last = 0;   ///< inclusive
};

/// Of every triangle, by increasing id; segments without frames count for nothing.
/// Throws `InvalidInput` where a triangle comes back after it was gone, or with other vertices.
std::vector<Lifespan> triangle_lifespans(const EvolvingMesh& evolving);

/// Of each segment's triangles, the frames around it in which they have the texture coordinates
/// they have there, equal to the bit; without texture coordinates the frames in which they live. Of
/// a segment without frames, nothing.
std::vector<std::vector<Lifespan>> coordinate_lifespans(const EvolvingMesh& evolving);

/// How triangles fare from one segment to the next.
struct SegmentChange {
  int kept = 0, added = 0, removed = 0;
};
SegmentChange change(const EvolvingSegment& before, const EvolvingSegment& after);

/// A box of `size` in which positions are multiples of 2⁻³² of it, so that the unit of length
/// leaves no trace.
struct UnitGrid {
  Vector3 low = Vector3::Zero();
  double size = 1;
};

/// That of all frames. Throws `InvalidInput` where all positions are one.
UnitGrid unit_grid(const EvolvingMesh& evolving);

/// The same with the box at size 1 and positions rounded. What lies outside of the box is rounded
/// alike. Without a grid: on its own.
EvolvingMesh on_unit_grid(EvolvingMesh evolving, const UnitGrid& grid);
EvolvingMesh on_unit_grid(EvolvingMesh evolving);

/// Throws `InvalidInput` naming the place where sizes do not agree, an index is out of range, an id
/// is negative or given twice in a segment, or a position is not finite.
void check(const EvolvingSegment& segment);
void check(const EvolvingMesh& evolving);

}  // namespace mq

// Voxel (i, j, k) is [i, i + 1) × [j, j + 1) × [k, k + 1) in units of its side. The edge of axis a at (i, j, k) runs
// from there to the next corner along a; the face of axis a at (i, j, k) is the voxel's lower one across a. Its edges
// are, with b and c the other axes, those of b at (i, j, k) and one further along c, and those of c likewise.
//
// A triangle crosses an edge of axis a where its projection along a holds the edge's line. That is decided by signs of
// areas in the half-open way of rasters, so that of triangles that share a side exactly one holds what is on it.

#include "mq/baseline/voxel_region.h"

#include <array>
#include <cmath>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "mq/base/error.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

using Cell = std::array<int, 3>;

constexpr int most_cells = 1 << 20;  // along an axis
constexpr int splits = 4;            // of a triangle that is trimmed

/// A voxel, an edge or a face as one number.
std::uint64_t key(const Cell& cell, int axis = 0) {
  std::uint64_t result = std::uint64_t(axis);
  for (const int i : cell) result = result << 20 | std::uint64_t(i & (most_cells - 1));
  return result;
}

Cell moved(Cell cell, int axis, int by = 1) {
  cell[axis] += by;
  return cell;
}

Cell cell_of(const Vector3& p) { return {int(std::floor(p[0])), int(std::floor(p[1])), int(std::floor(p[2]))}; }

/// Where a mesh meets edges and faces of voxels.
class Crossings {
 public:
  /// Positions are in voxels.
  Crossings(const Mesh& mesh, const Progress& progress) {
    for (int t = 0; t < mesh.triangle_count(); ++t) {
      if (t % 4096 == 0) progress.check();
      const std::array<Vector3, 3> corners{mesh.position(t, 0), mesh.position(t, 1), mesh.position(t, 2)};
      for (int axis = 0; axis < 3; ++axis) add_edges(corners, axis);
      for (int k = 0; k < 3; ++k) add_faces(corners[k], corners[(k + 1) % 3]);
    }
  }
  int of_edge(const Cell& cell, int axis) const {
    const auto found = edges_.find(key(cell, axis));
    return found == edges_.end() ? 0 : found->second;
  }
  bool meets_face(const Cell& cell, int axis) const { return faces_.contains(key(cell, axis)); }

 private:
  /// Twice the area of a, b and p in the plane of b- and c-axis, and whether p is to the left of a to b: where it is on
  /// it, if the side runs down, or level to the left.
  static bool is_left(const Vector2& a, const Vector2& b, const Vector2& p) {
    // The same sum for both directions, so that what is left of one is right of the other.
    const bool is_turned = std::make_pair(b.x(), b.y()) < std::make_pair(a.x(), a.y());
    const Vector2 &from = is_turned ? b : a, &to = is_turned ? a : b;
    double area = cross(to - from, p - from);
    if (is_turned) area = -area;
    if (area != 0) return area > 0;
    return b.y() < a.y() || (b.y() == a.y() && b.x() < a.x());
  }

  void add_edges(const std::array<Vector3, 3>& corners, int axis) {
    const int b = (axis + 1) % 3, c = (axis + 2) % 3;
    std::array<Vector2, 3> flat;
    for (int k = 0; k < 3; ++k) flat[k] = {corners[k][b], corners[k][c]};
    const double area = cross(flat[1] - flat[0], flat[2] - flat[0]);
    if (area == 0) return;
    if (area < 0) std::swap(flat[1], flat[2]);
    const Vector2 low = flat[0].cwiseMin(flat[1]).cwiseMin(flat[2]), high = flat[0].cwiseMax(flat[1]).cwiseMax(flat[2]);
    const Vector3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    for (int u = int(std::ceil(low.x())); u <= high.x(); ++u)
      for (int v = int(std::ceil(low.y())); v <= high.y(); ++v) {
        const Vector2 p(u, v);
        if (!is_left(flat[0], flat[1], p) || !is_left(flat[1], flat[2], p) || !is_left(flat[2], flat[0], p)) continue;
        Vector3 point = corners[0];
        point[b] = u, point[c] = v;
        point[axis] -= (normal[b] * (u - corners[0][b]) + normal[c] * (v - corners[0][c])) / normal[axis];
        Cell cell;
        cell[axis] = int(std::floor(point[axis]));
        cell[b] = u, cell[c] = v;
        ++edges_[key(cell, axis)];
      }
  }

  /// Faces that a side of a triangle passes.
  void add_faces(const Vector3& p, const Vector3& q) {
    for (int axis = 0; axis < 3; ++axis) {
      const int from = int(std::floor(std::min(p[axis], q[axis]))), to = int(std::floor(std::max(p[axis], q[axis])));
      for (int plane = from + 1; plane <= to; ++plane) {
        Cell cell = cell_of(p + (plane - p[axis]) / (q[axis] - p[axis]) * (q - p));
        cell[axis] = plane;
        faces_.insert(key(cell, axis));
      }
    }
  }

  std::unordered_map<std::uint64_t, int> edges_;
  std::unordered_set<std::uint64_t> faces_;
};

bool is_met_alike(const Crossings& one, const Crossings& other, const Cell& cell, int axis) {
  const int b = (axis + 1) % 3, c = (axis + 2) % 3;
  bool is_crossed = false;
  for (const auto& [edge, along] : {std::pair{cell, b}, {moved(cell, c), b}, {cell, c}, {moved(cell, b), c}}) {
    const int count = one.of_edge(edge, along);
    if (count != other.of_edge(edge, along)) return false;
    is_crossed = is_crossed || count > 0;
  }
  return is_crossed || (!one.meets_face(cell, axis) && !other.meets_face(cell, axis));
}

/// Area of a triangle in marked voxels.
double area_inside(const std::array<Vector3, 3>& corners, const std::unordered_set<std::uint64_t>& marked, int split) {
  const Cell cell = cell_of(corners[0]);
  if (split == 0 || (cell == cell_of(corners[1]) && cell == cell_of(corners[2]))) {
    const Cell middle = cell_of((corners[0] + corners[1] + corners[2]) / 3);
    return marked.contains(key(middle)) ? (corners[1] - corners[0]).cross(corners[2] - corners[0]).norm() / 2 : 0;
  }
  const Vector3 a = (corners[0] + corners[1]) / 2, b = (corners[1] + corners[2]) / 2, c = (corners[2] + corners[0]) / 2;
  return area_inside({corners[0], a, c}, marked, split - 1) + area_inside({a, corners[1], b}, marked, split - 1) +
         area_inside({c, b, corners[2]}, marked, split - 1) + area_inside({a, b, c}, marked, split - 1);
}

double area_inside(const Mesh& mesh, const std::unordered_set<std::uint64_t>& marked) {
  double area = 0;
  for (int t = 0; t < mesh.triangle_count(); ++t)
    area += area_inside({mesh.position(t, 0), mesh.position(t, 1), mesh.position(t, 2)}, marked, splits);
  return area;
}

}  // namespace

VoxelRegion voxel_region(const Mesh& of_template, const Mesh& target, std::span<const int> template_seeds,
                         std::span<const int> target_seeds, double voxel, const Progress& progress) {
  const Box one = bounding_box(of_template), other = bounding_box(target);
  const Vector3 low = one.low.cwiseMin(other.low), size = one.high.cwiseMax(other.high) - low;
  require(voxel > 0 && size.maxCoeff() / voxel < most_cells - 4,
          "a voxel must have a side, and no less than a millionth of the size of both surfaces");
  const auto in_voxels = [&](Mesh mesh) {
    // Surfaces that begin on a plane between voxels are no rarity; one voxel stays free around both.
    for (Vector3& p : mesh.positions) p = (p - low) / voxel + Vector3(1.31, 1.37, 1.43);
    return mesh;
  };
  const Mesh before = in_voxels(of_template), after = in_voxels(target);
  const Crossings of_before(before, progress), of_after(after, progress);
  std::unordered_set<std::uint64_t> marked;
  std::vector<Cell> open;
  const auto mark = [&](const Cell& cell) {
    if (marked.insert(key(cell)).second) open.push_back(cell);
  };
  for (const int v : template_seeds) mark(cell_of(before.positions[v]));
  for (const int v : target_seeds) mark(cell_of(after.positions[v]));
  VoxelRegion region{.seeded = int(marked.size())};
  while (!open.empty()) {
    progress.check();
    const Cell cell = open.back();
    open.pop_back();
    for (int axis = 0; axis < 3; ++axis)
      for (const int side : {0, 1})
        if (!is_met_alike(of_before, of_after, moved(cell, axis, side), axis))
          mark(moved(cell, axis, side == 0 ? -1 : 1));
  }
  region.voxels = int(marked.size());
  region.template_area = area_inside(before, marked) * voxel * voxel;
  region.target_area = area_inside(after, marked) * voxel * voxel;
  return region;
}

}  // namespace mq

// Equal points meet in a hash table. Close points meet in one of cells so small that all points of
// a cell are close, or in one of the cells around; two cells become one as soon as one pair of
// their points is close, so a distance that swallows the mesh does not compare all pairs.

#include "mq/mesh/weld.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstdint>

#include "mq/base/error.h"

namespace mq {
namespace {

/// Finds the first of the inserted points that equals a given one. Zeros of either sign are equal.
class PointTable {
 public:
  explicit PointTable(const std::vector<Vector3>& points)
      : points_(points), mask_(std::bit_ceil(2 * points.size() + 1) - 1), slots_(mask_ + 1, -1) {}

  /// The index of the first inserted point equal to point i, which is i if there is none before.
  int insert(int i) {
    int& slot = slots_[find_slot(points_[i])];
    if (slot < 0) slot = i;
    return slot;
  }

  /// The same without inserting; -1 if there is none.
  int find(const Vector3& point) const { return slots_[find_slot(point)]; }

 private:
  std::size_t find_slot(const Vector3& point) const {
    std::size_t slot = hash(point) & mask_;
    while (slots_[slot] >= 0 && points_[slots_[slot]] != point) slot = (slot + 1) & mask_;
    return slot;
  }

  static std::uint64_t hash(const Vector3& point) {
    std::uint64_t h = 0;
    for (int k = 0; k < 3; ++k) {
      h ^= std::bit_cast<std::uint64_t>(point[k] + 0.0);  // -0 + 0 is 0
      h = (h ^ (h >> 32)) * 0x9e3779b97f4a7c15u;
    }
    return h ^ (h >> 29);
  }

  const std::vector<Vector3>& points_;
  std::size_t mask_;
  std::vector<int> slots_;
};

std::vector<int> weld_exactly(const Mesh& mesh, const std::vector<char>& referenced) {
  std::vector<int> welded(mesh.positions.size());
  PointTable table(mesh.positions);
  for (int v = 0; v < int(welded.size()); ++v) welded[v] = referenced[v] ? table.insert(v) : v;
  return welded;
}

std::vector<int> weld_by_distance(const Mesh& mesh, const std::vector<char>& referenced,
                                  double distance) {
  if (!(distance > 0) || !std::isfinite(distance))
    throw InvalidInput(fmt::format(
        "vertices closer than {} cannot be welded: the distance must be a positive number",
        distance));
  const int count = mesh.vertex_count();
  std::vector<Vector3> cells(count, Vector3::Zero());
  std::vector<int> after(count, -1), last(count);  // lists of the points of a cell
  PointTable table(cells);
  DisjointSets sets(cells.size());
  for (int v = 0; v < count; ++v) {
    if (!referenced[v]) continue;
    cells[v] = (mesh.positions[v] / (distance * 0.57)).array().floor();  // 0.57 < 1 / sqrt(3)
    last[v] = v;
    const int home = table.insert(v);
    if (home == v) continue;
    sets.join(home, v);
    after[last[home]] = v;
    last[home] = v;
  }
  const auto close = [&](int a, int b) {
    for (int p = a; p >= 0; p = after[p])
      for (int q = b; q >= 0; q = after[q])
        if ((mesh.positions[p] - mesh.positions[q]).norm() < distance) return true;
    return false;
  };
  for (int v = 0; v < count; ++v) {
    if (!referenced[v] || table.find(cells[v]) != v) continue;
    for (int n = 63; n < 125; ++n) {  // the half of the 5³ cells around that comes after this one
      const Vector3 offset(n % 5 - 2, n / 5 % 5 - 2, n / 25 - 2);
      const int other = table.find(cells[v] + offset);
      if (other >= 0 && sets.root(other) != sets.root(v) && close(v, other)) sets.join(v, other);
    }
  }
  std::vector<int> welded(count);
  for (int v = 0; v < count; ++v) welded[v] = sets.root(v);
  return welded;
}

}  // namespace

std::vector<int> weld_vertices(const Mesh& mesh, const std::vector<char>& referenced,
                               const WeldOptions& options) {
  switch (options.kind) {
    case WeldOptions::Kind::exact: return weld_exactly(mesh, referenced);
    case WeldOptions::Kind::distance: return weld_by_distance(mesh, referenced, options.distance);
    case WeldOptions::Kind::none: break;
  }
  std::vector<int> welded(mesh.positions.size());
  std::iota(welded.begin(), welded.end(), 0);
  return welded;
}

}  // namespace mq

#include "mq/mesh/space_order.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cstdint>
#include <utility>

#include "mq/base/parallel.h"

namespace mq {
namespace {

/// Twenty-one bits, two zeros between each and the next.
std::uint64_t spread_bits(std::uint64_t x) {
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}

std::uint64_t morton_code(const Vector3& place) {
  std::uint64_t code = 0;
  for (int axis = 0; axis < 3; ++axis)
    code |= spread_bits(std::uint64_t(std::clamp(place[axis], 0.0, 1.0) * 2097151)) << axis;
  return code;
}

}  // namespace

std::vector<int> space_order(std::span<const Vector3> places) {
  if (places.empty()) return {};
  Vector3 low = places[0], high = low;
  for (const Vector3& place : places) {
    low = low.cwiseMin(place);
    high = high.cwiseMax(place);
  }
  const double side = std::max((high - low).maxCoeff(), 1e-300);
  std::vector<std::pair<std::uint64_t, int>> codes(places.size());
  parallel_for(std::ssize(codes), [&](std::int64_t i) { codes[i] = {morton_code((places[i] - low) / side), int(i)}; });
  tbb::parallel_sort(codes.begin(), codes.end());
  std::vector<int> order(codes.size());
  parallel_for(std::ssize(order), [&](std::int64_t i) { order[i] = codes[i].second; });
  return order;
}

std::vector<int> triangle_space_order(const Mesh& mesh) {
  std::vector<Vector3> centres(mesh.triangles.size());
  parallel_for(std::ssize(centres), [&](std::int64_t t) {
    centres[t] = mesh.position(int(t), 0) / 3 + mesh.position(int(t), 1) / 3 + mesh.position(int(t), 2) / 3;
  });
  return space_order(centres);
}

OrderedMesh in_space_order(const Mesh& mesh) {
  const std::vector<int> vertices = space_order(mesh.positions);
  std::vector<int> number(vertices.size());
  Mesh ordered;
  ordered.positions.resize(vertices.size());
  parallel_for(std::ssize(vertices), [&](std::int64_t v) {
    number[std::size_t(vertices[v])] = int(v);
    ordered.positions[v] = mesh.positions[std::size_t(vertices[v])];
  });
  std::vector<int> triangles = triangle_space_order(mesh);
  ordered.triangles.resize(triangles.size());
  parallel_for(std::ssize(triangles), [&](std::int64_t t) {
    const Triangle& corners = mesh.triangles[std::size_t(triangles[t])];
    for (int k = 0; k < 3; ++k) ordered.triangles[t][k] = number[std::size_t(corners[k])];
  });
  return {std::move(ordered), std::move(triangles)};
}

}  // namespace mq

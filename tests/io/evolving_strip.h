#pragma once
/// Evolving meshes to try files with, and bytes to spoil.

#include <cmath>
#include <string>

#include "mq/base/random.h"
#include "mq/io/evolving_file.h"

namespace mq {

inline constexpr double test_step = 0x1p-20;

/// A strip of n quads that waves over `count` frames; from the middle on its last quad is another.
inline EvolvingMesh waving_strip(int n, int count) {
  Mesh mesh;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j < 2; ++j) {
      mesh.positions.emplace_back(i, j, 0);
      mesh.uvs.emplace_back(double(i) / n, j);
    }
  for (int i = 0; i < n; ++i) {
    mesh.triangles.push_back({2 * i, 2 * i + 2, 2 * i + 3});
    mesh.triangles.push_back({2 * i, 2 * i + 3, 2 * i + 1});
  }
  mesh.corner_uvs = mesh.triangles;
  EvolvingMesh evolving;
  evolving.segments = {segment_of(mesh), segment_of(mesh)};
  evolving.segments[1].triangle_ids[2 * n - 2] = 2 * n;
  evolving.segments[1].triangle_ids[2 * n - 1] = 2 * n + 1;
  for (int f = 0; f < count; ++f) {
    EvolvingFrame frame{10 + 2 * f, f < count / 2 ? 0 : 1, mesh.positions};
    for (Vector3& p : frame.positions) p.z() = std::sin(p.x() + 0.3 * f);
    evolving.frames.push_back(std::move(frame));
  }
  return evolving;
}

/// The same as a store of `test_step` gives it back, without texture coordinates from the middle on.
inline EvolvingMesh stored_strip(int n, int count) {
  EvolvingMesh evolving = waving_strip(n, count);
  evolving.segments[1].uvs.clear();
  evolving.segments[1].corner_uvs.clear();
  for (EvolvingFrame& frame : evolving.frames) frame.positions = rounded(frame.positions, test_step);
  return evolving;
}

/// Another value for one byte somewhere.
inline void spoil(Bytes& bytes, const Random& random, std::uint64_t& draw) {
  const double place = random.uniform(draw++), value = random.uniform(draw++);
  bytes[std::size_t(double(bytes.size()) * place)] = std::byte(int(256 * value));
}

}  // namespace mq

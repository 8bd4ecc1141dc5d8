#pragma once
/// Small evolving meshes that several tests use.

#include <cmath>
#include <vector>

#include "mq/base/random.h"
#include "mq/evolving/evolving_mesh.h"

namespace mq {

/// A grid of n × n squares of two triangles each; `ids` gives squares their triangles' ids.
inline EvolvingSegment grid(int n, const std::vector<int>& ids) {
  EvolvingSegment segment;
  for (int v = 0; v < (n + 1) * (n + 1); ++v) segment.vertex_ids.push_back(v);
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const int v = y * (n + 1) + x, id = ids[y * n + x];
      segment.triangles.push_back({v, v + 1, v + n + 2});
      segment.triangles.push_back({v, v + n + 2, v + n + 1});
      segment.triangle_ids.push_back(2 * id);
      segment.triangle_ids.push_back(2 * id + 1);
    }
  return segment;
}

/// A waving sheet in `periods` periods of three frames; each period replaces the squares of some
/// discs by new ones.
inline EvolvingMesh patched_sheet(int n, int periods, std::uint64_t seed, double scale = 1) {
  const Random random(seed);
  EvolvingMesh evolving;
  std::vector<int> ids(n * n);
  for (int i = 0; i < n * n; ++i) ids[i] = i;
  int next = n * n;
  std::uint64_t draw = 0;
  for (int p = 0; p < periods; ++p) {
    if (p > 0)
      for (int d = 0; d < 3; ++d) {
        const double cx = n * random.uniform(draw++), cy = n * random.uniform(draw++);
        const double r = n * (0.05 + 0.15 * random.uniform(draw++));
        for (int y = 0; y < n; ++y)
          for (int x = 0; x < n; ++x)
            if (std::hypot(x + 0.5 - cx, y + 0.5 - cy) < r) ids[y * n + x] = next++;
      }
    evolving.segments.push_back(grid(n, ids));
    for (int f = 0; f < 3; ++f) {
      EvolvingFrame frame{3 * p + f, p, {}};
      for (int y = 0; y <= n; ++y)
        for (int x = 0; x <= n; ++x)
          frame.positions.push_back(
              scale * Vector3(x, y, 0.2 * n * std::sin(2.0 * x / n + 0.3 * frame.number)));
      evolving.frames.push_back(std::move(frame));
    }
  }
  return evolving;
}

}  // namespace mq

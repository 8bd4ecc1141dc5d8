#pragma once
/// Flat surfaces with atlases cut in many ways: on them exact answers are known.

#include <Eigen/Geometry>

#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "fixtures.h"
#include "mq/atlas/atlas.h"
#include "mq/mesh/surface.h"

namespace mq::fixtures {

/// A surface with its atlas, at fixed addresses.
struct Textured {
  Surface surface;
  Atlas atlas;
};

inline std::unique_ptr<Textured> textured(const Mesh& mesh, const std::vector<TextureSize>& sizes,
                                          const AtlasOptions& options = {}) {
  auto result = std::make_unique<Textured>();
  result->surface = make_surface(mesh);
  result->atlas = make_atlas(result->surface, sizes, options);
  return result;
}

struct CutOptions {
  int cells = 12;       ///< the square is cells × cells quads
  int parts = 2;        ///< cut into parts × parts charts
  double jitter = 0.2;  ///< of inner vertices
  double scale = 0.7;   ///< of each chart in its slot of the texture
  std::function<double(int)> angle = [](int) { return 0.0; };             ///< of chart c, radians
  std::function<Vector2(int)> shift = [](int) { return Vector2(0, 0); };  ///< of chart c, in uv
  std::function<int(int)> texture = [](int) { return 0; };                ///< of chart c
};

/// The unit square cut into square charts, each a similar copy of its part in a slot of its own.
inline Mesh cut_square(const CutOptions& options = {}) {
  Mesh mesh = flat_square(options.cells, options.jitter);
  mesh.uvs.clear();
  mesh.corner_uvs.clear();
  std::map<std::pair<int, int>, int> uv_of;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const int quad = t / 2, i = quad % options.cells, j = quad / options.cells;
    const int pi = i * options.parts / options.cells, pj = j * options.parts / options.cells;
    const int chart = pj * options.parts + pi;
    const Vector2 middle((pi + 0.5) / options.parts, (pj + 0.5) / options.parts);
    const Eigen::Rotation2Dd turn(options.angle(chart));
    Triangle corners;
    for (int k = 0; k < 3; ++k) {
      const int v = mesh.triangles[t][k];
      const auto [it, added] = uv_of.insert({{chart, v}, int(mesh.uvs.size())});
      if (added) {
        const Vector2 p = mesh.positions[v].head<2>() - middle;
        mesh.uvs.push_back(middle + options.shift(chart) + options.scale * (turn * p));
      }
      corners[k] = it->second;
    }
    mesh.corner_uvs.push_back(corners);
    mesh.textures.push_back(options.texture(chart));
  }
  return mesh;
}

/// Angles that no texel line runs along.
inline double odd_angle(int chart) { return 0.3 + 1.1 * chart; }

/// Quarter turns: seams of charts cut along the axes stay along texel lines.
inline double quarter_turn(int chart) { return chart * std::acos(-1.0) / 2; }

}  // namespace mq::fixtures

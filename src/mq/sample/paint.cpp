// Every triangle proposes itself to the texels in and near it, with its distance to the texel's
// centre; the nearest wins, of equally near ones the first. Bands of rows are painted at once.

#include "mq/sample/paint.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/base/random.h"
#include "mq/sample/noise.h"

namespace mq {
namespace {

/// A triangle in the plane of the texture.
struct Patch {
  std::array<Vector2, 3> p;
  double area;  // twice, signed

  double inside(const Vector2& x, Vector3& weights) const {  // 0 inside, else negative
    for (int k = 0; k < 3; ++k) {
      const Vector2 a = p[(k + 1) % 3] - x, b = p[(k + 2) % 3] - x;
      weights[k] = (a.x() * b.y() - a.y() * b.x()) / area;
    }
    return std::min(0.0, weights.minCoeff());
  }

  double distance(const Vector2& x) const {
    double best = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) {
      const Vector2 e = p[(k + 1) % 3] - p[k], d = x - p[k];
      const double t = std::clamp(d.dot(e) / std::max(e.squaredNorm(), 1e-300), 0.0, 1.0);
      best = std::min(best, (d - t * e).norm());
    }
    return best;
  }
};

struct Painter {
  const Surface& surface;
  const Atlas& atlas;
  const SurfaceField& field;
  const PaintOptions& options;
  std::vector<char> rim;                // per triangle: at the boundary of its chart
  std::vector<std::vector<int>> bands;  // per band of rows the triangles that may paint it
  Image<float>* image;

  static constexpr int band_rows = 64;

  Patch patch(int t) const {
    Patch patch;
    for (int k = 0; k < 3; ++k)
      patch.p[k] = {atlas.corners[t][k].column(), atlas.corners[t][k].row()};
    const Vector2 a = patch.p[1] - patch.p[0], b = patch.p[2] - patch.p[0];
    patch.area = a.x() * b.y() - a.y() * b.x();
    return patch;
  }
  double reach(int t) const { return rim[t] ? options.margin : 0; }
  Vector3 color(int t, const Vector3& weights) const {
    return field(t, weights).cwiseMax(0).cwiseMin(1);
  }
  void paint_band(int band) const;
};

/// A vertex of a chart's boundary starts or ends an edge that is not inside; all triangles that
/// touch one are the chart's rim.
std::vector<char> find_rim(const Surface& surface, const Atlas& atlas) {
  const Mesh& mesh = surface.mesh;
  std::vector<char> on_boundary(mesh.positions.size()), rim(mesh.triangles.size());
  for (HalfEdge h = 0; h < HalfEdge(atlas.edges.size()); ++h)
    if (atlas.chart[h / 3] >= 0 && atlas.edges[h] != EdgeKind::inside)
      on_boundary[mesh.triangles[h / 3][h % 3]] =
          on_boundary[mesh.triangles[h / 3][(h % 3 + 1) % 3]] = 1;
  for (int t = 0; t < mesh.triangle_count(); ++t)
    for (const int v : mesh.triangles[t]) rim[t] |= on_boundary[v];
  return rim;
}

void Painter::paint_band(int band) const {
  const int first = band * band_rows, last = std::min(first + band_rows, image->height());
  const int width = image->width();
  std::vector<float> nearest(std::size_t(width) * (last - first),
                             std::numeric_limits<float>::infinity());
  std::vector<int> owner(nearest.size(), -1);
  for (const int t : bands[band]) {
    const Patch triangle = patch(t);
    const double reach_t = reach(t);
    const auto range = [&](int axis, int low, int high) {
      const auto [a, b] =
          std::minmax({triangle.p[0][axis], triangle.p[1][axis], triangle.p[2][axis]});
      return std::pair(std::max(low, int(std::ceil(std::max(a - reach_t, -1e6)))),
                       std::min(high, int(std::floor(std::min(b + reach_t, 1e6)))));
    };
    const auto [x0, x1] = range(0, 0, width - 1);
    const auto [y0, y1] = range(1, first, last - 1);
    Vector3 weights;
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) {
        const std::size_t i = std::size_t(y - first) * width + x;
        if (nearest[i] == 0) continue;
        const Vector2 center(x, y);
        const double distance =
            triangle.inside(center, weights) == 0 ? 0.0 : triangle.distance(center);
        if (distance > reach_t || !(float(distance) < nearest[i])) continue;
        nearest[i] = float(distance);
        owner[i] = t;
      }
  }
  for (int y = first; y < last; ++y)
    for (int x = 0; x < width; ++x) {
      const int t = owner[std::size_t(y - first) * width + x];
      Vector3 weights, color_here = options.background;
      if (t >= 0) {
        patch(t).inside({x, y}, weights);
        color_here = color(t, weights);
      }
      for (int k = 0; k < 3; ++k) (*image)(x, y, k) = float(color_here[k]);
    }
}

}  // namespace

Image<float> paint(const Surface& surface, const Atlas& atlas, const SurfaceField& field,
                   const PaintOptions& options, int texture, const Progress& progress) {
  if (texture < 0 || texture >= int(atlas.textures.size()))
    throw InvalidInput("there is no such texture to paint");
  const TextureSize& size = atlas.textures[texture];
  Image<float> image(size.width, size.height, 3);
  Painter painter{surface, atlas, field, options, find_rim(surface, atlas), {}, &image};
  const int bands = (size.height + Painter::band_rows - 1) / Painter::band_rows;
  painter.bands.resize(bands);
  for (int t = 0; t < surface.triangle_count(); ++t) {
    if (atlas.chart[t] < 0 || surface.mesh.texture(t) != texture) continue;
    const Patch patch = painter.patch(t);
    const auto [low, high] = std::minmax({patch.p[0].y(), patch.p[1].y(), patch.p[2].y()});
    const auto band = [&](double y) {
      return std::clamp(int(std::floor(y / Painter::band_rows)), 0, bands - 1);
    };
    for (int b = band(low - painter.reach(t)); b <= band(high + painter.reach(t)); ++b)
      painter.bands[b].push_back(t);
  }
  std::atomic<int> done = 0;
  parallel_for(
      bands,
      [&](std::int64_t band) {
        painter.paint_band(int(band));
        progress.at(double(++done) / bands);
      },
      1);
  return image;
}

Image<float> paint(const Surface& surface, const Atlas& atlas, const ColorField& field,
                   const PaintOptions& options, int texture, const Progress& progress) {
  const SurfaceField at_point = [&](int t, const Vector3& weights) {
    Vector3 position = Vector3::Zero();
    for (int k = 0; k < 3; ++k) position += weights[k] * surface.mesh.position(t, k);
    return field(position, atlas.chart[t]);
  };
  return paint(surface, atlas, at_point, options, texture, progress);
}

ColorField colorful(double scale, std::uint64_t seed) {
  return [scale, noise = Noise(seed), seed](const Vector3& position, int) -> Vector3 {
    const Vector3 p = position / scale + Vector3::Constant(double(seed % 64) * 1.7);
    const Vector3 warp(noise.octaves(p + Vector3(5, 1, 3), 3),
                       noise.octaves(p + Vector3(1, 7, 9), 3),
                       noise.octaves(p + Vector3(8, 2, 4), 3));
    const double ground = noise.octaves(1.3 * p + 0.7 * warp, 8);
    Vector3 color = Vector3(0.86, 0.78, 0.62);  // sand
    const auto blend = [&](const Vector3& to, double t) { color += t * (to - color); };
    blend({0.16, 0.42, 0.45}, smooth_step(-0.15, 0.15, ground));  // sea
    blend({0.10, 0.18, 0.33}, smooth_step(0.25, 0.75, ground));   // deep
    const double islands = noise.octaves(2.6 * p + 0.9 * warp + Vector3(20, 0, 0), 5);
    blend({0.78, 0.31, 0.19}, smooth_step(0.17, 0.20, islands));  // brick, sharp edges
    blend({0.93, 0.66, 0.25}, smooth_step(0.33, 0.36, islands));
    const double bands = std::sin(22 * (p.y() + 0.35 * warp.x()) + 6 * warp.z());
    blend({0.95, 0.93, 0.86},
          0.75 * smooth_step(0.80, 0.92, bands) * smooth_step(-0.1, 0.1, -ground));
    const double dots = noise(14 * p + 2 * warp);
    blend({0.97, 0.95, 0.90}, smooth_step(0.50, 0.58, dots) * smooth_step(0.0, 0.3, ground));
    return color * (1 + 0.30 * noise.octaves(9 * p, 7)) + Vector3::Constant(0.03 * warp.y());
  };
}

ColorField misaligned(ColorField field, const MisalignOptions& options) {
  return [field = std::move(field), options](const Vector3& position, int chart) -> Vector3 {
    const Random random(options.seed, std::uint64_t(chart));
    const double gain = 1 + options.exposure * random.uniform(0, -1, 1);
    Vector3 balance, shift;
    for (std::uint64_t k = 0; k < 3; ++k) {
      balance[Eigen::Index(k)] = gain * (1 + options.white_balance * random.uniform(1 + k, -1, 1));
      shift[Eigen::Index(k)] = options.shift * random.uniform(4 + k, -1, 1) / std::sqrt(3.0);
    }
    return field(position + shift, chart).cwiseProduct(balance);
  };
}

}  // namespace mq

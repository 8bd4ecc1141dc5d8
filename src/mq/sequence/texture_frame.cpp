// Sample (i, j) of a texture with s samples per texel lies at ((i + ½)/s, (j + ½)/s) texels from
// its upper left corner. Each belongs to the triangle that it is in, else to the nearest one closer
// than a texel, where the point nearest to it counts.

#include "mq/sequence/texture_frame.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/image/spread.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

/// How far outside of a triangle samples are, in texels, that it still speaks for.
constexpr double margin = 1;

/// The triangle that speaks for a sample.
struct Owner {
  int triangle = -1;
  float distance = std::numeric_limits<float>::infinity();  // texels
};

double cross(const Vector2& a, const Vector2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Barycentric coordinates of the point of a triangle nearest to p.
Vector3 nearest_in_triangle(const std::array<Vector2, 3>& c, const Vector2& p) {
  const double twice = cross(c[1] - c[0], c[2] - c[0]);
  if (twice != 0) {
    Vector3 b;
    for (int k = 0; k < 3; ++k) b[k] = cross(c[(k + 1) % 3] - p, c[(k + 2) % 3] - p) / twice;
    if (b.minCoeff() >= 0) return b;
  }
  double least = std::numeric_limits<double>::infinity();
  Vector3 nearest = Vector3::UnitX();
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3;
    const Vector2 edge = c[l] - c[k];
    const double square = edge.squaredNorm();
    const double t = square > 0 ? std::clamp((p - c[k]).dot(edge) / square, 0.0, 1.0) : 0.0;
    const double distance = (c[k] + t * edge - p).squaredNorm();
    if (distance >= least) continue;
    least = distance;
    nearest = Vector3::Zero();
    nearest[k] = 1 - t;
    nearest[l] = t;
  }
  return nearest;
}

class Rasteriser {
 public:
  Rasteriser(const Mesh& surface, const TextureFrameOptions& options)
      : surface_(surface),
        samples_(options.samples),
        width_(options.width),
        height_(options.height),
        owners_(std::size_t(width_) * height_ * samples_ * samples_) {
    for (int t = 0; t < surface.triangle_count(); ++t)
      if (surface.textured(t)) add(t);
  }

  const Owner& owner(int column, int row) const {
    return owners_[std::size_t(row) * width_ * samples_ + column];
  }

  std::array<Vector2, 3> corners(int t) const {
    std::array<Vector2, 3> result;
    for (int k = 0; k < 3; ++k) {
      const Vector2& uv = surface_.uv(t, k);
      result[k] = {uv.x() * width_, (1 - uv.y()) * height_};
    }
    return result;
  }

  Vector2 place(int column, int row) const {
    return {(column + 0.5) / samples_, (row + 0.5) / samples_};
  }

 private:
  void add(int t) {
    const std::array<Vector2, 3> c = corners(t);
    const Vector2 low = c[0].cwiseMin(c[1]).cwiseMin(c[2]),
                  high = c[0].cwiseMax(c[1]).cwiseMax(c[2]);
    const auto first = [&](double x, int size) {
      return int(std::clamp(std::floor((x - margin) * samples_), 0.0, double(size * samples_)));
    };
    const auto last = [&](double x, int size) {
      return int(std::clamp(std::ceil((x + margin) * samples_), 0.0, double(size * samples_)));
    };
    for (int row = first(low.y(), height_); row < last(high.y(), height_); ++row)
      for (int column = first(low.x(), width_); column < last(high.x(), width_); ++column) {
        Owner& owner = owners_[std::size_t(row) * width_ * samples_ + column];
        if (owner.distance == 0) continue;
        const Vector2 p = place(column, row);
        const Vector3 b = nearest_in_triangle(c, p);
        const float distance = float((b[0] * c[0] + b[1] * c[1] + b[2] * c[2] - p).norm());
        if (distance > margin || distance >= owner.distance) continue;
        owner = {t, distance < 1e-9F ? 0 : distance};
      }
  }

  const Mesh& surface_;
  int samples_, width_, height_;
  std::vector<Owner> owners_;
};

}  // namespace

TextureFrame resample_texture(const Mesh& surface, const Mesh& captured, const ColourAt& colour,
                              const TextureFrameOptions& options, const Progress& progress) {
  require(surface.has_uvs(), "the surface has no texture coordinates to resample into");
  require(options.width >= 1 && options.height >= 1 && options.samples >= 1 && options.samples <= 8,
          fmt::format("a texture of {} × {} texels with {} × {} samples each: wanted at least one "
                      "texel, and 1 to 8 samples",
                      options.width, options.height, options.samples, options.samples));
  const Rasteriser raster(surface, options);
  progress.at(0.1);
  const ClosestPointFinder closest(captured);
  const double most = options.most_distance * bounding_box(captured).diagonal();
  const double least_cosine = std::cos(options.most_angle * std::numbers::pi / 180);
  const auto normal = [](const Mesh& mesh, int t) {
    return Vector3((mesh.position(t, 1) - mesh.position(t, 0))
                       .cross(mesh.position(t, 2) - mesh.position(t, 0))
                       .normalized());
  };

  TextureFrame frame;
  frame.picture = Image<float>(options.width, options.height, 3);
  Image<char> known(options.width, options.height, 1), inside(options.width, options.height, 1);
  const int s = options.samples;
  parallel_for(
      options.height,
      [&](std::int64_t y) {
        progress.check();
        for (int x = 0; x < options.width; ++x) {
          Eigen::Array3d sum = Eigen::Array3d::Zero();
          int seen = 0;
          for (int row = int(y) * s; row < int(y) * s + s; ++row)
            for (int column = x * s; column < x * s + s; ++column) {
              const Owner& owner = raster.owner(column, row);
              if (owner.triangle < 0) continue;
              if (owner.distance == 0) inside(x, int(y)) = 1;
              const Vector3 b =
                  nearest_in_triangle(raster.corners(owner.triangle), raster.place(column, row));
              Vector3 p = Vector3::Zero();
              for (int k = 0; k < 3; ++k) p += b[k] * surface.position(owner.triangle, k);
              const ClosestPoint found = closest(p);
              if (found.squared_distance > most * most ||
                  normal(surface, owner.triangle).dot(normal(captured, found.triangle)) <
                      least_cosine)
                continue;
              const std::array<float, 3> value = colour(found);
              sum += Eigen::Array3d(value[0], value[1], value[2]);
              ++seen;
            }
          if (seen == 0) continue;
          known(x, int(y)) = 1;
          for (int k = 0; k < 3; ++k) frame.picture(x, int(y), k) = float(sum[k] / seen);
        }
      },
      8);
  for (int y = 0; y < options.height; ++y)
    for (int x = 0; x < options.width; ++x) {
      frame.texels += inside(x, y);
      frame.unseen += inside(x, y) && !known(x, y);
    }
  progress.at(0.95);
  spread(known, std::numeric_limits<double>::infinity(), frame.picture);
  return frame;
}

}  // namespace mq

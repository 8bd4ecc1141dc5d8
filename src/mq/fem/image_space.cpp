#include "mq/fem/image_space.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"

namespace mq {

namespace {

/// Pixels up to which each gets two triangles.
constexpr double most_pixels = 1e6;

/// Where cells of `side` pixels begin and end along `length` pixels.
std::vector<int> cuts(int length, int side) {
  std::vector<int> at;
  for (int x = 0; x < length; x += side) at.push_back(x);
  at.push_back(length);
  return at;
}

}  // namespace

Mesh image_rectangle(int width, int height, ImageTriangles triangles) {
  require(width >= 1 && height >= 1,
          fmt::format("an image of {} × {} pixels has no surface", width, height));
  const bool fine = triangles == ImageTriangles::per_pixel;
  const int side = fine ? std::max(1, int(std::ceil(std::sqrt(double(width) * height / most_pixels))))
                        : std::max(width, height);
  const std::vector<int> xs = cuts(width, side), ys = cuts(height, side);
  Mesh mesh;
  for (const int y : ys)
    for (const int x : xs) {
      mesh.positions.emplace_back(x, y, 0);
      mesh.uvs.emplace_back(double(x) / width, double(y) / height);
    }
  const int row = int(xs.size());
  for (int j = 0; j + 1 < int(ys.size()); ++j)
    for (int i = 0; i + 1 < row; ++i) {
      const int at = j * row + i;
      mesh.triangles.push_back({at, at + 1, at + row + 1});
      mesh.triangles.push_back({at, at + row + 1, at + row});
    }
  mesh.corner_uvs = mesh.triangles;
  return mesh;
}

ImageSheet::ImageSheet(int width, int height)
    : surface(make_surface(image_rectangle(width, height))),
      atlas(make_atlas(surface, {{width, height}})) {}

ImageSpace::ImageSpace(int width, int height, const Progress& progress)
    : std::unique_ptr<const ImageSheet>(std::make_unique<const ImageSheet>(width, height)),
      TexelSpace(get()->surface, get()->atlas, {}, progress) {}

}  // namespace mq

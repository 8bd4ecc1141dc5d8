#include "mq/fem/image_space.h"

#include <fmt/format.h>

#include "mq/base/error.h"

namespace mq {

Mesh image_rectangle(int width, int height) {
  require(width >= 1 && height >= 1,
          fmt::format("an image of {} × {} pixels has no surface", width, height));
  Mesh mesh;
  const double w = width, h = height;
  mesh.positions = {{0, 0, 0}, {w, 0, 0}, {w, h, 0}, {0, h, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  mesh.corner_uvs = mesh.triangles;
  return mesh;
}

ImageSheet::ImageSheet(int width, int height)
    : surface(make_surface(image_rectangle(width, height))),
      atlas(make_atlas(surface, {{width, height}})) {}

ImageSpace::ImageSpace(int width, int height, const Progress& progress)
    : std::unique_ptr<const ImageSheet>(std::make_unique<const ImageSheet>(width, height)),
      TexelSpace(sheet().surface, sheet().atlas, {}, progress) {}

}  // namespace mq

#include "mq/io/photograph_file.h"

#include <fmt/format.h>

#include <cmath>

#include "mq/base/error.h"

namespace mq {
namespace {

/// Whether one size is the other made larger or smaller, to a pixel.
bool same_shape(const PinholeCamera& camera, int width, int height) {
  const double x = double(width) / camera.width, y = double(height) / camera.height;
  return std::abs(x * camera.height - height) <= 1 || std::abs(y * camera.width - width) <= 1;
}

}  // namespace

FittedCamera fitted_camera(const Photograph& photograph, const PictureInfo& picture) {
  constexpr int first_exchanging = 5;
  const PinholeCamera& camera = photograph.camera;
  const int w = picture.width, h = picture.height, tag = orientation(picture.format);
  if (same_shape(camera, w, h)) return {scaled(camera, w, h), PictureTurn::as_stored};
  const bool lies = same_shape(camera, h, w);
  if (lies && tag >= first_exchanging) return {scaled(camera, h, w), PictureTurn::upright};
  throw InvalidInput(fmt::format(
      "{}: is {} × {}, and its camera is of pictures of {} × {}: wanted that size, or another of the same "
      "proportions; {}",
      photograph.picture.string(), w, h, camera.width, camera.height,
      lies ? "it lies on its side, and no tag of its says so: turn it back"
           : "has it been cropped or stretched since?"));
}

Texture read_photograph(const Photograph& photograph, PictureTurn turn, const Progress& progress) {
  return turn == PictureTurn::upright ? read_upright(photograph.picture, progress)
                                      : read_texture(photograph.picture, progress);
}

}  // namespace mq

#include "mq/image/normal_map.h"

#include <cmath>

#include "mq/base/error.h"

namespace mq {
namespace {

template <class Change>
Image<float> with_changed_vectors(Image<float> image, const Change& change) {
  require(image.channels() >= 3, "a normal map needs three channels; this picture has " +
                                     std::to_string(image.channels()));
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) change(image.pixel(x, y));
  return image;
}

}  // namespace

Image<float> normals_from_colours(const Image<float>& colours) {
  return with_changed_vectors(colours, [](std::span<float> c) {
    for (int k = 0; k < 3; ++k) c[k] = 2 * c[k] - 1;
  });
}

Image<float> colours_from_normals(const Image<float>& normals) {
  return with_changed_vectors(normals, [](std::span<float> n) {
    const double length = std::hypot(double(n[0]), double(n[1]), double(n[2]));
    for (int k = 0; k < 3; ++k) {
      const double unit = length > 0 ? n[k] / length : (k == 2 ? 1.0 : 0.0);
      n[k] = float((unit + 1) / 2);
    }
  });
}

double share_upright(const Image<float>& normals, const Image<float>& coverage) {
  std::int64_t upright = 0, all = 0;
  for (int y = 0; y < normals.height(); ++y)
    for (int x = 0; x < normals.width(); ++x) {
      if (!(coverage(x, y) > 0)) continue;
      ++all;
      upright += normals(x, y, 2) > 0.5F;
    }
  return all > 0 ? double(upright) / double(all) : 0;
}

}  // namespace mq

#include "mq/video/gutter.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/image/spread.h"

namespace mq {

void hold_gutter(const Image<char>& inside, double margin, const Image<float>& before,
                 Image<float>& picture) {
  require(inside.width() == picture.width() && inside.height() == picture.height() &&
              before.width() == picture.width() && before.height() == picture.height() &&
              before.channels() == picture.channels(),
          "pictures of two frames and the texels of charts must have one size");
  const Image<int> nearest = nearest_known(inside);
  parallel_for(
      picture.height(),
      [&](std::int64_t row) {
        const int y = int(row);
        for (int x = 0; x < picture.width(); ++x) {
          const int n = nearest(x, y);
          if (n >= 0 && std::hypot(n % picture.width() - x, n / picture.width() - y) <= margin)
            continue;
          std::ranges::copy(before.pixel(x, y), picture.pixel(x, y).begin());
        }
      },
      64);
}

Image<char> spread_from_charts(const Texels& texels, Image<float>& picture) {
  Image<char> inside(picture.width(), picture.height(), 1);
  for (const Texels::Place& place : texels.places) inside(place.x, place.y) = 1;
  spread(inside, std::numeric_limits<double>::infinity(), picture);
  return inside;
}

}  // namespace mq

#include "mq/draw/samples.h"

#include <algorithm>

namespace mq {

Colour Backdrop::at(int x, int y, int width, int height) const {
  if (kind != Kind::gradient) return colour;
  constexpr Colour middle = {0.972f, 0.974f, 0.978f}, corner = {0.835f, 0.845f, 0.865f};
  const float u = (float(x) + 0.5f) / float(width) - 0.5f;
  const float v = (float(y) + 0.5f) / float(height) - 0.45f;
  const float t = std::min(1.f, 2 * (u * u + v * v)), smooth = t * t * (3 - 2 * t);
  Colour result;
  for (int k = 0; k < 3; ++k) result[k] = middle[k] + smooth * (corner[k] - middle[k]);
  return result;
}

void resolve(const SampleBand& band, int samples, const Backdrop& backdrop, int begin, int end,
             Image<float>& picture) {
  const double count = double(samples) * samples;
  for (int y = begin; y < end; ++y)
    for (int x = 0; x < picture.width(); ++x) {
      std::array<double, 4> sum = {0, 0, 0, 0};
      for (int j = 0; j < samples; ++j)
        for (int i = 0; i < samples; ++i) {
          const auto& sample = band.colours[band.at(x * samples + i, y * samples + j)];
          for (int k = 0; k < 4; ++k) sum[k] += sample[k];
        }
      const double cover = sum[3] / count;
      const auto pixel = picture.pixel(x, y);
      if (backdrop.kind == Backdrop::Kind::transparent) {
        for (int k = 0; k < 3; ++k) pixel[k] = cover > 0 ? float(sum[k] / sum[3]) : 0;
        pixel[3] = float(cover);
        continue;
      }
      const Colour behind = backdrop.at(x, y, picture.width(), picture.height());
      for (int k = 0; k < 3; ++k) pixel[k] = float(sum[k] / count + (1 - cover) * behind[k]);
    }
}

}  // namespace mq

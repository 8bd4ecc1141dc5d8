#pragma once
/// Values between pixels and pictures of other sizes. Places are in pixels with the centre of pixel
/// (i, j) at (i, j): the unit square spans [−½, width − ½] × [−½, height − ½].

#include <span>

#include "mq/image/image.h"
#include "mq/image/wrap.h"

namespace mq {

/// The pixel that a column (or row) outside the picture stands for. Unspecified wraps clamp.
inline int wrapped(std::int64_t index, int size, Wrap wrap) {
  if (wrap != Wrap::repeat) return int(index < 0 ? 0 : index >= size ? size - 1 : index);
  const std::int64_t rest = index % size;
  return int(rest < 0 ? rest + size : rest);
}

/// Bilinear interpolation of the four pixels around (column, row), which must be finite and below
/// 2⁶² in size; `values` takes one value per channel. At a pixel's centre the value is that pixel's
/// exactly, whatever its neighbours hold.
void sample(const Image<float>& image, double column, double row, Wrap wrap,
            std::span<float> values);

/// The picture at a smaller size: each new pixel is the mean over the area it covers, so the mean
/// of the whole picture is kept. Along a side that does not shrink pixels are repeated by the same
/// rule. Throws `InvalidInput` when a size is below 1 or the picture is empty.
Image<float> area_scaled(const Image<float>& image, int width, int height);

/// The same with the picture's proportions kept and no side longer than `side`; unchanged where it
/// fits already.
Image<float> fitted(const Image<float>& image, int side);

/// The rectangle of `width` × `height` pixels whose upper left one is (x, y). Throws
/// `InvalidInput` when it leaves the picture.
Image<float> cropped(const Image<float>& image, int x, int y, int width, int height);

}  // namespace mq

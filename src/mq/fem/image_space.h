#pragma once
/// The pixels of an image as a signal space: what works on textures works on photographs.

#include <memory>

#include "mq/fem/texel_space.h"

namespace mq {

/// Into how many triangles an image is cut.
enum class ImageTriangles {
  two,       ///< what a signal of pixels needs
  per_pixel  ///< two for each pixel, for fields that are constant per triangle; where there are more than
             ///< a million pixels, two for each square of several
};

/// The rectangle that an image covers: triangles in the plane z = 0, one unit a pixel, the lower
/// left corner at the origin, texture coordinates from (0, 0) to (1, 1). The centre of pixel
/// (column, row), row 0 on top, lies at (column + ½, height − row − ½, 0). Throws `InvalidInput` where a
/// side is less than 1.
Mesh image_rectangle(int width, int height, ImageTriangles triangles = ImageTriangles::two);

/// The surface and atlas of an image: a flat surface of one chart.
struct ImageSheet {
  Surface surface;
  Atlas atlas;

  /// Throws `InvalidInput` where a side is less than 1.
  ImageSheet(int width, int height);
};

/// The texel space of that rectangle: unknown row·width + column is a pixel, functions are bilinear
/// between the centres of pixels and constant across the half pixel along the border, where nothing
/// flows out. M has the rows 4/9, 1/9 and 1/36 of bilinear elements inside, S the rows 8/3 and −1/3.
/// Lengths and areas are in pixels, so that the thesis' alpha is a weight over width · height
/// (thesis 3.2 and 4.2).
///
/// The sheet is a base so that it is made before the texel space that refers to it, and stays where it is
/// when the space is moved.
class ImageSpace final : private std::unique_ptr<const ImageSheet>, public TexelSpace {
 public:
  ImageSpace(int width, int height, const Progress& progress = {});

  const ImageSheet& sheet() const { return **static_cast<const std::unique_ptr<const ImageSheet>*>(this); }
};

}  // namespace mq

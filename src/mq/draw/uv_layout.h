#pragma once
/// A texture with its atlas drawn over it: where the charts lie, where the seams run, what is
/// unused.

#include "mq/atlas/atlas.h"
#include "mq/base/progress.h"
#include "mq/draw/render.h"
#include "mq/image/image.h"

namespace mq {

struct UvLayoutOptions {
  int texture = 0;  ///< which of the atlas
  int side = 1024;  ///< pixels of the longer side of the picture, 1 to 16384
  /// What is shown: `zoom` 1 is the whole texture and all its charts; above, the part around the
  /// texture coordinate `center` that is so much smaller.
  double zoom = 1;
  Vector2 center = {0.5, 0.5};
  enum class Fill {
    texture,         ///< the picture; faded where no chart lies
    tinted_texture,  ///< the same, each chart tinted in its colour
    charts           ///< chart colours alone
  } fill = Fill::tinted_texture;
  RenderOptions::Lines seams = RenderOptions::Lines::show;  ///< and the ends of the surface
  RenderOptions::Lines wires = RenderOptions::Lines::hide;  ///< edges inside charts
  double line_width = 1.5;  ///< pixels at most; thinner where charts are small
  int samples = 2;          ///< per pixel and direction, 1 to 16
};

/// Red, green and blue. Texels are averaged where they are smaller than a sample and drawn as
/// squares, with a grid of their borders, where they are large (8 pixels and more). Places that two
/// triangles cover are hatched in red. `picture` may be null where `fill` is `charts`. Throws
/// `InvalidInput` when the atlas has no such texture or the picture does not fit it.
Image<float> draw_uv_layout(const Surface& surface, const Atlas& atlas, const Image<float>* picture,
                            const UvLayoutOptions& options = {}, const Progress& progress = {});

}  // namespace mq

#pragma once
/// Models to be drawn, and what is looked at in pictures of them.

#include <cmath>

#include "fixtures.h"
#include "mq/draw/render.h"

namespace mq::fixtures {

/// A mesh with one texture, ready to be drawn.
struct Model {
  Surface surface;
  Image<float> texture;
  Atlas atlas;

  Model(const Mesh& mesh, Image<float> image)
      : surface(make_surface(mesh)),
        texture(std::move(image)),
        atlas(make_atlas(surface, {{texture.width(), texture.height()}})) {}
  Paints paints() const { return {.textures = {&texture}, .vertex_values = {}}; }
};

inline bool is_colour(const Image<float>& image, int x, int y, const Colour& colour, float tolerance) {
  for (int k = 0; k < 3; ++k)
    if (std::abs(image(x, y, k) - colour[k]) > tolerance) return false;
  return true;
}

}  // namespace mq::fixtures

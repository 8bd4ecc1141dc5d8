#pragma once
/// What lies under the mouse.

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "mq/atlas/triangles_at.h"
#include "mq/draw/scene.h"
#include "options/model_options.h"
#include "texture_set.h"

namespace mq::view {

struct Pick {
  int triangle = -1;                      ///< -1: nothing
  Vector3 barycentric = Vector3::Zero();  ///< weights of its corners
  Vector3 point = Vector3::Zero();        ///< on the surface, model units
  int chart = -1;                         ///< -1: the triangle has none, nor what follows
  int texture = -1;
  double column = 0, row = 0;  ///< in texels, the centre of texel (i, j) at (i, j)
  int x = 0, y = 0;            ///< the texel nearest
  std::vector<float> values;   ///< its values; without a chart those of colours at vertices

  explicit operator bool() const { return triangle >= 0; }
};

/// Values of a model; either may be null.
struct ShownValues {
  const TextureSet* textures = nullptr;
  const VertexSignal* colours = nullptr;
};

/// What a line of sight meets.
Pick pick_on_surface(const TexturedModel& scene, const mq::Scene& rays, const ShownValues& values,
                     const Ray& ray);

/// The triangle that covers a place of a texture, the first where several do.
Pick pick_in_atlas(const TexturedModel& scene, const TrianglesAt& triangles,
                   const TextureSet* textures, int texture, double column, double row);

/// In one line, places to a ten thousandth of the model's `size`.
std::string in_words(const Pick& pick, double size);
nlohmann::ordered_json as_json(const Pick& pick);

}  // namespace mq::view

#pragma once
/// The colour of what a ray hits, and the light on it. Used inside this room.

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "mq/draw/render.h"
#include "mq/draw/scene.h"

namespace mq {

inline constexpr Colour clay = {0.80f, 0.79f, 0.765f};

bool shows_numbers(const RenderOptions& options);

/// The light that reaches a place, whatever is painted there.
struct LightAt {
  double light = 1;  ///< 1 where the surface faces the viewer
  double power = 1;  ///< light^(1/2.4)
  double gloss = 0;  ///< of clay
};

/// Everything that colours one picture; holds references.
struct Shader {
  const Surface& surface;
  const Atlas* atlas;
  const std::vector<Eigen::Vector3f>& normals;  ///< one per corner
  const Paints& paints;
  const RenderOptions& options;
  const Camera& camera;
  const Vector3 key_light =
      (-0.5 * camera.right() + 0.65 * camera.up() + 0.57 * camera.backward()).normalized();

  Colour albedo(const Hit& hit) const;
  /// The number shown where the ray hit; none where the surface has no texture.
  std::optional<float> number(const Hit& hit) const;
  /// With gloss where clay is shown.
  LightAt light_at(const Hit& hit) const;
  Colour lit(const Colour& colour, const LightAt& light) const;

 private:
  bool texture_values(const Hit& hit, std::span<float> values) const;
  Colour textured(const Hit& hit) const;
  float vertex_value(const Hit& hit, int count, int channel) const;
  Vector3 shading_normal(const Hit& hit) const;
};

}  // namespace mq

#pragma once
/// The shaders of the panes. The light is that of `marquetry render` (mq/draw/render.cpp).

namespace mq::view::shaders {

// Each is compiled for the branches that a picture takes (`PaneShaders`), which its first lines say as constants:
// PAINT (Look::Paint), TEXTURED, LIT, WIRES, WIPES (before is on the left), LIGHT (textures hold light), TINTED, REPEATS (the
// texture again outside it). A
// renderer without a graphics card goes through all branches that are there.

/// Values between texels as the texel spaces see them, and means where texels are smaller than
/// pixels.
inline constexpr const char* lookups = R"(
vec4 texel(sampler2D picture, ivec2 at) {
  ivec2 size = textureSize(picture, 0);
  if (REPEATS) at = ((at % size) + size) % size;
  return texelFetch(picture, clamp(at, ivec2(0), size - 1), 0);
}
vec4 between(sampler2D picture, vec2 at) {
  vec2 low = floor(at), part = at - low;
  ivec2 i = ivec2(low);
  return mix(mix(texel(picture, i), texel(picture, i + ivec2(1, 0)), part.x),
             mix(texel(picture, i + ivec2(0, 1)), texel(picture, i + ivec2(1, 1)), part.x), part.y);
}
vec4 looked_up(sampler2D picture, vec2 at, vec2 right, vec2 down) {
  int n = clamp(int(ceil(max(length(right), length(down)))), 1, 4);
  vec4 sum = vec4(0);
  // In place of a branch, both of whose sides that renderer goes through.
  for (int i = 0; i < (n == 1 ? 1 : 0); ++i) sum = between(picture, at);
  for (int j = 0; j < (n == 1 ? 0 : n); ++j)
    for (int i = 0; i < n; ++i) {
      vec2 part = (vec2(i, j) + 0.5) / n - 0.5;
      sum += texel(picture, ivec2(floor(at + part.x * right + part.y * down + 0.5)));
    }
  return sum / (n * n);
}
uniform sampler2D scale_colours;
uniform vec2 scale_range;
uniform int isolines;
vec3 false_colour(float value) {
  float t = clamp((value - scale_range.x) / (scale_range.y - scale_range.x), 0, 1);
  vec3 colour = texelFetch(scale_colours, ivec2(int(t * 1023 + 0.5), 0), 0).rgb;
  if (isolines > 0) {
    float band = t * (isolines + 1), near = abs(fract(band + 0.5) - 0.5) / max(fwidth(band), 1e-9);
    if (t > 0 && t < 1 && band > 0.5 && near < 0.7) colour = vec3(0.1, 0.1, 0.12);
  }
  return colour;
}
float srgb(float v) { return v <= 0.0031308 ? v * 12.92 : 1.055 * pow(v, 1 / 2.4) - 0.055; }
uniform vec2 channels, light_values;  // of the textures before and after
uniform int channel;
uniform float exposure;
uniform float wipe;  // pixels: before on the left of it; < 0: after alone
bool is_before() { return WIPES && gl_FragCoord.x < wipe; }
vec3 displayed(vec4 values) {
  int side = is_before() ? 0 : 1;
  vec3 rgb = channels[side] < 3 ? values.rrr : values.rgb;
  if (!LIGHT || light_values[side] == 0) return rgb;
  rgb = max(rgb, 0) * exposure;
  return vec3(srgb(rgb.r), srgb(rgb.g), srgb(rgb.b));
}
)";

inline constexpr const char* surface_vertex = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 texel;
layout(location = 3) in vec4 colour;
layout(location = 4) in vec4 colour_before;
uniform mat4 clip;
out vec3 at, shading_normal, corner;
out vec4 painted, painted_before;
centroid out vec2 place;
void main() {
  gl_Position = clip * vec4(position, 1);
  at = position, shading_normal = normal, place = texel, painted = colour;
  painted_before = colour_before;
  corner = vec3(gl_VertexID % 3 == 0, gl_VertexID % 3 == 1, gl_VertexID % 3 == 2);
}
)";

inline constexpr const char* surface_fragment = R"(
in vec3 at, shading_normal, corner;
in vec4 painted, painted_before;
centroid in vec2 place;
uniform sampler2D before, after;
uniform vec3 eye, up, key_light;
uniform float wires; // pixels
uniform float chart_tint;
out vec4 shown;
const vec3 clay = vec3(0.80, 0.79, 0.765);

float brightened(float v, float light, float power) {
  float curved = (v + 0.055) * power - 0.055, straight = v * light;
  return light < 1 ? max(curved, straight) : min(min(curved, straight), max(v, 1));
}
void main() {
  vec2 right = dFdx(place), down = dFdy(place);
  vec3 along_x = dFdx(at), along_y = dFdy(at);
  vec4 values = vec4(0);
  bool textured = TEXTURED && painted.a > 0.5;
  if (textured && (PAINT == 0 || PAINT == 5 || PAINT == 7 || PAINT == 8)) {
    if (WIPES && is_before()) values = looked_up(before, place, right, down);
    else values = looked_up(after, place, right, down);
  }
  vec3 colour = clay;
  vec3 view = normalize(eye - at), normal = normalize(shading_normal);
  bool is_clay = true;
  if (PAINT == 0 && textured) colour = displayed(values), is_clay = false;
  if ((PAINT == 2 || PAINT == 3 || PAINT == 4) && painted.a > 0.5) colour = painted.rgb, is_clay = false;
  if (PAINT == 5 && textured) colour = false_colour(values[channel]), is_clay = false;
  if (PAINT == 6) colour = is_before() ? painted_before.rgb : painted.rgb, is_clay = false;
  if (PAINT == 9) colour = painted.rgb, is_clay = false;
  if (PAINT == 7 && textured) normal = normalize(values.rgb * 2 - 1);
  if (PAINT == 8 && textured) {
    // Axes along the texture's columns and against its rows, from how place changes on the screen.
    vec3 a = cross(along_y, normal), b = cross(normal, along_x);
    vec3 u = a * right.x + b * down.x, v = -(a * right.y + b * down.y);
    float size = inversesqrt(max(max(dot(u, u), dot(v, v)), 1e-30));
    vec3 n = values.rgb * 2 - 1;
    normal = normalize(n.x * u * size + n.y * v * size + n.z * normal);
  }
  bool is_chart = PAINT == 0 || PAINT == 1 || PAINT == 5 || PAINT == 7 || PAINT == 8;
  if (TINTED && is_chart && painted.a > 0.5) colour = mix(colour, painted.rgb, chart_tint);
  bool back = !gl_FrontFacing;
  if (LIT) {
    if (dot(normal, view) < 0) normal -= 2 * dot(normal, view) * view;
    float key = max(0, dot(normal, key_light));
    float light = 0.22 + 0.10 * dot(normal, up) + 0.44 * dot(normal, view) + 0.36 * key;
    light = light / (0.22 + 0.44 + 0.36 * 0.57) * (back ? 0.45 : 1.0);
    float power = pow(max(light, 0), 1 / 2.4);
    float gloss = is_clay ? 0.06 * pow(max(0, dot(normalize(key_light + view), normal)), 40) : 0;
    for (int k = 0; k < 3; ++k) colour[k] = brightened(colour[k], light, power) + gloss;
  }
  if (WIRES) {
    vec3 near = corner / max(fwidth(corner), vec3(1e-9));
    float line = clamp(0.5 * wires + 0.5 - min(near.x, min(near.y, near.z)), 0, 1);
    colour = mix(colour, vec3(0.05, 0.05, 0.07), 0.55 * line);
  }
  shown = vec4(colour, 1);
}
)";

/// A triangle over the whole pane.
inline constexpr const char* whole_vertex = R"(#version 330 core
void main() { gl_Position = vec4(gl_VertexID == 1 ? 3 : -1, gl_VertexID == 2 ? 3 : -1, 0, 1); }
)";

inline constexpr const char* backdrop_fragment = R"(#version 330 core
uniform sampler2D picture;
out vec4 shown;
void main() {
  ivec2 size = textureSize(picture, 0);
  shown = vec4(texelFetch(picture, ivec2(gl_FragCoord.x, size.y - 1 - int(gl_FragCoord.y)), 0).rgb, 1);
}
)";

inline constexpr const char* atlas_fragment = R"(
uniform sampler2D before, after;
uniform vec2 corner, size;   // place of the pane's upper left, texels of the texture
uniform float zoom, height;
out vec4 shown;
void main() {
  vec2 pixel = vec2(gl_FragCoord.x, height - gl_FragCoord.y);
  vec2 place = corner + pixel / zoom;
  vec3 colour = vec3(0.86, 0.87, 0.885);
  vec2 inside = step(vec2(-0.5), place) * step(place, size - 0.5);
  if (inside.x * inside.y > 0) {
    colour = vec3(0.80, 0.79, 0.765);
    if (TEXTURED) {
      int n = clamp(int(ceil(1 / zoom)), 1, 4);
      vec4 values = vec4(0);
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
          ivec2 at = ivec2(floor(place + ((vec2(i, j) + 0.5) / n - 0.5) / zoom + 0.5));
          if (WIPES && is_before()) values += texel(before, at);
          else values += texel(after, at);
        }
      values /= n * n;
      if (PAINT == 5) colour = false_colour(values[channel]);
      else colour = displayed(values);
    }
  }
  shown = vec4(colour, 1);
}
)";

/// Triangles where they lie in the texture.
inline constexpr const char* tint_vertex = R"(#version 330 core
layout(location = 2) in vec2 texel;
layout(location = 3) in vec4 colour;
uniform vec2 corner, pane;
uniform float zoom;
out vec4 painted;
void main() {
  vec2 pixel = (texel - corner) * zoom / pane * 2 - 1;
  gl_Position = vec4(pixel.x, -pixel.y, 0, 1);
  painted = colour;
}
)";

inline constexpr const char* tint_fragment = R"(#version 330 core
in vec4 painted;
uniform float strength;
out vec4 shown;
void main() { shown = vec4(painted.rgb, painted.a * strength); }
)";

}  // namespace mq::view::shaders

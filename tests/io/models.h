#pragma once
/// Small models and pictures made in code.

#include <cmath>
#include <string>

#include "mq/io/model.h"

namespace mq {

/// A picture whose texels all differ.
inline Texture ramp_texture(const std::string& name, int width = 4, int height = 3) {
  Texture texture;
  texture.name = name;
  texture.pixels = Image<float>(width, height, 3);
  int i = 0;
  for (float& value : texture.pixels.values()) value = float(++i % 256) / 255;
  texture.format.file_format = "png";
  return texture;
}

/// Two triangles of a square, apart in the texture: one seam.
inline Model two_chart_square() {
  Model model;
  model.mesh.positions = {{0, 0, 0}, {1, 0, 0.1}, {1, 1, 0}, {0, 1, 1.0 / 3}};
  model.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  model.mesh.uvs = {{0.125, 0.125}, {0.4, 0.1}, {0.4, 0.4}, {0.5, 0.5}, {0.9, 0.9}, {0.5, 0.9}};
  model.mesh.corner_uvs = {{0, 1, 2}, {3, 4, 5}};
  model.textures = {ramp_texture("square.png")};
  return model;
}

/// The same with a texture for each triangle and colours at the vertices.
inline Model two_texture_square() {
  Model model = two_chart_square();
  model.mesh.textures = {0, 1};
  model.textures = {ramp_texture("left.png"), ramp_texture("right side.png", 5, 2)};
  model.colors.channels = 3;
  model.colors.depth = Depth::u8;
  for (int i = 0; i < 12; ++i) model.colors.values.push_back(float(20 * i) / 255);
  return model;
}

/// A smooth closed strip of `columns` × `rows` squares cut in two, for measuring.
inline Model wave(int columns, int rows) {
  Model model;
  for (int y = 0; y <= rows; ++y)
    for (int x = 0; x <= columns; ++x) {
      const double u = double(x) / columns, v = double(y) / rows;
      model.mesh.positions.emplace_back(u, v, 0.1 * std::sin(9 * u) * std::cos(7 * v));
      model.mesh.uvs.emplace_back(u, v);
    }
  const auto at = [&](int x, int y) { return y * (columns + 1) + x; };
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) {
      model.mesh.triangles.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
      model.mesh.triangles.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
    }
  model.mesh.corner_uvs = model.mesh.triangles;
  model.textures = {ramp_texture("wave.png")};
  return model;
}

}  // namespace mq

#pragma once
/// Normal maps made for a model.

#include "mq/image/normal_map.h"
#include "mq/mesh/surface_point.h"
#include "mq/model/model_signal.h"
#include "mq/sample/bumps.h"
#include "mq/sample/sample.h"

namespace mq::test {

/// A flat map in tangent space: (128, 128, 255) in 8 bits.
inline Texture flat_map(int side, Depth depth = Depth::u8) {
  Texture texture;
  texture.name = "normal.png";
  texture.pixels = Image<float>(side, side, 3);
  texture.format = {.depth = depth, .file_format = "png", .tags = nullptr};
  const float middle = depth == Depth::u8 ? 128.0F / 255 : 0.5F;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x)
      for (int c = 0; c < 3; ++c) texture.pixels(x, y, c) = c == 2 ? 1.0F : middle;
  return texture;
}

inline TexturedModel with_normal_map(Mesh mesh, Texture map) {
  Model model;
  model.path = "model.obj";
  model.mesh = std::move(mesh);
  model.textures.push_back(std::move(map));
  Messages messages;
  return textured_model(std::move(model), {}, messages);
}

/// The bust with a flat map; few triangles, so that tests take little.
inline TexturedModel flat_bust(int side, Depth depth = Depth::f32, int triangles = 5000) {
  return with_normal_map(make_sample("bust", {.texture_size = side, .triangles = triangles}).mesh,
                         flat_map(side, depth));
}

inline TextureSignalOptions normals_in(NormalAxes axes) {
  return {.values = {.meaning = ValueSpace::Meaning::normals, .axes = axes}};
}

inline TextureSignal normal_signal(const TexturedModel& model,
                                   NormalAxes axes = NormalAxes::tangent) {
  Messages messages;
  return TextureSignal(model, normals_in(axes), messages);
}

/// Bumps all over the surface: d = n − N.
inline Signal bumps(const TextureSignal& signal, double length, double height = Bumps{}.height) {
  const Signal shading = signal.shading_normals();
  Signal d = Signal::Zero(signal.space().size(), signal.channels());
  for (int i = 0; i < signal.space().size(); ++i) {
    const Vector3 n = shading.row(i).transpose();
    const Vector3 p = signal.space().texels().position(i);
    d.row(i).head<3>() = (bumpy(n, p, {length, height}) - n).transpose();
  }
  return d;
}

/// Puts bumps into the flat map of a model.
inline void paint_bumps(TexturedModel& model, double length, double height = Bumps{}.height) {
  const TextureSignal signal = normal_signal(model);
  const Signal flat = Signal::Zero(signal.space().size(), signal.channels());
  signal.put(flat, bumps(signal, length, height), model.model);
  model.model.textures[0].as_read = {};
}

}  // namespace mq::test

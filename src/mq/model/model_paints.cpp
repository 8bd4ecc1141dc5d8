#include "mq/model/model_paints.h"

#include <algorithm>
#include <array>

#include "mq/base/error.h"
#include "mq/io/vertex_colours.h"

namespace mq {

bool has_pictures(const TexturedModel& model) {
  return model.atlas && model.model.textures.size() == model.atlas->textures.size() &&
         std::ranges::none_of(model.model.textures,
                              [](const Texture& texture) { return texture.pixels.empty(); });
}

std::vector<const Image<float>*> pictures_of(std::span<const Texture> textures) {
  std::vector<const Image<float>*> pictures;
  for (const Texture& texture : textures) pictures.push_back(&texture.pixels);
  return pictures;
}

std::vector<float> surface_colours(const TexturedModel& model) {
  const VertexSignal& colors = model.model.colors;
  std::vector<float> values;
  if (colors.channels == 0) return values;
  for (const int source : model.surface.source_from_vertex) {
    const std::array<float, 3> shown = displayed_colour(colors, source);
    values.insert(values.end(), shown.begin(), shown.end());
  }
  return values;
}

RenderOptions::Paint best_paint(const TexturedModel& model) {
  using Paint = RenderOptions::Paint;
  if (has_pictures(model)) return Paint::texture;
  return model.model.colors.channels > 0 ? Paint::vertex_colours : Paint::clay;
}

FalseColour scale_of_textures(std::span<const Texture> textures, int channel,
                              FalseColour::Map map) {
  std::vector<float> values;
  for (const Texture& texture : textures)
    for (std::size_t i = std::size_t(channel); i < texture.pixels.values().size();
         i += std::size_t(texture.pixels.channels()))
      values.push_back(texture.pixels.values()[i]);
  return scale_of(values, map);
}

SeamDifference texture_seams(const TexturedModel& model, std::span<const Texture> textures) {
  require(model.atlas.has_value(),
          model.model.path.string() + ": has no texture coordinates, so no seams; the verb unwrap makes some");
  return seam_difference(model.surface, *model.atlas, pictures_of(textures));
}

SeamDifference texture_seams(const TexturedModel& model) {
  return texture_seams(model, model.model.textures);
}

SeamDifference texture_seams(const TexturedModel& model, const ShadingFrames& frames) {
  const SeenValue seen = [&](const SurfacePoint& point, std::span<float> value) {
    if (value.size() < 3) return;
    Vector3 mapped;
    for (int c = 0; c < 3; ++c) mapped[c] = 2 * double(value[std::size_t(c)]) - 1;
    const Vector3 normal = frames.at(point).to_model(mapped);
    for (int c = 0; c < 3; ++c) value[std::size_t(c)] = float((normal[c] + 1) / 2);
  };
  return seam_difference(model.surface, *model.atlas, pictures_of(model.model.textures), seen);
}

}  // namespace mq

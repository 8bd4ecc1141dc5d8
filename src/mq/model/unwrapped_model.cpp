#include "mq/model/unwrapped_model.h"

#include "mq/atlas/coverage.h"
#include "mq/io/normals.h"

namespace mq {

void put_unwrapped(const Unwrapped& unwrapped, TexturedModel& model) {
  forget_file(model.model, Tangents::forgotten);
  for (Mesh* mesh : {&model.model.mesh, &model.surface.mesh}) {
    mesh->uvs = unwrapped.uvs;
    mesh->corner_uvs = unwrapped.corner_uvs;
    mesh->textures.clear();
  }
  model.model.textures.clear();
  model.model.tiles.clear();
  model.model.uv_sets.clear();
  model.model.uv_set = -1;
  model.model.slot.clear();
  for (MaterialSlot& slot : model.model.slots) slot.with_texture.clear();
  model.atlas.reset();
  model.texture_sizes.clear();
}

std::int64_t overlapping_texels(const TexturedModel& model, TextureSize size,
                                const Progress& progress) {
  const Atlas atlas = make_atlas(model.surface, {size}, {}, progress.step("charts", 0.5));
  return overlapping_texels(texel_coverage(model.surface, atlas, progress.step("cover", 0.5)));
}

}  // namespace mq

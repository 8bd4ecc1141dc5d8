#include "mq/model/unwrapped_model.h"

#include "mq/atlas/coverage.h"
#include "mq/io/normals.h"

namespace mq {

static_assert(assumed_texture_side == UnwrapOptions{}.width, "an atlas is looked at as it was packed");

void forget_textures(Model& model) {
  forget_file(model, Tangents::forgotten);
  model.textures.clear();
  model.tiles.clear();
  model.uv_sets.clear();
  model.uv_set = -1;
  model.slot.clear();
  for (MaterialSlot& slot : model.slots) slot.with_texture.clear();
}

void put_unwrapped(const Unwrapped& unwrapped, TexturedModel& model) {
  forget_textures(model.model);
  for (Mesh* mesh : {&model.model.mesh, &model.surface.mesh}) {
    mesh->uvs = unwrapped.uvs;
    mesh->corner_uvs = unwrapped.corner_uvs;
    mesh->textures.clear();
  }
  model.atlas.reset();
  model.texture_sizes.clear();
}

std::int64_t overlapping_texels(const TexturedModel& model, TextureSize size,
                                const Progress& progress) {
  const Atlas atlas = make_atlas(model.surface, {size}, {}, progress.step("charts", 0.5));
  return overlapping_texels(texel_coverage(model.surface, atlas, progress.step("cover", 0.5)));
}

}  // namespace mq

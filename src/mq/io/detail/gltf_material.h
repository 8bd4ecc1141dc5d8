#pragma once
/// What the materials of a glTF file say about pictures.

#include <array>
#include <string>
#include <vector>

#include "mq/io/detail/gltf_file.h"
#include "mq/io/document.h"
#include "mq/io/materials.h"

namespace mq {

/// u' = a · (u, v, 1) for both rows: scaled, turned, moved.
using UvTransform = std::array<double, 6>;
inline constexpr UvTransform no_uv_transform{1, 0, 0, 0, 1, 0};

/// Whether u and v still grow where they did.
inline bool keeps_directions(const UvTransform& m) {
  return m[0] > 0 && m[1] == 0 && m[3] == 0 && m[4] > 0;
}

/// A picture that a material names for a slot.
struct GltfMap {
  std::string slot;  ///< (slots.h)
  std::int64_t image = -1;
  std::int64_t beside = -1;   ///< the same picture for other programs; −1: none
  std::int64_t sampler = -1;  ///< −1: none
  int set = 0;                ///< TEXCOORD_set
  UvTransform transform = no_uv_transform;
};

/// The pictures of a material: members of it, of its pbrMetallicRoughness and of its extensions, the
/// base colour first. Of two for one slot the first counts; KHR_texture_transform may name a set of its
/// own. Of a texture with EXT_texture_webp the WebP counts, which programs that know it show; its fallback
/// is `beside`. Of one with KHR_texture_basisu the fallback counts, as KTX2 cannot be read. Throws
/// `IoError` with the place where a number is none or an index is out of range.
std::vector<GltfMap> material_maps(const GltfFile& file, std::int64_t material);

/// What a material says beside them. Numbers out of their range are taken as they are. Throws `IoError`
/// where one is none.
Material gltf_material(const GltfFile& file, std::int64_t material);

/// Gives a new material of a glTF file these words. Its pictures, by the members that name them
/// ("normalTexture"), are there already.
void add_material_words(const Material& material, nlohmann::ordered_json& json);

/// A picture of the file: its name ("texture_N" for an embedded one without) and, embedded, its bytes.
/// Throws `IoError` where it has neither.
TextureSlot image_slot(const GltfFile& file, std::int64_t image);

/// What the primitives of all meshes use.
struct GltfUses {
  std::vector<MaterialSlot> slots;
  std::vector<std::int64_t> materials;
  int uv_sets = 0;  ///< the most that a primitive has
};
GltfUses uses_of_materials(const GltfFile& file);

}  // namespace mq

#pragma once
/// Slots of materials: what a picture is given for. glTF and material libraries of OBJ files use one
/// set of names here.
///
/// | name | glTF | MTL |
/// |---|---|---|
/// | `base-colour` | `baseColorTexture`, `diffuseTexture` | `map_Kd` |
/// | `metallic-roughness` | `metallicRoughnessTexture` | |
/// | `normal` | `normalTexture` | `norm`, `map_Kn` |
/// | `bump` | | `map_Bump`, `bump` |
/// | `occlusion` | `occlusionTexture` | `map_AO` |
/// | `emissive` | `emissiveTexture` | `map_Ke` |
/// | `roughness`, `metallic`, `sheen` | | `map_Pr`, `map_Pm`, `map_Ps` |
/// | `specular-colour`, `ambient`, `shininess`, `opacity` | | `map_Ks`, `map_Ka`, `map_Ns`, `map_d` |
/// | `displacement` | | `disp`, `map_disp` |
///
/// Others of glTF, which extensions bring, go by their own words: `clearcoatRoughnessTexture` is
/// `clearcoat-roughness`.

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "mq/io/model.h"

namespace mq {

inline constexpr const char* base_slot = "base-colour";

/// The slot of a member of a glTF material ("normalTexture"); empty: it is none.
std::string slot_of_gltf(std::string_view member);

/// The slot of a keyword of an MTL file ("map_Kd", capitals do not matter); empty: it names no picture.
std::string slot_of_mtl(std::string_view keyword);

/// The keyword that a new MTL file uses for a slot; null: MTL has none.
const char* mtl_keyword(const std::string& slot);

/// The slot that a user's word means: its name, the file's own word, or what other programs say
/// ("albedo", "orm", "ao"). A word that is not known is given back as it is.
std::string slot_from_text(std::string_view text);

/// The member of a glTF material for a slot; null: glTF has none without extensions.
const char* gltf_keyword(const std::string& slot);

/// A picture of a material: a number among the textures of the model, then its `others`.
struct SlotPicture {
  std::string slot;
  int picture = 0;
};

/// What the material of one of the model's textures has in a file of `path`'s format that is made anew:
/// the texture, then pictures of the other slots that go with it and that the format has a word for.
std::vector<SlotPicture> material_pictures(const Model& model, int texture,
                                           const std::filesystem::path& path);

/// Which of the model's pictures, its textures and then its `others`, such a file names.
std::vector<char> named_pictures(const Model& model, const std::filesystem::path& path);

/// The other slots that such a file does not have, or not whole.
std::vector<std::string> slots_left_out(const Model& model, const std::filesystem::path& path);

/// What a material has beside its texture: by slots, as `MaterialSlot::with_texture` counts.
struct MaterialCompanions {
  int texture = 0;
  std::map<std::string, int> pictures;
};

/// Sets `MaterialSlot::with_texture` of all slots by what the materials with textures have. Where two say
/// different things of one texture, it has none.
void set_companions(std::vector<MaterialSlot>& slots, std::size_t textures,
                    const std::vector<MaterialCompanions>& materials);

/// What the values of a slot's pictures are.
TextureMeaning meaning_of_slot(const std::string& slot);

/// The slot to be read of those that a file has: the one that is asked for; else `base_slot` if it is
/// there, else the only one, else `base_slot` without pictures. A model may lack the base colour; for
/// any other that is asked for and missing throws `InvalidInput` with what `file` has.
std::string chosen_slot(const std::vector<MaterialSlot>& slots, const std::string& asked,
                        const std::string& file);

/// The slot of pictures that are given for a model whose materials do not name it: any that formats have a word
/// for, extensions of glTF too. Throws `InvalidInput` for others, with the nearest.
std::string known_slot(const std::string& asked, const std::string& file);

/// Notes that a picture is named for a slot, with a set of texture coordinates.
void add_to_slots(std::vector<MaterialSlot>& slots, const std::string& slot,
                  const std::string& picture, int uv_set);

/// "base-colour, normal"
std::string names_of(const std::vector<MaterialSlot>& slots);

}  // namespace mq

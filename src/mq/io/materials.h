#pragma once
/// What materials say beside their pictures, so that a file made anew says it too.

#include <array>
#include <compare>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mq/io/model.h"

namespace mq {

/// A material in the terms of glTF 2.0. Factors are what its pictures are multiplied by, and what it
/// shows in slots where it has none; those of colours are light. Of MTL, Kd and Ke are those factors
/// where no picture stands for them, d (1 − Tr) is that of alpha.
struct Material {
  enum class Alpha { opaque, mask, blend };

  std::string name;
  std::array<float, 4> base_colour{1, 1, 1, 1};
  std::optional<float> metallic, roughness;  ///< nothing: the file's format has no word for them, or said none
  std::array<float, 3> emissive{0, 0, 0};
  float normal_scale = 1;
  float occlusion_strength = 1;
  Alpha alpha = Alpha::opaque;
  float alpha_cutoff = 0.5F;
  bool is_double_sided = false;
  /// What else it says without pictures, for files of its own format: lines of MTL, or the members of
  /// glTF's `extensions` as JSON.
  std::string more_mtl, more_gltf;
  std::vector<std::string> slots;  ///< for which it names pictures (slots.h)

  bool operator==(const Material&) const = default;

  bool names_picture(const std::string& slot) const;
};

/// Whether two materials look alike where their pictures do: all but names and pictures is equal.
bool look_alike(Material a, Material b);
bool all_look_alike(const std::vector<const Material*>& materials);

/// What MTL files made anew call the material of triangles of which none is known. One of that name that
/// says nothing is none.
inline constexpr const char* unknown_material = "untextured";

/// What a material shows in a slot: the factor of each of up to four channels of its picture, 1 beyond.
struct SlotFactor {
  enum class Kind {
    light,    ///< of light
    values,   ///< of numbers as they are
    normals,  ///< of a normal's x and y
    towards_1,  ///< 1 + f (v − 1)
    unknown   ///< the slot is none of those for which `Material` has one
  } kind = Kind::unknown;
  std::array<double, 4> factor{1, 1, 1, 1};
};
SlotFactor slot_factor(const Material& material, const std::string& slot);

/// The materials of a model and, per triangle, which it has; −1: none.
struct ModelMaterials {
  std::vector<Material> materials;
  std::vector<int> of_triangle;

  /// The material of a triangle; null: none.
  const Material* of(int triangle) const;

  /// Those that triangles have.
  std::vector<const Material*> used() const;
};

/// What the file that a model came from says of materials, read anew from its bytes; of a model
/// without a file its `materials`. Nothing where there are none, as in PLY, or its triangles are no longer
/// as many as the model's. Throws what `read_model` throws.
ModelMaterials file_materials(const Model& model);

/// `material` for all triangles.
ModelMaterials one_for_all(Material material, int triangles);

/// A material whose pictures for these slots have its factors in them: those are 1, that of emission 0 where
/// nothing shines. The factor of alpha stays where it is asked for.
enum class AlphaFactor { in_picture, stays };
Material without_factors(Material material, const std::vector<std::string>& slots,
                         AlphaFactor alpha = AlphaFactor::in_picture);

/// One material for all: what they say where they look alike; else what all have in common, that blends where
/// any blends and has both sides where any has, without the factors of these slots, which are in the pictures.
Material joined(const std::vector<const Material*>& materials, const std::vector<std::string>& slots);

/// What of materials that do not look alike is not in `joined`, in words; empty: nothing.
std::string lost_by_joining(const std::vector<const Material*>& materials, const std::vector<std::string>& slots);

/// A material of a file made anew: with this texture of the model and what material of it; −1: none.
struct NewMaterial {
  int texture = -1;
  int material = -1;
  auto operator<=>(const NewMaterial&) const = default;
};

/// That of a triangle.
NewMaterial material_of(const Model& model, const ModelMaterials& materials, int triangle);

/// Those of such a file: for each texture those that its triangles have, one for a texture that no
/// triangle has; then those without a texture. A texture or material whose triangles have neither is
/// in none.
std::vector<NewMaterial> new_materials(const Model& model, const ModelMaterials& materials);

/// The material libraries that `write_model` writes beside an OBJ file `path`, from its folder; empty beside other
/// files. `pictures` are names of the model's textures, or of those that it will have, then of its `others`, as
/// `write_obj` takes them. A library that stays what and where it is counts for none.
std::vector<std::string> libraries_beside(const std::filesystem::path& path, const Model& model,
                                          const std::vector<std::string>& pictures);

/// What of the materials a file of `path`'s format does not say, in words; empty: nothing.
std::string materials_left_out(const ModelMaterials& materials, const std::filesystem::path& path);

}  // namespace mq

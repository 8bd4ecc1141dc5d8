#include "mq/io/detail/gltf_material.h"

#include <fmt/format.h>

#include <algorithm>
#include <climits>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "mq/io/slots.h"
#include "mq/io/uri.h"

namespace mq {
namespace {

const char* picture_extension(ByteView bytes) {
  const std::string_view text = text_of(bytes);
  if (text.starts_with("\xff\xd8")) return ".jpg";
  if (text.starts_with("RIFF") && text.substr(0, 12).ends_with("WEBP")) return ".webp";
  if (text.starts_with("\xabKTX 20")) return ".ktx2";
  return ".png";
}

class MaterialReader {
 public:
  MaterialReader(const GltfFile& file, std::int64_t id)
      : file_(file), place_(file.place("materials", id)) {
    const Json& material = file.item("materials", id);
    if (const Json* metallic = json_object(material, "pbrMetallicRoughness")) read(*metallic);
    read(material);
    if (const Json* extensions = json_object(material, "extensions"))
      for (const auto& [name, extension] : extensions->items())
        if (extension.is_object()) read(extension);
    std::stable_partition(maps_.begin(), maps_.end(),
                          [](const GltfMap& map) { return map.slot == base_slot; });
  }

  std::vector<GltfMap> maps() { return std::move(maps_); }

 private:
  void read(const Json& object) {
    for (const auto& [member, info] : object.items()) {
      const std::string slot = slot_of_gltf(member);
      if (slot.empty() || !info.is_object() ||
          std::ranges::find(maps_, slot, &GltfMap::slot) != maps_.end())
        continue;
      add(slot, info);
    }
  }

  int set(const Json& object, int otherwise) const {
    return int(std::min<std::int64_t>(json_count(object, "texCoord", otherwise, place_), INT_MAX));
  }

  void add(const std::string& slot, const Json& info) {
    GltfMap map;
    map.slot = slot;
    map.set = set(info, 0);
    const Json* extensions = json_object(info, "extensions");
    if (const Json* t = extensions ? json_object(*extensions, "KHR_texture_transform") : nullptr) {
      const auto offset = json_numbers(*t, "offset", {0, 0}, place_);
      const auto scale = json_numbers(*t, "scale", {1, 1}, place_);
      const double turn = json_number(*t, "rotation", 0, place_);
      const double c = std::cos(turn), s = std::sin(turn);
      map.transform = {c * scale[0],  s * scale[1], offset[0],
                       -s * scale[0], c * scale[1], offset[1]};
      map.set = set(*t, map.set);
    }
    const Json& texture = file_.item("textures", json_count(info, "index", -1, place_));
    find_images(texture, map);
    if (map.image < 0) {
      if (slot == base_slot) file_.fail(place_, "its texture has no image");
      return;
    }
    map.sampler = json_count(texture, "sampler", -1, place_);
    maps_.push_back(map);
  }

  void find_images(const Json& texture, GltfMap& map) const {
    if (texture.contains("source")) map.image = json_count(texture, "source", 0, place_);
    const Json* extensions = json_object(texture, "extensions");
    if (!extensions) return;
    for (const auto& [name, extension] : extensions->items()) {
      if (!extension.is_object() || !extension.contains("source")) continue;
      const std::int64_t image = json_count(extension, "source", 0, place_);
      if (map.image < 0 || name == "EXT_texture_webp") {
        map.beside = map.image;
        map.image = image;
      } else {
        map.beside = image;
      }
    }
    if (map.beside == map.image) map.beside = -1;
  }

  const GltfFile& file_;
  const std::string place_;
  std::vector<GltfMap> maps_;
};

/// The nearest that is finite.
float to_float(double number) {
  constexpr double largest = std::numeric_limits<float>::max();
  return float(std::clamp(number, -largest, largest));
}

template <std::size_t size>
std::array<float, size> factors(const Json& object, const char* key, float otherwise,
                                const std::string& place) {
  const auto numbers = json_numbers(object, key, std::vector<double>(size, otherwise), place);
  std::array<float, size> result;
  std::ranges::transform(numbers, result.begin(), to_float);
  return result;
}

/// As glTF wants factors, 0 to 1.
float in_range(float factor) { return std::clamp(factor, 0.0F, 1.0F); }

template <std::size_t size>
std::array<float, size> in_range(std::array<float, size> factors) {
  for (float& factor : factors) factor = in_range(factor);
  return factors;
}

/// What extensions say of a material without pictures; empty: nothing. That of other factors in place of
/// glTF's own is left out, as its pictures become glTF's.
std::string extensions_without_pictures(const Json& material) {
  const Json* extensions = json_object(material, "extensions");
  Json kept = Json::object();
  if (!extensions) return "";
  for (const auto& [name, extension] : extensions->items()) {
    if (!name.starts_with("KHR_materials_") || name.ends_with("pbrSpecularGlossiness") ||
        !extension.is_object())
      continue;
    Json& copy = kept[name] = Json::object();
    for (const auto& [member, value] : extension.items())
      if (slot_of_gltf(member).empty()) copy[member] = value;
  }
  return kept.empty() ? "" : kept.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

Material gltf_material(const GltfFile& file, std::int64_t id) {
  const Json& json = file.item("materials", id);
  const std::string place = file.place("materials", id);
  const auto member = [&](const char* picture, const char* key) {
    const Json* info = json_object(json, picture);
    return info ? to_float(json_number(*info, key, 1, place)) : 1.0F;
  };
  Material material;
  material.name = json_text_of(json, "name");
  const Json empty = Json::object();
  const Json* found = json_object(json, "pbrMetallicRoughness");
  const Json& metallic = found ? *found : empty;
  material.base_colour = factors<4>(metallic, "baseColorFactor", 1, place);
  material.metallic = to_float(json_number(metallic, "metallicFactor", 1, place));
  material.roughness = to_float(json_number(metallic, "roughnessFactor", 1, place));
  material.emissive = factors<3>(json, "emissiveFactor", 0, place);
  material.normal_scale = member("normalTexture", "scale");
  material.occlusion_strength = member("occlusionTexture", "strength");
  const std::string alpha = json_text_of(json, "alphaMode");
  if (alpha == "MASK") material.alpha = Material::Alpha::mask;
  if (alpha == "BLEND") material.alpha = Material::Alpha::blend;
  material.alpha_cutoff = to_float(json_number(json, "alphaCutoff", 0.5, place));
  const auto sides = json.find("doubleSided");
  material.is_double_sided = sides != json.end() && sides->is_boolean() && sides->get<bool>();
  material.more_gltf = extensions_without_pictures(json);
  for (const GltfMap& map : material_maps(file, id)) material.slots.push_back(map.slot);
  return material;
}

void add_material_words(const Material& material, nlohmann::ordered_json& json) {
  nlohmann::ordered_json metallic = json.value("pbrMetallicRoughness", nlohmann::ordered_json::object());
  const bool has_map = metallic.contains("metallicRoughnessTexture");
  // What was not said is matt, as MTL has it, and so is what a picture said that is not here.
  const bool lost_map = !has_map && material.names_picture("metallic-roughness");
  const float metal = lost_map ? 0.0F : material.metallic.value_or(has_map ? 1.0F : 0.0F);
  const float rough = lost_map ? 1.0F : material.roughness.value_or(1);
  if (metal != 1) metallic["metallicFactor"] = in_range(metal);
  if (rough != 1) metallic["roughnessFactor"] = in_range(rough);
  if (material.base_colour != Material().base_colour) metallic["baseColorFactor"] = in_range(material.base_colour);
  if (!metallic.empty()) json["pbrMetallicRoughness"] = metallic;
  const bool shines = json.contains("emissiveTexture") || !material.names_picture("emissive");
  if (shines && material.emissive != Material().emissive) json["emissiveFactor"] = in_range(material.emissive);
  if (json.contains("normalTexture") && material.normal_scale != 1)
    json["normalTexture"]["scale"] = material.normal_scale;
  if (json.contains("occlusionTexture") && material.occlusion_strength != 1)
    json["occlusionTexture"]["strength"] = material.occlusion_strength;
  if (material.alpha == Material::Alpha::mask) json["alphaMode"] = "MASK";
  if (material.alpha == Material::Alpha::mask && material.alpha_cutoff != 0.5F)
    json["alphaCutoff"] = material.alpha_cutoff;
  if (material.alpha == Material::Alpha::blend) json["alphaMode"] = "BLEND";
  if (material.is_double_sided) json["doubleSided"] = true;
  if (!material.name.empty()) json["name"] = material.name;
  if (!material.more_gltf.empty())
    json["extensions"] = nlohmann::ordered_json::parse(material.more_gltf);
}

std::vector<GltfMap> material_maps(const GltfFile& file, std::int64_t material) {
  return MaterialReader(file, material).maps();
}

TextureSlot image_slot(const GltfFile& file, std::int64_t id) {
  const Json& image = file.item("images", id);
  const std::string place = file.place("images", id);
  const std::string uri = json_text_of(image, "uri");
  TextureSlot slot;
  if (!uri.empty() && !uri.starts_with("data:")) {
    slot.name = name_of_uri(uri);
    return slot;
  }
  if (!uri.empty()) {
    auto bytes = data_of_uri(uri);
    if (!bytes) file.fail(place, "its data URI is not base64");
    slot.picture = std::move(*bytes);
  } else if (image.contains("bufferView")) {
    const ByteView bytes = file.bytes(file.view(json_count(image, "bufferView", 0, place)));
    slot.picture.assign(bytes.begin(), bytes.end());
  }
  if (slot.picture.empty()) file.fail(place, "it has neither a name nor data");
  const std::string name = json_text_of(image, "name");
  slot.name = name.empty() ? fmt::format("texture_{}", id) : portable_name(name);
  const std::string extension = std::filesystem::path(slot.name).extension().string();
  if (extension != ".png" && extension != ".jpg" && extension != ".jpeg" && extension != ".webp" &&
      extension != ".ktx2")
    slot.name += picture_extension(slot.picture);
  return slot;
}

GltfUses uses_of_materials(const GltfFile& file) {
  GltfUses uses;
  std::set<std::int64_t> seen;
  std::map<std::int64_t, std::string> names;
  for (std::size_t m = 0; m < file.size("meshes"); ++m) {
    const std::string place = file.place("meshes", std::int64_t(m));
    for (const Json& primitive :
         json_array(file.item("meshes", std::int64_t(m)), "primitives", place)) {
      if (!primitive.is_object()) continue;
      if (const Json* attributes = json_object(primitive, "attributes")) {
        int sets = 0;
        while (attributes->contains(fmt::format("TEXCOORD_{}", sets))) ++sets;
        uses.uv_sets = std::max(uses.uv_sets, sets);
      }
      const std::int64_t material = json_count(primitive, "material", -1, place);
      if (material < 0 || !seen.insert(material).second) continue;
      uses.materials.push_back(material);
      for (const GltfMap& map : material_maps(file, material)) {
        auto name = names.find(map.image);
        if (name == names.end())
          name = names.emplace(map.image, image_slot(file, map.image).name).first;
        add_to_slots(uses.slots, map.slot, name->second, map.set);
      }
    }
  }
  return uses;
}

}  // namespace mq

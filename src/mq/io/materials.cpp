#include "mq/io/materials.h"

#include <algorithm>
#include <map>
#include <set>
#include <unordered_map>
#include <utility>

#include "mq/io/detail/gltf_material.h"
#include "mq/io/detail/gltf_scene.h"
#include "mq/io/detail/mtl.h"
#include "mq/io/detail/obj.h"
#include "mq/io/document.h"
#include "mq/io/file_names.h"
#include "mq/io/slots.h"

namespace mq {
namespace {

/// Whether it is that of triangles of which none is known.
bool is_unknown(const Material& material) {
  Material nothing;
  nothing.name = unknown_material;
  return material.name == unknown_material && material.slots.empty() && look_alike(material, nothing);
}

ModelMaterials obj_file_materials(const Document& document) {
  const ObjFile file = parse_obj(document.bytes, document.name);
  std::unordered_map<std::string, Material> known;
  for (const Part& part : document.parts)
    for (MtlMaterial& m : parse_mtl(part.bytes)) known.try_emplace(m.name, std::move(m.look));
  ModelMaterials found;
  std::vector<int> numbers;
  for (const std::string& name : file.materials) {
    const auto material = known.find(name);
    const bool is_known = material != known.end() && !is_unknown(material->second);
    numbers.push_back(is_known ? int(found.materials.size()) : -1);
    if (is_known) found.materials.push_back(material->second);
  }
  for (const int id : file.mesh.textures)
    found.of_triangle.push_back(id < 0 ? -1 : numbers[std::size_t(id)]);
  return found;
}

ModelMaterials gltf_file_materials(const Document& document) {
  const GltfFile file(document);
  const GltfScene scene = read_gltf_scene(file, document.choice);
  ModelMaterials found;
  std::map<std::int64_t, int> numbers;
  for (std::size_t i = 0; i < scene.triangles.size(); ++i) {
    const GltfTriangles& part = scene.triangles[i];
    const bool is_last = i + 1 == scene.triangles.size();
    const std::size_t end = is_last ? scene.file.mesh.triangles.size() : scene.triangles[i + 1].begin;
    int number = -1;
    if (part.material >= 0) {
      const auto place = numbers.try_emplace(part.material, int(found.materials.size()));
      if (place.second) found.materials.push_back(gltf_material(file, part.material));
      number = place.first->second;
    }
    found.of_triangle.resize(end, number);
  }
  return found;
}

bool is_common(const std::vector<const Material*>& materials, auto member) {
  return std::ranges::all_of(materials, [&](const Material* m) { return m->*member == materials[0]->*member; });
}

}  // namespace

bool all_look_alike(const std::vector<const Material*>& materials) {
  return std::ranges::all_of(materials, [&](const Material* m) { return look_alike(*m, *materials[0]); });
}

bool Material::names_picture(const std::string& slot) const { return std::ranges::count(slots, slot) > 0; }

bool look_alike(Material a, Material b) {
  for (Material* m : {&a, &b}) {
    m->name.clear();
    m->more_mtl.clear();
    m->slots.clear();
  }
  return a == b;
}

const Material* ModelMaterials::of(int triangle) const {
  if (std::size_t(triangle) >= of_triangle.size()) return nullptr;
  const int id = of_triangle[std::size_t(triangle)];
  return id < 0 ? nullptr : &materials[std::size_t(id)];
}

std::vector<const Material*> ModelMaterials::used() const {
  std::vector<char> is_used(materials.size(), 0);
  for (const int id : of_triangle)
    if (id >= 0) is_used[std::size_t(id)] = 1;
  std::vector<const Material*> found;
  for (std::size_t i = 0; i < materials.size(); ++i)
    if (is_used[i]) found.push_back(&materials[i]);
  return found;
}

SlotFactor slot_factor(const Material& material, const std::string& slot) {
  using Kind = SlotFactor::Kind;
  const double metallic = material.metallic.value_or(1), roughness = material.roughness.value_or(1);
  const auto& base = material.base_colour;
  const auto& shine = material.emissive;
  if (slot == base_slot) return {Kind::light, {base[0], base[1], base[2], base[3]}};
  if (slot == "emissive") return {Kind::light, {shine[0], shine[1], shine[2], 1}};
  if (slot == "metallic-roughness") return {Kind::values, {1, roughness, metallic, 1}};
  if (slot == "roughness") return {Kind::values, {roughness, roughness, roughness, 1}};
  if (slot == "metallic") return {Kind::values, {metallic, metallic, metallic, 1}};
  if (slot == "occlusion") return {Kind::towards_1, {material.occlusion_strength, 1, 1, 1}};
  if (slot == "normal") return {Kind::normals, {material.normal_scale, material.normal_scale, 1, 1}};
  return {};
}

ModelMaterials one_for_all(Material material, int triangles) {
  return {{std::move(material)}, std::vector<int>(std::size_t(triangles), 0)};
}

ModelMaterials file_materials(const Model& model) {
  ModelMaterials found;
  if (!model.document && model.materials) found = *model.materials;
  if (model.document && model.document->format == Document::Format::obj)
    found = obj_file_materials(*model.document);
  if (model.document && model.document->is_gltf()) found = gltf_file_materials(*model.document);
  const bool fits = found.of_triangle.size() == model.mesh.triangles.size();
  return fits && !found.materials.empty() ? found : ModelMaterials{};
}

Material without_factors(Material material, const std::vector<std::string>& slots, AlphaFactor alpha) {
  const auto has = [&](const char* slot) { return std::ranges::count(slots, slot) > 0; };
  if (has(base_slot))
    for (std::size_t c = 0; c < 4; ++c)
      if (c < 3 || alpha == AlphaFactor::in_picture) material.base_colour[c] = 1;
  const bool shines = std::ranges::any_of(material.emissive, [](float e) { return e != 0; });
  if (has("emissive")) material.emissive.fill(shines ? 1 : 0);
  if (has("metallic-roughness") || has("metallic")) material.metallic = 1;
  if (has("metallic-roughness") || has("roughness")) material.roughness = 1;
  if (has("normal")) material.normal_scale = 1;
  if (has("occlusion")) material.occlusion_strength = 1;
  return material;
}

Material joined(const std::vector<const Material*>& materials, const std::vector<std::string>& slots) {
  Material result;
  if (materials.empty()) return result;
  result = *materials[0];
  std::set<std::string> named;
  for (const Material* m : materials) named.insert(m->slots.begin(), m->slots.end());
  result.slots.assign(named.begin(), named.end());
  const Material nothing;
  const auto keep_common = [&](auto member) {
    if (!is_common(materials, member)) result.*member = nothing.*member;
  };
  keep_common(&Material::name);
  keep_common(&Material::more_mtl);
  keep_common(&Material::more_gltf);
  if (all_look_alike(materials)) return result;
  keep_common(&Material::base_colour);
  keep_common(&Material::metallic);
  keep_common(&Material::roughness);
  keep_common(&Material::normal_scale);
  keep_common(&Material::occlusion_strength);
  keep_common(&Material::alpha_cutoff);
  const bool shines_by_picture = std::ranges::count(slots, std::string("emissive")) > 0;
  for (const Material* m : materials) {
    for (std::size_t c = 0; c < 3 && shines_by_picture; ++c)
      result.emissive[c] = std::max(result.emissive[c], m->emissive[c]);
    result.alpha = std::max(result.alpha, m->alpha);
    result.is_double_sided = result.is_double_sided || m->is_double_sided;
  }
  if (!shines_by_picture) keep_common(&Material::emissive);
  return without_factors(std::move(result), slots);
}

std::string lost_by_joining(const std::vector<const Material*>& materials, const std::vector<std::string>& slots) {
  std::string lost;
  const auto add = [&](bool is_lost, const char* what) {
    if (is_lost) lost += (lost.empty() ? "" : ", ") + std::string(what);
  };
  if (materials.empty()) return lost;
  const auto by_factor = [&](const char* slot) { return std::ranges::count(slots, std::string(slot)) == 0; };
  add(!is_common(materials, &Material::emissive) && by_factor("emissive"), "emission");
  const bool in_common = is_common(materials, &Material::metallic) && is_common(materials, &Material::roughness);
  add(!in_common && by_factor("metallic-roughness"), "metal and roughness");
  add(!is_common(materials, &Material::occlusion_strength) && by_factor("occlusion"), "the strength of occlusion");
  add(!is_common(materials, &Material::alpha), "which are transparent");
  add(!is_common(materials, &Material::more_gltf), "extensions");
  return lost;
}

NewMaterial material_of(const Model& model, const ModelMaterials& materials, int triangle) {
  return {model.textures.empty() ? -1 : model.mesh.texture(triangle),
          materials.of_triangle.empty() ? -1 : materials.of_triangle[std::size_t(triangle)]};
}

std::vector<NewMaterial> new_materials(const Model& model, const ModelMaterials& materials) {
  std::set<NewMaterial> used;
  const auto textures = int(model.textures.size());
  for (int t = 0; t < model.mesh.triangle_count(); ++t) used.insert(material_of(model, materials, t));
  std::vector<NewMaterial> result;
  for (int texture = 0; texture < textures; ++texture) {
    const auto begin = used.lower_bound({texture, -1}), end = used.lower_bound({texture + 1, -1});
    result.insert(result.end(), begin, end);
    if (begin == end) result.push_back({texture, -1});
  }
  std::copy_if(used.begin(), used.lower_bound({0, -1}), std::back_inserter(result),
               [](const NewMaterial& one) { return one.material >= 0; });
  return result;
}

std::string materials_left_out(const ModelMaterials& materials, const std::filesystem::path& path) {
  std::string left_out;
  const auto add = [&](bool any, const char* what) {
    if (any) left_out += (left_out.empty() ? "" : ", ") + std::string(what);
  };
  const auto any = [&](auto says) { return std::ranges::any_of(materials.materials, says); };
  if (lower_extension(path) == ".obj") {
    add(any([](const Material& m) { return m.is_double_sided; }), "that they have two sides");
    add(any([](const Material& m) { return m.alpha == Material::Alpha::mask; }), "where alpha cuts");
    add(any([](const Material& m) { return !m.more_gltf.empty(); }), "their extensions");
    return left_out;
  }
  add(any([](const Material& m) { return !m.more_mtl.empty(); }), "highlights and other lines of their MTL");
  return left_out;
}

}  // namespace mq

// What materials make of the lines of an OBJ file: the pictures of one slot are its textures.
#include <algorithm>
#include <map>
#include <unordered_map>

#include "mq/io/detail/mtl.h"
#include "mq/io/detail/obj.h"
#include "mq/io/slots.h"

namespace mq {
namespace {

/// Looks up the pictures of a file's materials.
class MaterialLookup {
 public:
  MaterialLookup(const ObjFile& file, const Document& document) : file_(file) {
    for (std::size_t p = 0; p < document.parts.size(); ++p) {
      const std::string folder = std::filesystem::path(document.parts[p].name).parent_path();
      for (MtlMaterial& m : parse_mtl(document.parts[p].bytes)) {
        m.end.part = int(p);
        for (MaterialMap& map : m.maps) {
          map.place.part = int(p);
          map.picture = (std::filesystem::path(folder) / portable_name(map.picture)).string();
        }
        materials_.try_emplace(m.name, std::move(m));
      }
    }
    for (const std::string& name : file_.materials)
      if (const MtlMaterial* m = find(name))
        for (const MaterialMap& map : m->maps) add_to_slots(slots_, map.slot, map.picture, 0);
  }

  const std::vector<MaterialSlot>& slots() const { return slots_; }

  const MtlMaterial* find(const std::string& name) const {
    const auto found = materials_.find(name);
    return found == materials_.end() ? nullptr : &found->second;
  }

  /// Textures of the materials for a slot, in `file`; −1 for a material without one.
  std::vector<int> textures(const std::string& slot, MeshFile& file) const {
    std::vector<int> texture_from_material;
    std::map<std::string, int> ids;
    const bool any = std::ranges::find(slots_, slot, &MaterialSlot::name) != slots_.end();
    for (const std::string& name : file_.materials) {
      const MtlMaterial* m = find(name);
      const MaterialMap* map = m ? m->map(slot) : nullptr;
      if (any && !map) {
        texture_from_material.push_back(-1);
        continue;
      }
      // Where no material has a picture, each is a slot of its own.
      const std::string picture = map ? map->picture : "";
      const auto id = ids.try_emplace(any ? picture : name, int(file.textures.size()));
      if (id.second)
        file.textures.push_back({picture, map ? map->wrap : Wrap::unspecified, {}, {}});
      if (m) file.textures[id.first->second].places.push_back(map ? map->place : m->end);
      texture_from_material.push_back(id.first->second);
    }
    add_others(slot, file.others);
    set_companions(file.slots, file.textures.size(),
                   companions(slot, texture_from_material, file.others));
    return texture_from_material;
  }

 private:
  /// Pictures of all other slots, each file once.
  void add_others(const std::string& slot, std::vector<TextureSlot>& others) const {
    std::map<std::string, std::size_t> ids;
    for (const std::string& name : file_.materials) {
      const MtlMaterial* m = find(name);
      for (std::size_t i = 0; m && i < m->maps.size(); ++i) {
        const MaterialMap& map = m->maps[i];
        if (map.slot == slot) continue;
        const auto id = ids.try_emplace(map.picture, others.size());
        if (id.second) others.push_back({map.picture, map.wrap, {}, {}});
        others[id.first->second].places.push_back(map.place);
      }
    }
  }

  /// What the materials with textures have beside them that is looked up at the same places.
  std::vector<MaterialCompanions> companions(const std::string& slot,
                                             const std::vector<int>& texture_from_material,
                                             const std::vector<TextureSlot>& others) const {
    std::vector<MaterialCompanions> materials;
    for (std::size_t i = 0; i < file_.materials.size(); ++i) {
      const MtlMaterial* m = find(file_.materials[i]);
      const MaterialMap* own = m ? m->map(slot) : nullptr;
      if (texture_from_material[i] < 0 || !own) continue;
      MaterialCompanions& material = materials.emplace_back();
      material.texture = texture_from_material[i];
      for (const MaterialMap& map : m->maps) {
        if (map.slot == slot || map.scale != own->scale || map.offset != own->offset) continue;
        const auto other = std::ranges::find(others, map.picture, &TextureSlot::name);
        material.pictures[map.slot] = int(other - others.begin());
      }
    }
    return materials;
  }

  const ObjFile& file_;
  std::unordered_map<std::string, MtlMaterial> materials_;
  std::vector<MaterialSlot> slots_;
};

/// Moves the texture coordinates of materials with -s or -o; a coordinate that several materials
/// use is given once more for each.
void apply_map_options(MeshFile& file, const ObjFile& obj, const MaterialLookup& lookup) {
  std::map<std::pair<int, int>, int> moved;
  for (int t = 0; t < file.mesh.triangle_count() && file.mesh.has_uvs(); ++t) {
    const int id = obj.mesh.textures.empty() ? -1 : obj.mesh.textures[t];
    const MtlMaterial* material = id < 0 ? nullptr : lookup.find(obj.materials[id]);
    const MaterialMap* map = material ? material->map(file.slot) : nullptr;
    if (!map || (map->scale == Vector2(1, 1) && map->offset == Vector2(0, 0))) continue;
    for (int& uv : file.mesh.corner_uvs[t]) {
      if (uv < 0) continue;
      const auto place = moved.try_emplace({id, uv}, int(file.mesh.uvs.size()));
      if (place.second)
        file.mesh.uvs.push_back(file.mesh.uvs[uv].cwiseProduct(map->scale) + map->offset);
      uv = place.first->second;
    }
  }
  if (!moved.empty())
    file.notes.push_back(std::string("options -s and -o of ") + mtl_keyword(file.slot) +
                         " are applied to the texture coordinates");
}

}  // namespace

MeshFile read_obj(const Document& document) {
  ObjFile obj = parse_obj(document.bytes, document.name);
  const MaterialLookup lookup(obj, document);
  MeshFile file{obj.mesh, std::move(obj.colors), {}, std::move(obj.notes), std::move(obj.defects)};
  require_uv_set(document.choice.uv_set, file.mesh.has_uvs(), document.name);
  file.slots = lookup.slots();
  file.slot = chosen_slot(file.slots, document.choice.slot, document.name);
  const std::vector<int> texture_from_material = lookup.textures(file.slot, file);
  for (int& texture : file.mesh.textures)
    texture = texture < 0 ? -1 : texture_from_material[texture];
  apply_map_options(file, obj, lookup);
  return file;
}

}  // namespace mq

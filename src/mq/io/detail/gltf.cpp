// A vertex of the mesh is an element of a POSITION accessor seen through a node,
//   p = M x, M the product of the node's and its ancestors' transforms;
// where det M < 0 corners change their order, so that the outside stays outside. A texture
// coordinate (u, v) becomes T (u, v) by KHR_texture_transform and then (u, 1 − v): glTF counts v
// from the top row. This is the only place that turns it.
#include "mq/io/detail/gltf.h"

#include <Eigen/Geometry>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <climits>
#include <cmath>
#include <map>
#include <set>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/io/detail/gltf_joints.h"
#include "mq/io/detail/gltf_material.h"
#include "mq/io/detail/gltf_scene.h"
#include "mq/io/slots.h"
#include "mq/mesh/check.h"

namespace mq {
namespace {

struct MaterialTexture {
  int texture = -1;  ///< slot
  int set = 0;       ///< TEXCOORD_set
  UvTransform transform = no_uv_transform;
};

class SceneReader {
 public:
  SceneReader(const GltfFile& file, const ReadChoice& choice) : file_(file), choice_(choice) {}

  GltfScene read() {
    refuse_required_extensions();
    choose();
    std::vector<Visit> stack = roots();
    std::reverse(stack.begin(), stack.end());
    std::vector<char> seen(file_.size("nodes"), 0);
    while (!stack.empty()) {
      const Visit visit = stack.back();
      stack.pop_back();
      read_node(visit, seen, stack);
    }
    finish();
    return std::move(scene_);
  }

  GltfScene read_only(std::int64_t mesh, const Eigen::Matrix4d& matrix) {
    refuse_required_extensions();
    choose();
    moves_ = true;
    read_mesh(mesh, matrix);
    finish();
    return std::move(scene_);
  }

 private:
  /// A node and the transform of its ancestors.
  struct Visit {
    std::int64_t node;
    Eigen::Matrix4d matrix;
  };

  Mesh& mesh() { return scene_.file.mesh; }
  void note(const std::string& text) {
    if (noted_.insert(text).second) scene_.file.notes.push_back(text);
  }
  static std::int64_t index(const Json& value) {
    return value.is_number_integer() ? value.get<std::int64_t>() : -1;
  }

  void refuse_required_extensions() const {
    constexpr const char* known[] = {"KHR_texture_transform",      "KHR_mesh_quantization",
                                     "KHR_draco_mesh_compression", "EXT_meshopt_compression",
                                     "KHR_meshopt_compression",    "EXT_texture_webp",
                                     "KHR_texture_basisu",         "KHR_node_visibility",
                                     "KHR_animation_pointer"};
    for (const Json& name : json_array(file_.json(), "extensionsRequired", file_.name())) {
      if (!name.is_string()) continue;
      const std::string text = name.get<std::string>();
      const bool is_known = std::find(std::begin(known), std::end(known), text) != std::end(known);
      if (!is_known && !text.starts_with("KHR_materials_") && !text.starts_with("KHR_lights_"))
        file_.fail(file_.name() + ", extensionsRequired",
                   shown(text) + " is not known; write it without");
    }
  }

  /// Finds out which slot is read, and with which texture coordinates.
  void choose() {
    uses_ = uses_of_materials(file_);
    scene_.file.slots = uses_.slots;
    scene_.file.slot = chosen_slot(uses_.slots, choice_.slot, file_.name());
    require_uv_set(choice_.uv_set, uses_.uv_sets, file_.name());
    if (uses_.uv_sets > 1) scene_.file.uv_sets.resize(std::size_t(uses_.uv_sets));
    set_begins_.resize(scene_.file.uv_sets.size());
  }

  std::vector<Visit> roots() {
    std::vector<Visit> visits;
    if (file_.size("scenes") > 0) {
      const std::int64_t number = json_count(file_.json(), "scene", 0, file_.name());
      const Json& scene = file_.item("scenes", number);
      for (const Json& node : json_array(scene, "nodes", file_.place("scenes", number)))
        visits.push_back({index(node), Eigen::Matrix4d::Identity()});
      if (file_.size("scenes") > 1)
        note(fmt::format("scene {} of {} is read", number, file_.size("scenes")));
      return visits;
    }
    std::set<std::int64_t> children;
    for (std::size_t n = 0; n < file_.size("nodes"); ++n)
      for (const Json& child :
           json_array(file_.item("nodes", std::int64_t(n)), "children", file_.name()))
        children.insert(index(child));
    for (std::size_t n = 0; n < file_.size("nodes"); ++n)
      if (!children.contains(std::int64_t(n)))
        visits.push_back({std::int64_t(n), Eigen::Matrix4d::Identity()});
    return visits;
  }

  void read_node(const Visit& visit, std::vector<char>& seen, std::vector<Visit>& stack) {
    const std::string place = file_.place("nodes", visit.node);
    const Json& node = file_.item("nodes", visit.node);
    if (seen[std::size_t(visit.node)]++) file_.fail(place, "it has two parents, or is its own");
    if (const Json* extensions = json_object(node, "extensions"))
      if (extensions->contains("EXT_mesh_gpu_instancing"))
        throw Unsupported(place +
                          " is drawn many times by EXT_mesh_gpu_instancing; write it "
                          "without instances first");
    if (gltf_node_is_hidden(node)) {
      note("nodes that are hidden (KHR_node_visibility), and what lies in them, are left out");
      return;
    }
    const Eigen::Matrix4d matrix = visit.matrix * gltf_node_matrix(node, place);
    const Json& children = json_array(node, "children", place);
    for (std::size_t c = children.size(); c-- > 0;) stack.push_back({index(children[c]), matrix});
    if (!node.contains("mesh")) return;
    const bool skinned = node.contains("skin");
    if (skinned) note("skinned meshes are in their bind pose");
    if (file_.size("animations") > 0) note("animations are not used");
    if (!skinned && matrix.topLeftCorner<3, 3>().isZero(0)) {
      note("meshes that are scaled to a point, so that nothing of them is seen, are left out");
      return;
    }
    read_mesh(json_count(node, "mesh", 0, place), skinned ? Eigen::Matrix4d::Identity() : matrix);
  }

  void read_mesh(std::int64_t id, const Eigen::Matrix4d& matrix) {
    const Json& object = file_.item("meshes", id);
    blocks_.clear();
    const Json& primitives = json_array(object, "primitives", file_.place("meshes", id));
    for (std::size_t p = 0; p < primitives.size(); ++p) {
      place_ = fmt::format("{}.primitives[{}]", file_.place("meshes", id), p);
      if (!primitives[p].is_object()) file_.fail(place_, "it is not an object");
      read_primitive(primitives[p], matrix);
    }
  }

  void read_primitive(const Json& stored, const Eigen::Matrix4d& matrix) {
    const std::int64_t stored_mode = json_count(stored, "mode", 4, place_);
    if (stored_mode < 4 || stored_mode > 6) {
      note("points and lines are not used");
      return;
    }
    if (!moves_ && !json_array(stored, "targets", place_).empty()) note("morph targets are not used");
    const Json primitive = file_.decompressed(stored, place_);
    const std::int64_t mode = json_count(primitive, "mode", 4, place_);
    const Json* attributes = json_object(primitive, "attributes");
    if (!attributes || !attributes->contains("POSITION")) file_.fail(place_, "it has no POSITION");

    const GltfBlock block = vertices(*attributes, matrix);
    const std::vector<Triangle> corners = triangles(primitive, mode, block.count);
    const bool mirrored = matrix.topLeftCorner<3, 3>().determinant() < 0;
    const std::int64_t material_id = json_count(primitive, "material", -1, place_);
    const MaterialTexture& material = material_of(material_id);
    scene_.triangles.push_back({mesh().triangles.size(), block.begin, block.count,
                                json_count(*attributes, "NORMAL", -1, place_),
                                keeps_directions(material.transform)
                                    ? json_count(*attributes, "TANGENT", -1, place_)
                                    : -1,
                                material_id, matrix});
    const int uv_begin = uvs(*attributes, material.set, material.transform, block.count,
                             mesh().uvs, uv_begins_);
    if (material.texture >= 0 && uv_begin < 0 && !corners.empty())
      note(fmt::format("{} has no texture coordinates TEXCOORD_{}, by which its material places its picture, and is "
                       "taken without",
                       place_, material.set));
    if (mesh().triangles.size() + corners.size() > std::size_t(INT_MAX / 4))
      file_.fail(place_, "the scene has more than 536870911 triangles");
    std::vector<int> set_begins;
    for (std::size_t set = 0; set < scene_.file.uv_sets.size(); ++set)
      set_begins.push_back(uvs(*attributes, int(set), no_uv_transform, block.count,
                               scene_.file.uv_sets[set].uvs, set_begins_[set]));
    const auto corners_from = [](int begin, const Triangle& t) {
      return begin < 0 ? Triangle{-1, -1, -1} : Triangle{begin + t[0], begin + t[1], begin + t[2]};
    };
    for (Triangle t : corners) {
      if (mirrored) std::swap(t[1], t[2]);
      mesh().triangles.push_back({block.begin + t[0], block.begin + t[1], block.begin + t[2]});
      mesh().textures.push_back(material.texture);
      mesh().corner_uvs.push_back(corners_from(uv_begin, t));
      for (std::size_t set = 0; set < set_begins.size(); ++set)
        scene_.file.uv_sets[set].corner_uvs.push_back(corners_from(set_begins[set], t));
    }
  }

  /// Appends the vertices of a primitive, unless another primitive of this node has done so.
  GltfBlock vertices(const Json& attributes, const Eigen::Matrix4d& matrix) {
    GltfBlock block;
    block.matrix = matrix;
    block.positions = json_count(attributes, "POSITION", -1, place_);
    block.colors = json_count(attributes, "COLOR_0", -1, place_);
    const auto known = blocks_.find({block.positions, block.colors});
    if (known != blocks_.end()) return known->second;

    const GltfValues p = file_.values(block.positions, {3});
    block.begin = mesh().vertex_count();
    block.count = int(std::min<std::size_t>(p.count(), INT_MAX));
    if (p.count() + mesh().positions.size() > std::size_t(INT_MAX / 4))
      file_.fail(place_, "the scene has more than 536870911 vertices");
    for (int i = 0; i < block.count; ++i) {
      const double* x = p.values.data() + 3 * std::size_t(i);
      const Vector3 world = (matrix * Eigen::Vector4d(x[0], x[1], x[2], 1)).head<3>();
      if (!world.allFinite())
        file_.fail(place_,
                   fmt::format("vertex {} at {}, {}, {} must be finite", i, x[0], x[1], x[2]));
      if (world.cwiseAbs().maxCoeff() > largest_coordinate)
        file_.fail(place_, fmt::format("vertex {} lies at {}, {}, {}; at most {:.0e} can be used: "
                                       "scale the model down",
                                       i, world.x(), world.y(), world.z(), largest_coordinate));
      mesh().positions.push_back(world);
    }
    read_colors(block);
    scene_.blocks.push_back(block);
    return blocks_[{block.positions, block.colors}] = block;
  }

  /// Colours are gathered as four channels; white where a primitive has none.
  void read_colors(const GltfBlock& block) {
    if (block.colors < 0) {
      colors_.resize(4 * mesh().positions.size(), 1);
      return;
    }
    const GltfValues c = file_.values(block.colors, {3, 4});
    if (int(c.count()) != block.count)
      file_.fail(place_, fmt::format("{} colours for {} vertices", c.count(), block.count));
    channels_ = std::max(channels_, c.components);
    if (c.type == GltfType::f32) depth_ = Depth::f32;
    if (c.type == GltfType::u16 && depth_ == Depth::u8) depth_ = Depth::u16;
    for (int i = 0; i < block.count; ++i)
      for (int k = 0; k < 4; ++k)
        colors_.push_back(k < c.components ? float(c.values[std::size_t(i * c.components + k)])
                                           : 1.0f);
  }

  std::vector<Triangle> triangles(const Json& primitive, std::int64_t mode, int vertices) const {
    std::vector<int> corners;
    if (primitive.contains("indices")) {
      const GltfValues values = file_.values(json_count(primitive, "indices", 0, place_), {1});
      corners.reserve(values.count());
      for (const double v : values.values) {
        if (!(v >= 0 && v < vertices) || v != std::floor(v))
          file_.fail(place_,
                     fmt::format("index {} is out of range: it has {} vertices", v, vertices));
        corners.push_back(int(v));
      }
    } else {
      for (int i = 0; i < vertices; ++i) corners.push_back(i);
    }
    std::vector<Triangle> result;
    const int n = int(corners.size());
    if (mode == 4 && n % 3 != 0)
      file_.fail(place_, fmt::format("{} corners do not make triangles of three each", n));
    for (int i = 0; mode == 4 && i < n; i += 3)
      result.push_back({corners[i], corners[i + 1], corners[i + 2]});
    for (int i = 0; mode == 5 && i + 2 < n; ++i)
      result.push_back({corners[i], corners[i + 1 + i % 2], corners[i + 2 - i % 2]});
    for (int i = 1; mode == 6 && i + 1 < n; ++i)
      result.push_back({corners[i], corners[i + 1], corners[0]});
    return result;
  }

  /// Where the texture coordinates of an accessor, seen through a transform, begin in a pool.
  using UvBegins = std::map<std::pair<std::int64_t, UvTransform>, int>;

  /// The first entry of `pool` for the texture coordinates of a primitive; −1 without.
  int uvs(const Json& attributes, int set, const UvTransform& m, int vertices,
          std::vector<Vector2>& pool, UvBegins& begins) {
    const std::string key = fmt::format("TEXCOORD_{}", set);
    if (!attributes.contains(key)) return -1;
    const std::int64_t accessor = json_count(attributes, key.c_str(), 0, place_);
    const auto known = begins.find({accessor, m});
    if (known != begins.end()) return known->second;
    const GltfValues values = file_.values(accessor, {2});
    if (int(values.count()) != vertices)
      file_.fail(place_,
                 fmt::format("{} texture coordinates for {} vertices", values.count(), vertices));
    const int begin = int(pool.size());
    for (std::size_t i = 0; i < values.count(); ++i) {
      const double u = values.values[2 * i], v = values.values[2 * i + 1];
      pool.emplace_back(m[0] * u + m[1] * v + m[2], 1 - (m[3] * u + m[4] * v + m[5]));
    }
    return begins[{accessor, m}] = begin;
  }

  const MaterialTexture& material_of(std::int64_t id) {
    const auto known = materials_.find(id);
    if (known != materials_.end()) return known->second;
    MaterialTexture result;
    if (id >= 0)
      for (const GltfMap& map : material_maps(file_, id))
        if (map.slot == scene_.file.slot) result = {texture_of(map), map.set, map.transform};
    if (choice_.uv_set >= 0 && choice_.uv_set != result.set)
      result = {result.texture, choice_.uv_set, no_uv_transform};  // the transform is of its set
    if (result.texture >= 0 && result.set >= std::max(1, uses_.uv_sets))
      note(fmt::format("{} names UV set {} for its picture, and the file has {}",
                       file_.place("materials", id), result.set, uses_.uv_sets));
    return materials_[id] = result;
  }

  int texture_of(const GltfMap& map) {
    const auto slot = slots_.try_emplace(map.image, int(scene_.images.size()));
    if (slot.second) {
      scene_.images.push_back(map.image);
      scene_.file.textures.push_back(image_slot(file_, map.image));
      if (map.sampler >= 0) scene_.file.textures.back().wrap = wrap_of(map.sampler);
    }
    return slot.first->second;
  }

  /// A picture that other programs show in place of one: it is kept as it is.
  void add_beside(const GltfMap& map) {
    if (map.beside < 0 || slots_.contains(map.beside)) return;
    const TextureSlot other = image_slot(file_, map.beside);
    if (map.slot == scene_.file.slot)
      note(fmt::format("{} has a stand-in for other programs, {}, which stays as it is: they will show the old "
                       "picture",
                       shown(image_slot(file_, map.image).name), shown(other.name)));
    if (std::ranges::count(scene_.other_images, map.beside) > 0) return;
    scene_.other_images.push_back(map.beside);
    scene_.file.others.push_back(other);
  }

  /// Pictures of the other slots; one that is a texture too changes with it.
  void gather_others() {
    for (const std::int64_t material : uses_.materials)
      for (const GltfMap& map : material_maps(file_, material)) {
        add_beside(map);
        if (map.slot == scene_.file.slot) continue;
        const auto texture = slots_.find(map.image);
        if (texture != slots_.end()) {
          note(fmt::format("the picture {} is that of two slots, {} and {}: both change",
                           shown(scene_.file.textures[std::size_t(texture->second)].name),
                           scene_.file.slot, map.slot));
        } else if (std::ranges::count(scene_.other_images, map.image) == 0) {
          scene_.other_images.push_back(map.image);
          scene_.file.others.push_back(image_slot(file_, map.image));
        }
      }
  }

  /// What the materials with textures have beside them that is looked up at the same places.
  void gather_companions() {
    std::vector<MaterialCompanions> materials;
    for (const auto& [id, own] : materials_) {
      if (own.texture < 0) continue;
      MaterialCompanions& material = materials.emplace_back();
      material.texture = own.texture;
      for (const GltfMap& map : material_maps(file_, id)) {
        if (map.slot == scene_.file.slot || map.set != own.set || map.transform != own.transform)
          continue;
        const auto texture = slots_.find(map.image);
        const auto other = std::ranges::find(scene_.other_images, map.image);
        if (other != scene_.other_images.end())
          material.pictures[map.slot] = int(other - scene_.other_images.begin());
        else if (texture != slots_.end() && texture->second == own.texture)
          material.pictures[map.slot] = MaterialSlot::the_texture;
      }
    }
    set_companions(scene_.file.slots, scene_.file.textures.size(), materials);
  }

  Wrap wrap_of(std::int64_t id) {
    const Json& sampler = file_.item("samplers", id);
    const std::string place = file_.place("samplers", id);
    const std::int64_t s = json_count(sampler, "wrapS", 0, place);
    const std::int64_t t = json_count(sampler, "wrapT", 0, place);
    if (s == 33648 || t == 33648) note("textures that repeat mirrored are repeated as they are");
    if (s == 33071 && t == 33071) return Wrap::clamp;
    return s == 0 && t == 0 ? Wrap::unspecified : Wrap::repeat;
  }

  void note_compression() {
    for (const auto& [used, name] : {std::pair(file_.used_draco(), "Draco (KHR_draco_mesh_compression)"),
                                     std::pair(file_.used_meshopt(), "meshopt (EXT_meshopt_compression)")})
      if (used && !moves_)
        note(fmt::format("compressed by {}; in this format it stays as it is where pictures alone change, "
                         "and is written plain where the mesh does",
                         name));
    if (const GltfJoints joints = join_grids(scene_, file_); joints.moved > 0)
      note(fmt::format("Draco rounded each primitive by itself: {} where two meet lay up to {:.2g} apart and "
                       "are joined",
                       counted(joints.moved, "vertex"), joints.farthest));
  }

  void finish() {
    MeshFile& file = scene_.file;
    gather_others();
    gather_companions();
    note_compression();
    if (file.mesh.uvs.empty()) file.mesh.corner_uvs.clear();
    if (channels_ > 0) {
      file.colors = {channels_, {}, depth_, true};
      for (std::size_t i = 0; i < colors_.size(); ++i)
        if (int(i % 4) < channels_) file.colors.values.push_back(colors_[i]);
      for (const GltfBlock& block : scene_.blocks)
        if (block.colors < 0) note("vertices without colours are white");
    }
    if (file.textures.empty()) file.mesh.textures.clear();
    if (file.mesh.triangles.empty()) note("it has no faces");
  }

  const GltfFile& file_;
  const ReadChoice choice_;
  GltfUses uses_;
  GltfScene scene_;
  std::string place_;                                                  ///< of the primitive at hand
  std::map<std::pair<std::int64_t, std::int64_t>, GltfBlock> blocks_;  ///< of the node at hand
  UvBegins uv_begins_;
  std::vector<UvBegins> set_begins_;  ///< of each of the file's sets
  std::map<std::int64_t, MaterialTexture> materials_;
  std::map<std::int64_t, int> slots_;
  std::vector<float> colors_;
  int channels_ = 0;
  Depth depth_ = Depth::u8;
  std::set<std::string> noted_;
  bool moves_ = false;  ///< who reads it heeds morph targets, and writes another file
};

}  // namespace

Eigen::Matrix4d gltf_node_matrix(const Json& node, const std::string& place) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  if (node.contains("matrix")) {
    const auto m = json_numbers(node, "matrix", std::vector<double>(16), place);
    for (int i = 0; i < 16; ++i) matrix(i % 4, i / 4) = m[std::size_t(i)];
    return matrix;
  }
  const auto t = json_numbers(node, "translation", {0, 0, 0}, place);
  const auto r = json_numbers(node, "rotation", {0, 0, 0, 1}, place);
  const auto s = json_numbers(node, "scale", {1, 1, 1}, place);
  Eigen::Quaterniond turn(r[3], r[0], r[1], r[2]);
  if (turn.norm() > 0) turn.normalize();
  matrix.topLeftCorner<3, 3>() = turn.toRotationMatrix() * Vector3(s[0], s[1], s[2]).asDiagonal();
  matrix.topRightCorner<3, 1>() = Vector3(t[0], t[1], t[2]);
  return matrix;
}

bool gltf_node_is_hidden(const Json& node) {
  const Json* extensions = json_object(node, "extensions");
  const Json* visibility = extensions ? json_object(*extensions, "KHR_node_visibility") : nullptr;
  return visibility && visibility->contains("visible") && (*visibility)["visible"] == Json(false);
}

GltfScene read_gltf_scene(const GltfFile& file, const ReadChoice& choice) {
  return SceneReader(file, choice).read();
}

GltfScene read_gltf_mesh(const GltfFile& file, std::int64_t mesh, const Eigen::Matrix4d& matrix) {
  return SceneReader(file, {}).read_only(mesh, matrix);
}

MeshFile read_gltf(const Document& document) {
  return read_gltf_scene(GltfFile(document), document.choice).file;
}

}  // namespace mq

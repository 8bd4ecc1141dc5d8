// Made anew, a corner is a vertex; equal corners of a texture, normal and tangent too, are one.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <compare>
#include <limits>
#include <map>

#include "mq/base/error.h"
#include "mq/io/detail/gltf_compress.h"
#include "mq/io/detail/gltf_container.h"
#include "mq/io/detail/gltf_material.h"
#include "mq/io/detail/gltf_scene.h"
#include "mq/io/file_names.h"
#include "mq/io/materials.h"
#include "mq/io/normals.h"
#include "mq/io/slots.h"
#include "mq/io/uri.h"

namespace mq {
namespace {

using OrderedJson = nlohmann::ordered_json;

class NewGltf {
 public:
  NewGltf(const Model& model, Document::Format format, const std::vector<GltfPicture>& pictures,
          const std::string& stem)
      : model_(model),
        mesh_(model.mesh),
        format_(format),
        pictures_(pictures),
        stem_(stem),
        channels_(color_channels(model.colors)),
        other_sets_(other_uv_sets(model)),
        own_set_(std::clamp(own_uv_set(model), 0, int(other_sets_.size()))),
        frames_(frames_to_write(model, a_name)),
        said_(file_materials(model)),
        materials_(new_materials(model, said_)) {}

  GltfOutput output() {
    json_["asset"] = {{"version", "2.0"}, {"generator", "Marquetry"}};
    json_["scene"] = 0;
    json_["scenes"] = OrderedJson::array({{{"nodes", OrderedJson::array()}}});
    add_primitives();
    add_materials();
    if (!buffer_.empty()) {
      OrderedJson buffer = {{"byteLength", buffer_.size()}};
      if (format_ == Document::Format::gltf) buffer["uri"] = uri_of_name(stem_ + ".bin");
      json_["buffers"].push_back(buffer);
    }
    const Bytes text = to_bytes(json_.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
    if (format_ == Document::Format::glb) {
      output_.files = {{stem_, glb_bytes(text, buffer_, {})}};
    } else {
      output_.files = {{stem_, text}};
      if (!buffer_.empty()) output_.files.push_back({stem_ + ".bin", std::move(buffer_)});
    }
    output_.made_anew = true;
    return std::move(output_);
  }

 private:
  /// Triangles of a material, those with texture coordinates apart.
  struct Group {
    NewMaterial material;
    bool textured;
    std::vector<int> triangles;
  };

  std::vector<Group> groups() const {
    std::vector<Group> groups;
    std::map<std::pair<NewMaterial, bool>, std::size_t> ids;
    for (int t = 0; t < mesh_.triangle_count(); ++t) {
      const NewMaterial material = material_of(model_, said_, t);
      const bool textured = mesh_.textured(t);
      const auto id = ids.try_emplace({material, textured}, groups.size());
      if (id.second) groups.push_back({material, textured, {}});
      groups[id.first->second].triangles.push_back(t);
    }
    return groups;
  }

  void add_primitives() {
    OrderedJson primitives = OrderedJson::array();
    const std::vector<Group> all = groups();
    // Where another format says nothing of materials its triangles are matt; in glTF no material is metal.
    constexpr NewMaterial none;
    if (!names_gltf(model_.path) && std::ranges::count(all, none, &Group::material) > 0) materials_.push_back(none);
    for (const Group& group : all) primitives.push_back(primitive(group));
    if (primitives.empty()) return;
    json_["scenes"][0]["nodes"].push_back(0);
    json_["nodes"] = OrderedJson::array({{{"mesh", 0}}});
    json_["meshes"] = OrderedJson::array({{{"primitives", primitives}}});
  }

  /// What makes a corner a vertex of its own: vertex, u, v, normal, tangent, and what it has in the
  /// other sets.
  struct Corner {
    std::array<double, 3> own;
    std::array<float, 7> frame;  ///< 0 where there is none
    std::vector<int> others;
    auto operator<=>(const Corner&) const = default;
  };

  std::array<float, 7> frame_at(int t, int k, bool with_tangent) const {
    std::array<float, 7> frame{};
    const std::size_t corner = 3 * std::size_t(t) + std::size_t(k);
    if (!frames_.normals.empty()) Eigen::Vector3f::Map(frame.data()) = frames_.normals[corner];
    if (with_tangent) Eigen::Vector4f::Map(frame.data() + 3) = frames_.tangents[corner];
    return frame;
  }

  OrderedJson primitive(const Group& group) {
    std::map<Corner, std::uint32_t> ids;
    std::vector<int> vertices;
    std::vector<Vector2> uvs;
    std::vector<std::vector<Vector2>> other_uvs(other_sets_.size());
    const bool with_tangents =
        group.textured && group.material.texture >= 0 &&
        has_normal_map(model_, group.material.texture, a_name);
    Bytes indices, normals, tangents;
    for (const int t : group.triangles)
      for (int k = 0; k < 3; ++k) {
        const int vertex = mesh_.triangles[std::size_t(t)][std::size_t(k)];
        const Vector2 uv = group.textured ? mesh_.uv(t, k) : Vector2(0, 0);
        Corner corner{{double(vertex), uv.x(), uv.y()}, frame_at(t, k, with_tangents), {}};
        for (const UvSet* set : other_sets_)
          corner.others.push_back(set->corner_uvs[std::size_t(t)][std::size_t(k)]);
        const auto id = ids.try_emplace(corner, std::uint32_t(vertices.size()));
        if (id.second) {
          vertices.push_back(vertex);
          uvs.push_back(uv);
          for (std::size_t i = 0; i < 7; ++i)
            append_raw(i < 3 ? normals : tangents, corner.frame[i]);
          for (std::size_t i = 0; i < other_sets_.size(); ++i)
            other_uvs[i].push_back(corner.others[i] < 0
                                       ? Vector2(0, 0)
                                       : other_sets_[i]->uvs[std::size_t(corner.others[i])]);
        }
        append_raw(indices, id.first->second);
      }
    OrderedJson attributes;
    attributes["POSITION"] = add_positions(vertices);
    const std::size_t count = vertices.size();
    if (!frames_.normals.empty())
      attributes["NORMAL"] = add_accessor(normals, 12, count, GltfType::f32, "VEC3", 34962);
    if (with_tangents)
      attributes["TANGENT"] = add_accessor(tangents, 16, count, GltfType::f32, "VEC4", 34962);
    const auto set_name = [](int set) { return fmt::format("TEXCOORD_{}", set); };
    if (group.textured) attributes[set_name(own_set_)] = add_uvs(uvs);
    for (std::size_t i = 0; i < other_sets_.size() && group.textured; ++i)
      attributes[set_name(int(i) + (int(i) >= own_set_))] = add_uvs(other_uvs[i]);
    if (channels_ > 0) attributes["COLOR_0"] = add_colors(vertices);
    OrderedJson result = {{"attributes", attributes}};
    result["indices"] =
        add_accessor(indices, 0, 3 * group.triangles.size(), GltfType::u32, "SCALAR", 34963);
    const auto place = std::ranges::find(materials_, group.material);
    if (place != materials_.end()) result["material"] = place - materials_.begin();
    return result;
  }

  std::size_t add_view(ByteView bytes, std::size_t stride, int target) {
    pad_to_four(buffer_, '\0');
    OrderedJson view = {
        {"buffer", 0}, {"byteOffset", buffer_.size()}, {"byteLength", bytes.size()}};
    if (stride > 0) view["byteStride"] = stride;
    if (target > 0) view["target"] = target;
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
    json_["bufferViews"].push_back(view);
    return json_["bufferViews"].size() - 1;
  }

  std::size_t add_accessor(const Bytes& bytes, std::size_t stride, std::size_t count, GltfType type,
                           const char* shape, int target) {
    const std::size_t view = add_view(bytes, stride, target);
    json_["accessors"].push_back(
        {{"bufferView", view}, {"componentType", int(type)}, {"count", count}, {"type", shape}});
    return json_["accessors"].size() - 1;
  }

  std::size_t add_positions(const std::vector<int>& vertices) {
    Bytes bytes;
    Eigen::Vector3f least = Eigen::Vector3f::Constant(std::numeric_limits<float>::max());
    Eigen::Vector3f largest = -least;
    for (const int v : vertices) {
      const Eigen::Vector3f x = mesh_.positions[std::size_t(v)].cast<float>();
      if (!x.allFinite())
        throw Unsupported(
            fmt::format("vertex {} is too far away for the floats of glTF; write "
                        ".ply or .obj",
                        v));
      for (int k = 0; k < 3; ++k) append_raw(bytes, x[k]);
      least = least.cwiseMin(x);
      largest = largest.cwiseMax(x);
    }
    const std::size_t id = add_accessor(bytes, 12, vertices.size(), GltfType::f32, "VEC3", 34962);
    json_["accessors"][id]["min"] = {least.x(), least.y(), least.z()};
    json_["accessors"][id]["max"] = {largest.x(), largest.y(), largest.z()};
    return id;
  }

  std::size_t add_uvs(const std::vector<Vector2>& uvs) {
    Bytes bytes;
    for (const Vector2& uv : uvs) {
      append_raw(bytes, float(uv.x()));
      append_raw(bytes, float(1 - uv.y()));
    }
    return add_accessor(bytes, 8, uvs.size(), GltfType::f32, "VEC2", 34962);
  }

  std::size_t add_colors(const std::vector<int>& vertices) {
    const Depth depth = model_.colors.depth;
    const GltfType type = depth == Depth::u8    ? GltfType::u8
                          : depth == Depth::u16 ? GltfType::u16
                                                : GltfType::f32;
    Bytes bytes;
    for (const int v : vertices) {
      for (int c = 0; c < channels_; ++c) {
        const float value = color(model_.colors, v, c);
        if (type == GltfType::u8) append_raw(bytes, std::uint8_t(stored_color(value, 255)));
        if (type == GltfType::u16) append_raw(bytes, std::uint16_t(stored_color(value, 65535)));
        if (type == GltfType::f32) append_raw(bytes, value);
      }
      pad_to_four(bytes, '\0');
    }
    const std::size_t id =
        add_accessor(bytes, vertices.empty() ? 4 : bytes.size() / vertices.size(), vertices.size(),
                     type, channels_ == 3 ? "VEC3" : "VEC4", 34962);
    if (type != GltfType::f32) json_["accessors"][id]["normalized"] = true;
    return id;
  }

  void add_materials() {
    output_.embedded.assign(pictures_.size(), true);
    for (const NewMaterial& one : materials_) {
      OrderedJson added = material(one);
      json_["materials"].push_back(std::move(added));
    }
  }

  std::size_t image(int number) {
    const auto known = images_.try_emplace(number, json_["images"].size());
    if (!known.second) return known.first->second;
    const GltfPicture& picture = pictures_[std::size_t(number)];
    const Bytes bytes = format_ == Document::Format::glb ? picture.file() : Bytes();
    output_.embedded[std::size_t(number)] = !bytes.empty();
    if (bytes.empty()) {
      json_["images"].push_back({{"uri", uri_of_name(picture.name)}});
    } else {
      const std::size_t view = add_view(bytes, 0, 0);
      json_["images"].push_back(
          {{"bufferView", view}, {"mimeType", picture.type}, {"name", picture.name}});
    }
    return known.first->second;
  }

  std::size_t texture(int picture, Wrap wrap) {
    const auto known = textures_.try_emplace({picture, wrap}, json_["textures"].size());
    if (!known.second) return known.first->second;
    const std::size_t source = image(picture);
    OrderedJson texture = {{"source", source}};
    if (pictures_[std::size_t(picture)].type == "image/webp") {
      texture = {{"extensions", {{"EXT_texture_webp", {{"source", source}}}}}};
      use("EXT_texture_webp");
      json_["extensionsRequired"] = {"EXT_texture_webp"};
    }
    if (wrap != Wrap::unspecified) {
      const int mode = wrap == Wrap::clamp ? 33071 : 10497;
      json_["samplers"].push_back({{"wrapS", mode}, {"wrapT", mode}});
      texture["sampler"] = json_["samplers"].size() - 1;
    }
    json_["textures"].push_back(texture);
    return known.first->second;
  }

  OrderedJson material(const NewMaterial& one) {
    OrderedJson result = one.texture < 0 ? OrderedJson::object() : pictures(one.texture);
    Material said;
    if (one.material >= 0)
      said = said_.materials[std::size_t(one.material)];
    if (result.contains("emissiveTexture") && one.material < 0) said.emissive = {1, 1, 1};
    add_material_words(said, result);
    if (result.contains("extensions"))
      for (const auto& [name, extension] : result["extensions"].items()) use(name);
    return result;
  }

  /// The members of a material that name pictures.
  OrderedJson pictures(int number) {
    OrderedJson metallic = OrderedJson::object(), result = OrderedJson::object();
    for (const SlotPicture& one : material_pictures(model_, number, a_name)) {
      const char* keyword = gltf_keyword(one.slot);
      if (!keyword)
        throw Unsupported("a glTF file made anew has no pictures for " + one.slot +
                          ": write the pictures alone, or to the format that was read");
      OrderedJson info = {
          {"index", texture(one.picture, model_.textures[std::size_t(number)].wrap)}};
      if (own_set_ > 0) info["texCoord"] = own_set_;
      const bool is_metallic = one.slot == "metallic-roughness" || one.slot == base_slot;
      (is_metallic ? metallic : result)[keyword] = info;
    }
    result["pbrMetallicRoughness"] = metallic;
    return result;
  }

  void use(const std::string& extension) {
    OrderedJson& used = json_["extensionsUsed"];
    if (std::find(used.begin(), used.end(), extension) == used.end()) used.push_back(extension);
  }

  static constexpr const char* a_name = "new.gltf";

  const Model& model_;
  const Mesh& mesh_;
  Document::Format format_;
  const std::vector<GltfPicture>& pictures_;
  const std::string& stem_;
  int channels_;
  std::vector<const UvSet*> other_sets_;
  int own_set_;  ///< the number of the mesh's set among all
  CornerFrames frames_;
  ModelMaterials said_;
  std::vector<NewMaterial> materials_;
  std::map<int, std::size_t> images_;  ///< of the file, by the model's pictures
  std::map<std::pair<int, Wrap>, std::size_t> textures_;
  OrderedJson json_;
  Bytes buffer_;
  GltfOutput output_;
};

Document document_of(Document::Format format, const std::string& name, const std::vector<OutputFile>& files) {
  Document document;
  document.format = format;
  document.name = name;
  document.bytes = files[0].bytes;
  document.parts.assign(files.begin() + 1, files.end());
  return document;
}

std::vector<OutputFile> files_of(Document document) {
  std::vector<OutputFile> files{{document.name, std::move(document.bytes)}};
  for (Part& part : document.parts) files.push_back(std::move(part));
  return files;
}

/// Pictures into a GLB, where their files are known; out of a glTF, to lie beside it.
void move_pictures(Json& json, Document::Format format, const std::vector<GltfPicture>& pictures,
                   GltfPacker& packer, GltfOutput& output) {
  for (const auto& [id, number] : output.images) {
    Json& image = json["images"][std::size_t(id)];
    const GltfPicture& picture = pictures[number];
    const bool is_inside = image.contains("bufferView") || json_text_of(image, "uri").starts_with("data:");
    if (format == Document::Format::glb && !is_inside) {
      Bytes file = picture.file();
      if (file.empty()) continue;
      image.erase("uri");
      image["bufferView"] = packer.add_view(std::move(file));
      image["mimeType"] = picture.type;
      image["name"] = picture.name;
      output.embedded[number] = true;
    } else if (format == Document::Format::gltf && is_inside) {
      image.erase("bufferView");
      image.erase("mimeType");
      image["uri"] = uri_of_name(picture.name);
      output.embedded[number] = false;
    }
  }
}

/// Spliced into the other container; no files where that cannot be.
GltfOutput splice_into_other(const Model& model, Document::Format format,
                             const std::vector<GltfPicture>& pictures, const std::string& stem) {
  Document moved;
  {
    const GltfFile file(*model.document);
    if (!GltfPacker::can_pack(file)) return {};
    moved = GltfPacker(file).packed(format, stem);
    moved.choice = model.document->choice;
  }
  GltfOutput output = splice_gltf(model, moved, pictures, stem);
  if (output.files.empty()) return output;
  const Document spliced = document_of(format, stem, output.files);
  const GltfFile file(spliced);
  GltfPacker packer(file);
  move_pictures(packer.json(), format, pictures, packer, output);
  output.files = files_of(packer.packed(format, stem));
  return output;
}

void compress(GltfOutput& output, Document::Format format, Compression compression, const std::string& stem) {
  const Document plain = document_of(format, stem, output.files);
  const GltfFile file(plain);
  if (!GltfPacker::can_pack(file)) {
    output.notes.push_back(stem + ": not compressed, as extensions name parts of its buffers in ways "
                                  "that are not known here");
    return;
  }
  GltfPacker packer(file);
  const std::vector<std::string> notes = compress_gltf(file, packer, compression);
  output.notes.insert(output.notes.end(), notes.begin(), notes.end());
  output.files = files_of(packer.packed(format, stem));
}

}  // namespace

GltfOutput write_gltf(const Model& model, Document::Format format,
                      const std::vector<GltfPicture>& pictures, const std::string& stem) {
  const Document* document = model.document.get();
  GltfOutput output;
  if (document && document->is_gltf())
    output = document->format == format ? splice_gltf(model, *document, pictures, stem)
                                        : splice_into_other(model, format, pictures, stem);
  if (output.files.empty()) {
    output = NewGltf(model, format, pictures, stem).output();
    if (document && document->is_gltf())
      output.notes.push_back(stem + ": made anew, without the nodes, cameras, animations and extras of what was read");
    if (model.compression == Compression::none && document && is_compressed_gltf(*document))
      output.notes.push_back(stem + ": the mesh is made anew and not compressed, as what was read is");
  }
  if (model.compression != Compression::none) compress(output, format, model.compression, stem);
  return output;
}

}  // namespace mq

#include "mq/io/normals.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "mq/io/bytes.h"
#include "mq/io/detail/gltf_scene.h"
#include "mq/io/detail/obj.h"
#include "mq/io/detail/ply.h"
#include "mq/io/document.h"
#include "mq/io/materials.h"
#include "mq/io/slots.h"

namespace mq {
namespace {

bool obj_says_normals(std::string_view text) {
  for (Scanner scanner(text); !scanner.at_end(); scanner.next_line())
    if (scanner.word() == "vn") return true;
  return false;
}

bool ply_says_normals(const Document& document) {
  for (const PlyElement& element : parse_ply_header(document.bytes, document.name).elements)
    if (element.name == "vertex")
      for (const PlyProperty& property : element.properties)
        if (property.name == "nx" || property.name == "normal_x") return true;
  return false;
}

/// A file's frames, and the mesh that they are of.
struct FileFrames {
  Mesh mesh;
  CornerFrames frames;
};

FileFrames obj_frames(const Document& document) {
  ObjFile file = parse_obj(document.bytes, document.name, ObjNormals::read);
  FileFrames result{std::move(file.mesh), {}};
  if (file.normals.empty()) return result;
  for (const Triangle& corners : file.corner_normals)
    for (const int normal : corners)
      result.frames.normals.push_back(normal < 0
                                          ? Eigen::Vector3f(Eigen::Vector3f::Zero())
                                          : file.normals[std::size_t(normal)].cast<float>());
  return result;
}

FileFrames ply_frames(const Document& document) {
  PlyFile file = parse_ply(document, PlyNormals::read);
  FileFrames result{std::move(file.file.mesh), {}};
  if (file.normals.empty()) return result;
  for (const Triangle& corners : result.mesh.triangles)
    for (const int vertex : corners)
      result.frames.normals.push_back(file.normals[std::size_t(vertex)].cast<float>());
  return result;
}

FileFrames frames_of(const Document& document, int uv_set) {
  if (document.format == Document::Format::obj) return obj_frames(document);
  if (document.format == Document::Format::ply) return ply_frames(document);
  const GltfFile file(document);
  GltfScene scene = read_gltf_scene(file, document.choice);
  CornerFrames frames =
      gltf_frames(file, scene, uv_set < 0 ? GltfTangents::read : GltfTangents::skip);
  return {std::move(scene.file.mesh), std::move(frames)};
}

}  // namespace

CornerFrames file_frames(const Model& model) {
  if (!model.document) {
    const std::size_t count = 3 * model.mesh.triangles.size();
    const bool fits = model.shading && model.shading->corners.normals.size() == count;
    return fits ? model.shading->corners : CornerFrames{};
  }
  if (!model.document->is_gltf() && !holds_normals(model)) return {};
  FileFrames found = frames_of(*model.document, model.uv_set);
  const bool same = found.mesh.triangles == model.mesh.triangles &&
                    found.mesh.positions == model.mesh.positions;
  return same ? std::move(found.frames) : CornerFrames{};
}

bool holds_normals(const Model& model) {
  if (!model.document) return model.shading && model.shading->is_said;
  switch (model.document->format) {
    case Document::Format::obj: return obj_says_normals(text_of(model.document->bytes));
    case Document::Format::ply: return ply_says_normals(*model.document);
    default: return text_of(model.document->bytes).find("\"NORMAL\"") != std::string_view::npos;
  }
}

void forget_file(Model& model, Tangents tangents) {
  ModelShading shading{file_frames(model), holds_normals(model)};
  ModelMaterials materials = file_materials(model);
  if (tangents == Tangents::forgotten) shading.corners.tangents.clear();
  model.document.reset();
  model.shading.reset();
  model.materials.reset();
  if (!materials.materials.empty())
    model.materials = std::make_shared<const ModelMaterials>(std::move(materials));
  if (!shading.corners.normals.empty())
    model.shading = std::make_shared<const ModelShading>(std::move(shading));
}

bool has_normal_map(const Model& model, int texture, const std::filesystem::path& path) {
  return std::ranges::any_of(material_pictures(model, texture, path), [](const SlotPicture& one) {
    return meaning_of_slot(one.slot) == TextureMeaning::normals;
  });
}

CornerFrames frames_to_write(const Model& model, const std::filesystem::path& path) {
  bool has_map = false;
  for (int t = 0; t < std::ssize(model.textures) && !has_map; ++t)
    has_map = has_normal_map(model, t, path);
  if (!has_map && !holds_normals(model)) return {};
  CornerFrames frames = file_frames(model);
  if (has_map) return tangent_frames(model.mesh, std::move(frames));
  if (frames.normals.empty()) return {};
  return {frame_normals(model.mesh, std::move(frames.normals)), {}};
}

}  // namespace mq

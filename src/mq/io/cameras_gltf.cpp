// Perspective cameras of glTF 2.0, as Blender writes them: each node with a camera is one, looking along
// its −z with y up, at rest (animations and skins are left out); its picture is called as the node, its
// parent or the camera are. The picture's size is its own; a camera without aspectRatio has that of the
// picture.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "mq/base/error.h"
#include "mq/io/detail/camera_entries.h"
#include "mq/io/detail/gltf_file.h"
#include "mq/io/detail/gltf_scene.h"

namespace mq {
namespace {

namespace fs = std::filesystem;

/// Nodes and whose children they are.
class NodeTree {
 public:
  explicit NodeTree(const GltfFile& file) : file_(file), parents_(file.size("nodes"), -1) {
    for (std::size_t n = 0; n < parents_.size(); ++n) {
      const std::string place = file.place("nodes", std::int64_t(n));
      for (const Json& child : json_array(file.item("nodes", std::int64_t(n)), "children", place)) {
        const std::int64_t c = child.is_number_integer() ? child.get<std::int64_t>() : -1;
        file.item("nodes", c);  // refused where it is not there
        if (parents_[std::size_t(c)] >= 0)
          file.fail(file.place("nodes", c), "it has two parents, or is its own");
        parents_[std::size_t(c)] = std::int64_t(n);
      }
    }
  }

  std::int64_t parent(std::int64_t node) const { return parents_[std::size_t(node)]; }
  std::string name(std::int64_t node) const {
    return node < 0 ? "" : json_text_of(file_.item("nodes", node), "name");
  }

  Eigen::Matrix4d matrix(std::int64_t node) const {
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
    std::size_t steps = 0;
    for (std::int64_t n = node; n >= 0; n = parent(n)) {
      if (++steps > parents_.size())
        file_.fail(file_.place("nodes", node), "it is among its own ancestors");
      matrix = gltf_node_matrix(file_.item("nodes", n), file_.place("nodes", n)) * matrix;
    }
    return matrix;
  }

 private:
  const GltfFile& file_;
  std::vector<std::int64_t> parents_;
};

/// Focal lengths and the principal point for a picture of the camera's size.
void set_perspective(PinholeCamera& camera, double yfov, double aspect, const std::string& where) {
  const double y = camera.height / (2 * std::tan(yfov / 2)), shape = double(camera.width) / camera.height;
  if (aspect > 0 && std::abs(aspect - shape) * camera.height > 1 + 1e-3 * camera.width)
    throw IoError(fmt::format("{}: its aspect ratio is {:.4g}, and its picture {} × {}: wanted one that is "
                              "rendered by this camera, uncropped",
                              where, aspect, camera.width, camera.height));
  camera.fx = aspect > 0 ? y * shape / aspect : y;
  camera.fy = y;
  camera.cx = camera.width / 2.0, camera.cy = camera.height / 2.0;
}

Document gltf_document(const fs::path& path) {
  Document document;
  document.name = path.string();
  document.bytes = read_file(path);
  document.format = text_of(document.bytes).starts_with("glTF") ? Document::Format::glb
                                                                 : Document::Format::gltf;
  return document;
}

}  // namespace

CameraEntries read_gltf_cameras(const fs::path& path) {
  const Document document = gltf_document(path);
  const GltfFile file(document);
  const NodeTree tree(file);
  CameraEntries entries{"glTF", path.parent_path(), {}, 0, {}, {path}};
  int orthographic = 0;
  for (std::size_t k = 0; k < file.size("nodes"); ++k) {
    const std::int64_t n = std::int64_t(k);
    const Json& node = file.item("nodes", n);
    if (!node.contains("camera")) continue;
    const std::string where = file.place("nodes", n);
    const std::int64_t id = json_count(node, "camera", 0, where);
    const Json& camera = file.item("cameras", id);
    const Json* const perspective = json_object(camera, "perspective");
    if (perspective == nullptr) {
      ++orthographic;
      continue;
    }
    const std::string place = file.place("cameras", id);
    const double yfov = json_number(*perspective, "yfov", 0, place),
                 aspect = json_number(*perspective, "aspectRatio", 0, place);
    if (!(yfov > 0 && yfov < std::numbers::pi && aspect >= 0))
      file.fail(place, fmt::format("found a yfov of {} and an aspectRatio of {}, wanted an angle above 0 "
                                   "and below π, and more than 0",
                                   yfov, aspect));
    CameraEntry entry{tree.name(n), {}, where};
    entry.other_names = {tree.name(tree.parent(n)), json_text_of(camera, "name")};
    place_camera(entry.camera, tree.matrix(n), CameraAxes::backward_z, where);
    entry.complete = [=](PinholeCamera& c) { set_perspective(c, yfov, aspect, where); };
    entries.cameras.push_back(std::move(entry));
  }
  if (orthographic > 0)
    entries.notes.push_back(
        fmt::format("{}: {} of its cameras are orthographic: left aside", path.string(), orthographic));
  return entries;
}

}  // namespace mq

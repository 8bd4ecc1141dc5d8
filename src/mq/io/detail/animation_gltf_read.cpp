// A frame is a key of an animation: of weights w, which move a mesh's vertices by
//   x = x₀ + Σ w_k Δ_k,
// or of a scale that steps between 0 and 1 or a visibility (KHR_node_visibility), which show it or hide it. glTF splits
// vertices where texture coordinates differ; those that are in one place in x₀ and all Δ are one here.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <tuple>
#include <utility>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/io/detail/animation_found.h"
#include "mq/io/detail/gltf_keys.h"
#include "mq/io/detail/gltf_material.h"
#include "mq/io/detail/gltf_scene.h"
#include "mq/io/document.h"
#include "mq/io/path_status.h"
#include "mq/io/slots.h"

namespace mq {
namespace {

constexpr int most_node_levels = 256;

/// A node with a mesh, and what its animation says.
struct MovingMesh {
  std::int64_t node = 0, mesh = 0;
  Eigen::Matrix4d matrix;
  std::vector<const GltfKeys*> presences;  ///< of it and what it lies in
  const GltfKeys* weights = nullptr;
  std::string moved = {};  ///< "rotation of FILE, nodes[3]": what else moves it
  bool is_hidden = false;  ///< at all times

  bool moves() const { return weights || !presences.empty(); }
  bool shown(double time) const {
    return std::ranges::all_of(
        presences, [&](const GltfKeys* keys) { return keys->values[keys->before(time) * keys->size] != 0; });
  }
};

/// A mesh as a segment shows it.
struct GltfShape {
  struct Block {
    std::size_t begin = 0, count = 0;
    std::vector<std::int64_t> targets;  ///< accessors; −1: none
  };
  std::vector<Vector3> positions;  ///< x₀, as glTF splits them
  std::vector<std::size_t> kept;   ///< which of them is a vertex
  std::vector<Block> blocks;
  Eigen::Matrix3d matrix;  ///< that Δ are seen through
};

/// The file, and all that frames are read from later.
struct MovingScene {
  Document document;
  std::unique_ptr<GltfFile> file;
  std::map<std::int64_t, GltfKeys> presences, visibilities, weights;  ///< of nodes
  std::vector<MovingMesh> meshes;
  std::vector<GltfShape> shapes;                ///< of segments
  std::vector<std::vector<double>> weights_of;  ///< of frames

  std::vector<double> delta(const GltfShape::Block& block, std::size_t target) const {
    if (target >= block.targets.size() || block.targets[target] < 0) return {};
    std::vector<double> values = file->values(block.targets[target], {3}).values;
    if (values.size() != 3 * block.count)
      file->fail(file->place("accessors", block.targets[target]),
                 fmt::format("{} positions of a morph target for {} vertices", values.size() / 3, block.count));
    return values;
  }

  std::vector<Vector3> positions(int segment, std::size_t frame) const {
    const GltfShape& shape = shapes.at(std::size_t(segment));
    std::vector<Vector3> moved = shape.positions;
    for (const GltfShape::Block& block : shape.blocks)
      for (std::size_t k = 0; k < weights_of[frame].size(); ++k) {
        const double weight = weights_of[frame][k];
        if (weight == 0) continue;
        const std::vector<double> values = delta(block, k);
        for (std::size_t i = 0; i < values.size() / 3; ++i)
          moved[block.begin + i] += weight * (shape.matrix * Vector3::Map(&values[3 * i]));
      }
    std::vector<Vector3> result;
    result.reserve(shape.kept.size());
    for (const std::size_t i : shape.kept) result.push_back(moved[i]);
    return result;
  }
};

class GltfFinder {
 public:
  explicit GltfFinder(std::shared_ptr<MovingScene> scene) : scene_(std::move(scene)), file_(*scene_->file) {}

  FoundAnimation find() {
    read_channels();
    walk();
    if (cameras_ > 0) found_.add_remark(counted(cameras_, "camera") + " in it: left out");
    choose_frames();
    found_.positions = [scene = scene_, segment_of = found_.segment_of](int frame) {
      return scene->positions(segment_of.at(std::size_t(frame)), std::size_t(frame));
    };
    return std::move(found_);
  }

 private:
  [[noreturn]] void refuse(const std::string& what) const { throw Unsupported(file_.name() + ": " + what); }

  // ---- What moves ----

  void read_channels() {
    const std::size_t count = file_.size("animations");
    if (count > 1)
      found_.add_note(
          fmt::format("it has {} animations, of which the first is read (animations[0]): join them for more", count));
    if (count == 0) return;
    const Json& animation = file_.item("animations", 0);
    const std::string place = file_.place("animations", 0);
    const Json& channels = json_array(animation, "channels", place);
    for (std::size_t c = 0; c < channels.size(); ++c)
      read_channel(animation, channels[c], fmt::format("{}.channels[{}]", place, c));
  }

  void read_channel(const Json& animation, const Json& channel, const std::string& place) {
    const Json* target = channel.is_object() ? json_object(channel, "target") : nullptr;
    if (!target) file_.fail(place, "it has no target");
    const auto [node, path] = animated(*target, place);
    if (node < 0) return;
    const Json& of = file_.item("nodes", node);
    if (const auto [first, is_new] = channel_of_.try_emplace({node, path}, place); !is_new)
      file_.fail(place,
                 fmt::format("it animates the {} of nodes[{}], as {} does; wanted one channel for each: take one "
                             "out, or write the file again",
                             shown(path), node, first->second));
    if (path == "visible") {
      scene_->visibilities[node] = gltf_keys(file_, animation, channel, place, 1);
    } else if (path == "weights") {
      if (of.contains("mesh")) scene_->weights[node] = gltf_keys(file_, animation, channel, place, 0);
    } else if (path == "scale" || path == "translation" || path == "rotation") {
      GltfKeys found = gltf_keys(file_, animation, channel, place, path == "rotation" ? 4 : 3);
      const bool is_switch = path == "scale" && found.steps &&
                             std::ranges::all_of(found.values, [](double v) { return v == 0 || v == 1; });
      if (is_switch)
        scene_->presences[node] = std::move(found);
      else if (!stays(of, path, found, place))
        moved_[node] = path;
    } else {
      found_.add_note(fmt::format("an animation of {} is not read", path.empty() ? "nothing" : shown(path)));
    }
  }

  /// The node and which of its properties a channel animates, by names or by a pointer; −1: nothing that is read.
  std::pair<std::int64_t, std::string> animated(const Json& target, const std::string& place) {
    const std::string path = json_text_of(target, "path");
    if (path != "pointer") return {json_count(target, "node", -1, place), path};
    const Json* extensions = json_object(target, "extensions");
    const Json* extension = extensions ? json_object(*extensions, "KHR_animation_pointer") : nullptr;
    const std::string pointer = extension ? json_text_of(*extension, "pointer") : "";
    static constexpr std::string_view nodes = "/nodes/";
    std::int64_t node = -1;
    if (pointer.starts_with(nodes)) {
      const char* end = pointer.data() + pointer.size();
      const std::string of = std::from_chars(pointer.data() + nodes.size(), end, node).ptr;
      for (const char* read : {"/weights", "/scale", "/translation", "/rotation"})
        if (of == read) return {node, of.substr(1)};
      if (of == "/extensions/KHR_node_visibility/visible") return {node, "visible"};
    }
    found_.add_note(fmt::format("an animation of {} (KHR_animation_pointer) is not read", shown(pointer)));
    return {-1, ""};
  }

  /// Whether keys only say what the node says anyway.
  static bool stays(const Json& node, const std::string& path, const GltfKeys& keys, const std::string& place) {
    std::vector<double> own =
        path == "rotation" ? std::vector<double>{0, 0, 0, 1} : std::vector<double>(3, path == "scale" ? 1 : 0);
    own = json_numbers(node, path.c_str(), own, place);
    for (std::size_t i = 0; i < keys.values.size(); ++i)
      if (std::abs(keys.values[i] - own[i % own.size()]) > 1e-6 * std::max(1.0, std::abs(own[i % own.size()])))
        return false;
    return true;
  }

  // ---- What there is ----

  struct Visit {
    std::int64_t node;
    MovingMesh above;
    int level;
  };

  void walk() {
    std::vector<char> seen(file_.size("nodes"), 0);
    std::vector<Visit> stack;
    const std::int64_t number = json_count(file_.json(), "scene", 0, file_.name());
    const Json& roots = json_array(file_.item("scenes", number), "nodes", file_.place("scenes", number));
    push(roots, {}, 0, stack);
    while (!stack.empty()) {
      const Visit visit = stack.back();
      stack.pop_back();
      const Json& node = file_.item("nodes", visit.node);
      const std::string place = file_.place("nodes", visit.node);
      if (seen[std::size_t(visit.node)]++) file_.fail(place, "it has two parents, or is its own");
      if (visit.level > most_node_levels)
        file_.fail(place, fmt::format("it lies more than {} nodes deep", most_node_levels));
      MovingMesh here = visit.above;
      here.node = visit.node;
      Json still = node;
      if (const auto found = scene_->presences.find(visit.node); found != scene_->presences.end()) {
        here.presences.push_back(&found->second);
        still.erase("scale");
      }
      if (const auto found = scene_->visibilities.find(visit.node); found != scene_->visibilities.end())
        here.presences.push_back(&found->second);
      else
        here.is_hidden = here.is_hidden || gltf_node_is_hidden(node);
      here.matrix =
          (visit.level == 0 ? Eigen::Matrix4d::Identity() : visit.above.matrix) * gltf_node_matrix(still, place);
      if (const auto moved = moved_.find(visit.node); moved != moved_.end())
        here.moved = fmt::format("{} of nodes[{}]", moved->second, visit.node);
      if (node.contains("mesh")) add_mesh(here, node, place);
      cameras_ += node.contains("camera");
      push(json_array(node, "children", place), here, visit.level + 1, stack);
    }
  }

  static void push(const Json& nodes, const MovingMesh& above, int level, std::vector<Visit>& stack) {
    for (std::size_t n = nodes.size(); n-- > 0;)
      stack.push_back({nodes[n].is_number_integer() ? nodes[n].get<std::int64_t>() : -1, above, level});
  }

  void add_mesh(MovingMesh mesh, const Json& node, const std::string& place) {
    if (mesh.matrix.topLeftCorner<3, 3>().isZero(0)) return;  // nothing of it is seen
    if (mesh.is_hidden) {
      found_.add_remark(fmt::format("nodes[{}] is hidden (KHR_node_visibility), and is left out", mesh.node));
      return;
    }
    if (node.contains("skin"))
      refuse(fmt::format("found a mesh that bones move (nodes[{}]), wanted morph targets: bake it into these, or {}",
                         mesh.node, frames_instead));
    mesh.mesh = json_count(node, "mesh", 0, place);
    if (const auto found = scene_->weights.find(mesh.node); found != scene_->weights.end())
      mesh.weights = &found->second;
    scene_->meshes.push_back(std::move(mesh));
  }

  // ---- What is shown, and when ----

  void choose_frames() {
    const std::size_t moving = std::size_t(std::ranges::count_if(scene_->meshes, &MovingMesh::moves));
    for (const MovingMesh& mesh : scene_->meshes)
      if (!mesh.moved.empty() && (mesh.moves() || moving == 0))
        refuse(fmt::format(
            "found an animation of the {}, wanted morph targets alone: bake what moves it into these, or {}",
            mesh.moved, frames_instead));
    if (scene_->meshes.empty() || (moving == 0 && scene_->meshes.size() > 1))
      refuse(fmt::format(
          "found {}, wanted one whose morph targets an animation shows: bake what moves it into these, or {}",
          scene_->meshes.empty() ? "no mesh"
                                 : counted(std::ssize(scene_->meshes), "mesh") + ", none of which moves",
          frames_instead));
    if (moving > 0 && moving < scene_->meshes.size())
      found_.add_note(fmt::format("{} whose vertices do not move, beside what moves, are left out",
                                  counted(std::int64_t(scene_->meshes.size() - moving), "mesh")));
    if (moving == 0) found_.add_note("nothing in it moves: it is a film of one frame");
    std::map<double, const MovingMesh*> shown_at;
    std::set<double> unseen;
    if (moving == 0) shown_at[0] = &scene_->meshes[0];
    for (const MovingMesh& mesh : scene_->meshes) {
      std::vector<const GltfKeys*> all = mesh.presences;
      if (mesh.weights) all.push_back(mesh.weights);
      for (const GltfKeys* keys : all)
        for (const double time : keys->times)
          if (!mesh.shown(time))
            unseen.insert(time);
          else if (shown_at.try_emplace(time, &mesh).first->second != &mesh)
            refuse_two(mesh, *shown_at[time], time);
    }
    std::vector<double> times;
    const MovingMesh* last = nullptr;
    for (const auto& [time, shown] : shown_at) {
      for (const MovingMesh& mesh : scene_->meshes)
        if (mesh.moves() && &mesh != shown && mesh.shown(time)) refuse_two(mesh, *shown, time);
      if (shown != last) add_segment(*shown);
      last = shown;
      found_.segment_of.push_back(int(found_.segments.size()) - 1);
      scene_->weights_of.push_back(weights(*shown, time));
      times.push_back(time);
      unseen.erase(time);
    }
    if (times.empty())
      refuse("none of its meshes is ever seen, as their scale is 0; make one visible, and write the file again");
    if (!unseen.empty())
      found_.add_note(
          unseen_frames(unseen.size(), times.size() + unseen.size(), "second", *unseen.begin(), *unseen.rbegin()));
    set_times(times);
  }

  [[noreturn]] void refuse_two(const MovingMesh& a, const MovingMesh& b, double time) const {
    refuse(fmt::format(
        "nodes[{}] and nodes[{}] are both seen at {} s, and one mesh at a time is wanted: join them, or {}", b.node,
        a.node, time, frames_instead));
  }

  /// At a key, or as the file says for all times.
  std::vector<double> weights(const MovingMesh& mesh, double time) const {
    if (mesh.weights) return mesh.weights->at(time);
    for (const auto& [array, id] : {std::pair("nodes", mesh.node), std::pair("meshes", mesh.mesh)}) {
      const Json& object = file_.item(array, id);
      const std::size_t count = json_array(object, "weights", file_.place(array, id)).size();
      if (count > 0) return json_numbers(object, "weights", std::vector<double>(count), file_.place(array, id));
    }
    return {};
  }

  void set_times(const std::vector<double>& times) {
    double gap = 1;
    for (std::size_t i = 1; i < times.size(); ++i)
      gap = std::min(i == 1 ? times[1] - times[0] : gap, times[i] - times[i - 1]);
    double rate = 1 / gap, first = 0;
    if (std::abs(rate - std::round(rate)) < 1e-3 * rate && rate >= 1) rate = std::round(rate);
    const Json* asset = json_object(file_.json(), "asset");
    if (const Json* extras = asset ? json_object(*asset, "extras") : nullptr;
        extras && extras->contains("first_frame") && extras->contains("frames_per_second")) {
      const std::string place = file_.name() + ", asset.extras";
      first = double(json_count(*extras, "first_frame", 0, place));
      rate = json_number(*extras, "frames_per_second", rate, place);
      if (!(rate > 0)) file_.fail(place, fmt::format("found {} frames a second, wanted more than 0", rate));
    }
    set_frame_times(found_, {.times = times, .step = 1 / rate, .first = first, .word = "keys"});
  }

  // ---- Segments ----

  void add_segment(const MovingMesh& mesh) {
    GltfScene read = read_gltf_mesh(file_, mesh.mesh, mesh.matrix);
    GltfShape shape;
    shape.positions = read.file.mesh.positions;
    shape.matrix = mesh.matrix.topLeftCorner<3, 3>();
    add_targets(mesh.mesh, read, shape);
    scene_->shapes.push_back(std::move(shape));
    const std::vector<int> vertex_of = weld(scene_->shapes.back());
    for (Triangle& t : read.file.mesh.triangles)
      for (int& corner : t) corner = vertex_of[std::size_t(corner)];
    read.file.mesh.positions.resize(scene_->shapes.back().kept.size());
    found_.segments.push_back(segment_of(read.file.mesh));
    add_picture(read.file);
    say_factors(read);
    for (const std::string& note : read.file.notes) found_.add_note(note);
  }

  /// Which accessors move which vertices: primitives with triangles come in the order of the scene's.
  void add_targets(std::int64_t mesh, const GltfScene& read, GltfShape& shape) const {
    const std::string place = file_.place("meshes", mesh);
    std::size_t part = 0;
    std::map<std::size_t, std::size_t> known;
    for (const Json& primitive : json_array(file_.item("meshes", mesh), "primitives", place)) {
      const std::int64_t mode = json_count(primitive, "mode", 4, place);
      if (mode < 4 || mode > 6) continue;
      const GltfTriangles& triangles = read.triangles.at(part++);
      GltfShape::Block block{std::size_t(triangles.vertices), std::size_t(triangles.vertex_count), {}};
      for (const Json& target : json_array(primitive, "targets", place))
        block.targets.push_back(target.is_object() ? json_count(target, "POSITION", -1, place) : -1);
      const auto [entry, is_new] = known.try_emplace(block.begin, shape.blocks.size());
      if (is_new)
        shape.blocks.push_back(std::move(block));
      else if (shape.blocks[entry->second].targets != block.targets)
        refuse(place + " has parts that share vertices and not how these move");
    }
  }

  /// Joins vertices that are in one place throughout; the vertex of each.
  std::vector<int> weld(GltfShape& shape) const {
    std::vector<std::uint64_t> paths(shape.positions.size(), 0);
    const auto mix = [](std::uint64_t& path, double number) {
      path = (path ^ std::bit_cast<std::uint64_t>(number + 0.0)) * 0x9e3779b97f4a7c15;
      path ^= path >> 29;
    };
    for (const GltfShape::Block& block : shape.blocks)
      for (std::size_t target = 0; target < block.targets.size(); ++target) {
        const std::vector<double> values = scene_->delta(block, target);
        for (std::size_t i = 0; i < values.size(); ++i) mix(paths[block.begin + i / 3], values[i]);
      }
    std::map<std::tuple<double, double, double, std::uint64_t>, int> known;
    std::vector<int> vertex_of;
    for (std::size_t i = 0; i < shape.positions.size(); ++i) {
      const Vector3& p = shape.positions[i];
      const auto [place, is_new] = known.try_emplace({p.x(), p.y(), p.z(), paths[i]}, int(shape.kept.size()));
      if (is_new) shape.kept.push_back(i);
      vertex_of.push_back(place->second);
    }
    return vertex_of;
  }

  /// What materials do to the picture that is shown.
  void say_factors(const GltfScene& read) {
    if (found_.pictures.back().name.empty()) return;
    for (const GltfTriangles& part : read.triangles) {
      if (part.material < 0) continue;
      const auto factor = gltf_material(file_, part.material).base_colour;
      if (factor != Material().base_colour)
        found_.add_note(
            fmt::format("materials[{}] multiplies its picture by {:g}, {:g}, {:g}, {:g} (baseColorFactor); the picture "
                        "is taken as it is: bake that into it",
                        part.material, factor[0], factor[1], factor[2], factor[3]));
    }
  }

  void add_picture(const MeshFile& read) {
    FoundPicture picture;
    if (!read.textures.empty() && read.slot != base_slot)
      found_.add_note(fmt::format("a mesh has no picture of its colours, but of others ({}), which is not shown",
                                  read.slot));
    else if (read.textures.size() == 1)
      picture = {read.textures[0].name, read.textures[0].picture};
    else if (read.textures.size() > 1)
      found_.add_note(fmt::format("a mesh has {}, wanted one, and is shown without: bake them into one",
                                  counted(std::ssize(read.textures), "picture")));
    found_.pictures.push_back(std::move(picture));
  }

  std::shared_ptr<MovingScene> scene_;
  const GltfFile& file_;
  FoundAnimation found_;
  std::int64_t cameras_ = 0;
  std::map<std::pair<std::int64_t, std::string>, std::string> channel_of_;  ///< its place, by node and path
  std::map<std::int64_t, std::string> moved_;  ///< nodes that are turned, shifted or scaled, and which of these
};

}  // namespace

FoundAnimation find_gltf_animation(const std::string& name, Bytes bytes, const std::filesystem::path& folder) {
  auto scene = std::make_shared<MovingScene>();
  scene->document.name = name;
  scene->document.format = text_of(bytes).starts_with("glTF") ? Document::Format::glb : Document::Format::gltf;
  scene->document.bytes = std::move(bytes);
  std::vector<std::filesystem::path> files;
  for (const std::string& part : gltf_parts(scene->document))
    if (is_there(folder / portable_name(part))) {
      files.push_back(folder / portable_name(part));
      scene->document.parts.push_back({part, read_file(files.back())});
    }
  scene->file = std::make_unique<GltfFile>(scene->document);
  FoundAnimation found = GltfFinder(scene).find();
  found.files = std::move(files);
  return found;
}

}  // namespace mq

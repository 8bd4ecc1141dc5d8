// Schemas as animation_usd.cpp has them. What is shown at a time code: meshes that neither are invisible nor lie
// in what is. A value before the first time sample is that of the first.
#include <Eigen/LU>

#include <fmt/format.h>

#include <algorithm>
#include <climits>
#include <cmath>
#include <map>
#include <memory>
#include <set>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/io/detail/animation_found.h"
#include "mq/io/detail/polygon.h"
#include "mq/io/detail/stored_zip.h"
#include "mq/io/detail/usd_matrix.h"
#include "mq/io/document.h"
#include "mq/io/file_names.h"

namespace mq {
namespace {

constexpr double default_usd_rate = 24;

/// A mesh, where it stands, and what may hide it.
struct UsdMesh {
  const UsdPrim* prim;
  std::string path;
  Eigen::Matrix4d matrix;
  std::vector<const UsdProperty*> visibilities;
  const UsdProperty* points = nullptr;
  std::string_view material;  ///< bound to it or what it lies in

  bool moves() const { return points && !points->samples.empty(); }
};

/// The bytes of a file, what they say, and the meshes in it.
struct UsdScene {
  UsdScene(const std::string& name, Bytes bytes_, std::size_t begin, std::size_t size)
      : bytes(std::move(bytes_)), text(name, text_of(bytes).substr(begin, size)) {}

  Bytes bytes;
  UsdText text;
  std::vector<UsdMesh> meshes;
  std::vector<const UsdMesh*> mesh_of_frame;
  std::vector<std::string_view> points_of_frame;
};

bool is_hidden(const UsdMesh& mesh, double time) {
  return std::ranges::any_of(mesh.visibilities, [&](const UsdProperty* property) {
    const auto& samples = property->samples;
    if (samples.empty()) return usd_unquoted(property->value) == "invisible";
    auto next = std::ranges::upper_bound(samples, time, {}, &UsdSample::time);
    if (next != samples.begin()) --next;
    return usd_unquoted(next->value) == "invisible";
  });
}

class UsdFinder {
 public:
  UsdFinder(std::shared_ptr<UsdScene> scene) : scene_(std::move(scene)), text_(scene_->text) {}

  FoundAnimation find() {
    const UsdPrim& layer = text_.layer();
    Eigen::Matrix4d up = Eigen::Matrix4d::Identity();
    if (usd_unquoted(text_.member(layer.metadata, "upAxis")) == "Z")
      up.topLeftCorner<3, 3>() << 1, 0, 0, 0, 0, 1, 0, -1, 0;
    collect(layer, {nullptr, "", up, {}, nullptr, {}}, up);
    choose_frames();
    const UsdMesh* last = nullptr;
    for (const UsdMesh* mesh : scene_->mesh_of_frame) {
      if (mesh != last) add_segment(*mesh, scene_->points_of_frame[found_.segment_of.size()]);
      found_.segment_of.push_back(int(found_.segments.size()) - 1);
      last = mesh;
    }
    found_.positions = [scene = scene_](int frame) {
      const UsdMesh& mesh = *scene->mesh_of_frame.at(std::size_t(frame));
      return points(*scene, mesh, scene->points_of_frame[std::size_t(frame)]);
    };
    return std::move(found_);
  }

 private:
  /// Of a prim and what lies in it, `above` as far as it is inherited.
  void collect(const UsdPrim& prim, const UsdMesh& above, const Eigen::Matrix4d& world) {
    for (const UsdPrim& child : prim.children) {
      if (child.specifier != "def" || text_.member(child.metadata, "active") == "false" ||
          text_.member(child.metadata, "active") == "0")
        continue;
      for (const char* arc : {"references", "payload", "inherits", "specializes"})
        refers_ = refers_ || !text_.member(child.metadata, arc).empty();
      UsdMesh mesh = above;
      mesh.prim = &child;
      mesh.path += fmt::format("/{}", child.name);
      if (const UsdProperty* hides = child.property("visibility")) mesh.visibilities.push_back(hides);
      if (const UsdProperty* bound = child.property("material:binding")) mesh.material = usd_unquoted(bound->value);
      if (child.property("xformOpOrder")) {
        const UsdTransform own = usd_transform(text_, child);
        mesh.matrix = (own.resets ? world : above.matrix) * own.matrix;
      }
      if (child.type == "Mesh" && (mesh.points = child.property("points"))) scene_->meshes.push_back(mesh);
      kinds_.insert(std::string(child.type));
      collect(child, mesh, world);
    }
  }

  /// What is shown, and when.
  void choose_frames() {
    std::map<double, std::pair<const UsdMesh*, std::string_view>> shown_at;
    std::size_t moving = 0;
    for (const UsdMesh& mesh : scene_->meshes) moving += mesh.moves();
    if (scene_->meshes.empty() || (moving == 0 && (scene_->meshes.size() > 1 || has_skeleton()))) refuse_still();
    note_what_is_left_out(moving);
    if (moving > 0 && moving < scene_->meshes.size())
      found_.notes.push_back(fmt::format("{} that stand still beside what moves are left out",
                                         counted(std::int64_t(scene_->meshes.size() - moving), "mesh")));
    for (const UsdMesh& mesh : scene_->meshes) {
      if (moving == 0) shown_at[0] = {&mesh, mesh.points->value};
      for (const UsdSample& sample : mesh.points->samples) {
        if (is_hidden(mesh, sample.time)) continue;
        const auto [place, is_new] = shown_at.try_emplace(sample.time, &mesh, sample.value);
        if (!is_new) refuse_two(mesh, *place->second.first, sample.time);
      }
    }
    if (shown_at.empty())
      throw Unsupported(text_.file() + ": whatever moves in it is invisible; show it, and write it again");
    std::vector<double> times;
    for (const auto& [time, shown] : shown_at) {
      for (const UsdMesh& mesh : scene_->meshes)
        if (mesh.moves() && &mesh != shown.first && !is_hidden(mesh, time)) refuse_two(mesh, *shown.first, time);
      times.push_back(time);
      scene_->mesh_of_frame.push_back(shown.first);
      scene_->points_of_frame.push_back(shown.second);
    }
    set_times(times);
  }

  bool has_skeleton() const {
    return kinds_.contains("SkelRoot") || kinds_.contains("Skeleton") || kinds_.contains("SkelAnimation");
  }

  void note_what_is_left_out(std::size_t moving) {
    if (moving == 0) found_.notes.emplace_back("nothing in it moves: it is a film of one frame");
    if (moving > 0 && has_skeleton()) found_.notes.emplace_back("a skeleton is not read");
    if (refers_) found_.notes.emplace_back("references to other files or prims are not followed");
    if (kinds_.contains("PointInstancer")) found_.notes.emplace_back("instances are not drawn");
  }

  void set_times(const std::vector<double>& times) {
    const std::string_view metadata = text_.layer().metadata;
    double rate = default_usd_rate;
    for (const char* name : {"framesPerSecond", "timeCodesPerSecond"})
      if (const std::string_view value = text_.member(metadata, name); !value.empty()) {
        const auto numbers = text_.numbers(value);
        if (numbers.size() != 1 || !(numbers[0] > 0)) text_.fail(value, fmt::format("{} is not above 0", name));
        rate = numbers[0];
      }
    set_frame_times(found_, times, 1, rate, times.front());
  }

  [[noreturn]] void refuse_two(const UsdMesh& a, const UsdMesh& b, double time) const {
    throw Unsupported(
        fmt::format("{}: {} and {} are both seen at time code {}, and one mesh at a time is wanted: join "
                    "them, or {}",
                    text_.file(), b.path, a.path, time, frames_instead));
  }

  [[noreturn]] void refuse_still() const {
    std::string what =
        scene_->meshes.empty() ? "no mesh" : counted(std::ssize(scene_->meshes), "mesh") + ", none of which moves";
    if (has_skeleton()) what += ", and a skeleton, which is not read";
    if (refers_ || !text_.member(text_.layer().metadata, "subLayers").empty())
      what +=
          ", and references to other files, which are not followed: usdcat, of Pixar's tools, "
              "flattens all into one";
    throw Unsupported(
        fmt::format("{}: found {}; wanted a mesh whose points have time samples: bake what moves it, or {}",
                    text_.file(), what, frames_instead));
  }

  static std::vector<Vector3> points(const UsdScene& scene, const UsdMesh& mesh, std::string_view value) {
    const std::vector<double> numbers = scene.text.tuples(value, 3);
    std::vector<Vector3> result(numbers.size() / 3);
    const bool stands = mesh.matrix == Eigen::Matrix4d::Identity();
    for (std::size_t i = 0; i < result.size(); ++i) {
      result[i] = Vector3::Map(&numbers[3 * i]);
      if (!stands) result[i] = mesh.matrix.topLeftCorner<3, 3>() * result[i] + mesh.matrix.topRightCorner<3, 1>();
    }
    return result;
  }

  std::string_view constant(const UsdPrim& prim, std::string_view name) const {
    return usd_constant(text_, prim, name,
                        std::string("wanted one connectivity for all frames: ") + frames_instead);
  }

  void add_segment(const UsdMesh& mesh, std::string_view value) {
    const std::vector<Vector3> positions = points(*scene_, mesh, value);
    const UsdPrim& prim = *mesh.prim;
    const std::vector<int> counts = listed(prim, "faceVertexCounts"), corners = listed(prim, "faceVertexIndices");
    for (const int corner : corners)
      if (corner < 0 || corner >= std::ssize(positions))
        text_.fail(prim.name, fmt::format("{} has {} points, and faceVertexIndices names {}", mesh.path,
                                          positions.size(), corner));
    const UsdUvs uvs = uvs_of(prim, corners, positions.size());
    const bool mirrored = mesh.matrix.topLeftCorner<3, 3>().determinant() < 0;
    const UsdProperty* orientation = prim.property("orientation");
    const bool turned = mirrored != (orientation && usd_unquoted(orientation->value) == "leftHanded");
    EvolvingSegment segment;
    for (std::size_t v = 0; v < positions.size(); ++v) segment.vertex_ids.push_back(int(v));
    segment.uvs = uvs.pool;
    std::size_t begin = 0;
    for (const int count : counts) {
      if (count < 3 || count > max_polygon || std::size_t(count) > corners.size() - begin)
        text_.fail(prim.name, fmt::format("{} has a polygon of {} corners, with {} of faceVertexIndices left",
                                          mesh.path, count, corners.size() - begin));
      std::vector<Vector3> polygon;
      for (int k = 0; k < count; ++k) polygon.push_back(positions[std::size_t(corners[begin + std::size_t(k)])]);
      for (Triangle t : triangulate(polygon)) {
        if (turned) std::swap(t[1], t[2]);
        Triangle& of_corners = segment.triangles.emplace_back();
        for (std::size_t k = 0; k < 3; ++k) of_corners[k] = corners[begin + std::size_t(t[k])];
        if (uvs.corners.empty()) continue;
        Triangle& of_uvs = segment.corner_uvs.emplace_back();
        for (std::size_t k = 0; k < 3; ++k) of_uvs[k] = uvs.corners[begin + std::size_t(t[k])];
      }
      begin += std::size_t(count);
    }
    if (begin != corners.size())
      text_.fail(prim.name,
                 fmt::format("{} has {} corners, and its faceVertexCounts {}", mesh.path, corners.size(), begin));
    for (std::size_t t = 0; t < segment.triangles.size(); ++t) segment.triangle_ids.push_back(int(t));
    found_.segments.push_back(std::move(segment));
    found_.pictures.push_back(picture_of(mesh));
  }

  std::vector<int> listed(const UsdPrim& prim, std::string_view name) const {
    const std::string_view value = constant(prim, name);
    if (value.empty()) text_.fail(prim.name, fmt::format("{} has no {}", shown(prim.name), name));
    return text_.integers(value);
  }

  /// Texture coordinates of corners; none: `corners` is empty.
  struct UsdUvs {
    std::vector<Vector2> pool;
    std::vector<int> corners;
  };

  /// The set called st, or else the first.
  static const UsdProperty* uv_set(const UsdPrim& prim) {
    if (const UsdProperty* st = prim.property("primvars:st")) return st;
    const auto found = std::ranges::find_if(prim.properties, [](const UsdProperty& p) {
      return p.type.starts_with("texCoord2") && p.name.starts_with("primvars:");
    });
    return found == prim.properties.end() ? nullptr : &*found;
  }

  UsdUvs uvs_of(const UsdPrim& prim, const std::vector<int>& corners, std::size_t vertices) {
    UsdUvs result;
    const UsdProperty* set = uv_set(prim);
    const std::string_view value = set ? constant(prim, set->name) : "";
    if (value.empty()) return result;
    const std::vector<double> numbers = text_.tuples(value, 2);
    for (std::size_t i = 0; i < numbers.size(); i += 2) result.pool.emplace_back(numbers[i], numbers[i + 1]);
    const std::string_view how = usd_unquoted(text_.member(set->metadata, "interpolation"));
    const bool of_vertices = how == "vertex" || how == "varying";
    if (!of_vertices && how != "faceVarying") {
      found_.notes.push_back(
          fmt::format("{} of {} is of neither corners nor vertices, and is left out", set->name, shown(prim.name)));
      return {};
    }
    const std::string_view indices = constant(prim, std::string(set->name) + ":indices");
    std::vector<int> places;
    if (indices.empty())
      for (std::size_t i = 0; i < result.pool.size(); ++i) places.push_back(int(i));
    else
      places = text_.integers(indices);
    const std::size_t wanted = of_vertices ? vertices : corners.size();
    if (places.size() != wanted)
      text_.fail(value, fmt::format("{} texture coordinates, wanted one for each of {} {}", places.size(), wanted,
                                    of_vertices ? "vertices" : "corners"));
    for (std::size_t c = 0; c < corners.size(); ++c) {
      const int place = places[of_vertices ? std::size_t(corners[c]) : c];
      if (place < 0 || place >= std::ssize(result.pool))
        text_.fail(indices, fmt::format("index {} is out of range: there are {} texture coordinates", place,
                                        result.pool.size()));
      result.corners.push_back(place);
    }
    return result;
  }

  const UsdPrim* at(std::string_view path) const {
    const UsdPrim* prim = path.starts_with('/') ? &text_.layer() : nullptr;
    path = path.substr(0, path.find('.'));
    while (prim && path.size() > 1) {
      path.remove_prefix(1);
      const std::string_view name = path.substr(0, path.find('/'));
      prim = prim->child(name);
      path.remove_prefix(name.size());
    }
    return prim;
  }

  static const UsdPrim* surface_in(const UsdPrim& prim) {
    for (const UsdPrim& child : prim.children) {
      const UsdProperty* id = child.property("info:id");
      if (id && usd_unquoted(id->value) == "UsdPreviewSurface") return &child;
      if (const UsdPrim* found = surface_in(child)) return found;
    }
    return nullptr;
  }

  /// The picture of the base colour.
  FoundPicture picture_of(const UsdMesh& mesh) {
    const UsdPrim* material = mesh.material.empty() ? nullptr : at(mesh.material);
    const UsdPrim* surface = material ? surface_in(*material) : nullptr;
    const UsdProperty* colour = surface ? surface->property("inputs:diffuseColor") : nullptr;
    const UsdPrim* texture = colour ? at(usd_unquoted(colour->connection)) : nullptr;
    const UsdProperty* file = texture ? texture->property("inputs:file") : nullptr;
    if (!file) return {};
    return {portable_name(usd_unquoted(file->value))};
  }

  std::shared_ptr<UsdScene> scene_;
  const UsdText& text_;
  FoundAnimation found_;
  std::set<std::string> kinds_;
  bool refers_ = false;
};

FoundAnimation find_in_layer(const std::string& name, Bytes bytes, std::size_t begin, std::size_t size) {
  if (text_of(bytes).substr(begin, size).starts_with("PXR-USDC"))
    throw Unsupported(name +
                      ": found binary USD; write it as text first: usdcat -o walk.usda FILE, of Pixar's tools");
  return UsdFinder(std::make_shared<UsdScene>(name, std::move(bytes), begin, size)).find();
}

}  // namespace

void set_frame_times(FoundAnimation& found, const std::vector<double>& times, double step, double unit,
                     double first) {
  const double span = times.back() - times.front();
  const bool fits = std::abs(first) + span / step < INT_MAX && std::ranges::all_of(times, [&](double time) {
                      const double place = first + (time - times.front()) / step;
                      return place > -0.5 && std::abs(place - std::round(place)) < 0.01;
                    });
  const double mean = times.size() > 1 ? span / double(times.size() - 1) : step;
  found.frames_per_second = unit / mean;
  bool even = true;
  for (std::size_t i = 0; i < times.size(); ++i) {
    found.numbers.push_back(fits ? int(std::lround(first + (times[i] - times.front()) / step)) : int(i));
    even = even && std::abs(times[i] - times.front() - double(i) * mean) < 0.01 * mean;
  }
  if (!even)
    found.notes.push_back(fmt::format(
        "its frames are not equally far apart in time: {:.6g} a second are their mean", found.frames_per_second));
}

FoundAnimation find_usda_animation(const std::string& name, Bytes bytes) {
  const std::size_t size = bytes.size();
  return find_in_layer(name, std::move(bytes), 0, size);
}

FoundAnimation find_usdz_animation(const std::string& name, Bytes bytes) {
  const std::vector<StoredFile> files = stored_files(bytes, name);
  if (files.empty()) throw IoError(name + ": it is empty");
  // The layer that a package opens is its first file.
  const std::string layer = fmt::format("{}[{}]", name, files[0].name);
  const std::size_t begin = std::size_t(files[0].bytes.data() - bytes.data()), size = files[0].bytes.size();
  std::map<std::string, Bytes> pictures;
  for (const StoredFile& file : files)
    if (names_picture(file.name)) pictures[file.name] = Bytes(file.bytes.begin(), file.bytes.end());
  FoundAnimation found = find_in_layer(layer, std::move(bytes), begin, size);
  for (FoundPicture& picture : found.pictures)
    if (const auto in = pictures.find(picture.name); in != pictures.end()) picture.bytes = in->second;
  return found;
}

}  // namespace mq

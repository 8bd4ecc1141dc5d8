// Schemas as animation_usd.cpp has them. What is shown at a time code: meshes that neither are invisible nor lie
// in what is. What nothing is seen of is not read, so that cameras and lights may move as they like.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/io/detail/animation_found.h"
#include "mq/io/detail/stored_zip.h"
#include "mq/io/detail/usd_binding.h"
#include "mq/io/detail/usd_material.h"
#include "mq/io/detail/usd_mesh.h"
#include "mq/io/document.h"
#include "mq/io/file_names.h"

namespace mq {
namespace {

/// Of layers that do not say theirs (UsdStage, UsdGeom).
constexpr double default_usd_rate = 24, default_metres_per_unit = 0.01;

/// Prims with a surface that is not read.
constexpr std::string_view other_surfaces[] = {
    "BasisCurves", "Capsule", "Cone",           "Cube",   "Cylinder", "HermiteCurves", "NurbsCurves",
    "NurbsPatch",  "Plane",   "PointInstancer", "Points", "Sphere",   "TetMesh",       "Volume"};

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

class UsdFinder {
 public:
  UsdFinder(std::shared_ptr<UsdScene> scene) : scene_(std::move(scene)), text_(scene_->text) {}

  FoundAnimation find() {
    const UsdPrim& layer = text_.layer();
    refers_ = !text_.member(layer.metadata, "subLayers").empty();
    std::vector<const UsdPrim*> line;
    collect(layer, line);
    moving_ = std::size_t(std::ranges::count_if(scene_->meshes, &UsdMesh::moves));
    place_meshes();
    choose_frames();
    note_what_is_left_out();
    const UsdMesh* last = nullptr;
    for (const UsdMesh* mesh : scene_->mesh_of_frame) {
      if (mesh != last) add_segment(*mesh, scene_->points_of_frame[found_.segment_of.size()]);
      found_.segment_of.push_back(int(found_.segments.size()) - 1);
      last = mesh;
    }
    set_unit();
    found_.positions = [scene = scene_](int frame) {
      const UsdMesh& mesh = *scene->mesh_of_frame.at(std::size_t(frame));
      return mesh.positions(scene->text, scene->points_of_frame[std::size_t(frame)]);
    };
    return std::move(found_);
  }

 private:
  // ---- What there is ----

  /// Of a prim and what lies in it; `line` is what it lies in.
  void collect(const UsdPrim& prim, std::vector<const UsdPrim*>& line) {
    has_variants_ = has_variants_ || prim.has_variants;
    for (const UsdPrim& child : prim.children) {
      if (child.specifier != "def" || text_.member(child.metadata, "active") == "false" ||
          text_.member(child.metadata, "active") == "0")
        continue;
      for (const char* arc : {"references", "payload", "inherits", "specializes", "clips"})
        refers_ = refers_ || !text_.member(child.metadata, arc).empty();
      ++kinds_[child.type];
      line.push_back(&child);
      if (child.type == "Mesh") add_mesh(line);
      collect(child, line);
      line.pop_back();
    }
  }

  void add_mesh(const std::vector<const UsdPrim*>& line) {
    UsdMesh mesh{.line = line, .points = line.back()->property("points")};
    if (mesh.points) {
      // Points that are blocked at all times are none.
      const auto& samples = mesh.points->samples;
      const bool blocked = std::ranges::all_of(samples, [](const UsdSample& s) { return s.value.empty(); });
      if (samples.empty() ? mesh.points->value.empty() : blocked) mesh.points = nullptr;
    }
    const UsdProperty* purpose = mesh.inherited("purpose");
    const std::string_view use = purpose ? usd_unquoted(purpose->value) : "";
    for (const UsdPrim* prim : line) mesh.path += fmt::format("/{}", prim->name);
    if (use == "guide" || use == "proxy")
      found_.add_remark(fmt::format("{} is not drawn (purpose {}), and is left out", mesh.path, use));
    else if (!mesh.points)
      found_.add_note(fmt::format("{} has no points, and is left out", mesh.path));
    else
      scene_->meshes.push_back(std::move(mesh));
  }

  /// Those that will be shown; the transforms of others may change over time.
  void place_meshes() {
    if (scene_->meshes.empty() || (moving_ == 0 && (scene_->meshes.size() > 1 || has_skeleton()))) refuse_still();
    Eigen::Matrix4d up = Eigen::Matrix4d::Identity();
    const std::string_view axis = usd_unquoted(text_.member(text_.layer().metadata, "upAxis"));
    if (!axis.empty() && axis != "Y" && axis != "Z")
      text_.fail(axis, fmt::format("upAxis is {}, wanted \"Y\" or \"Z\"", shown(axis)));
    if (axis == "Z") up.topLeftCorner<3, 3>() << 1, 0, 0, 0, 0, 1, 0, -1, 0;
    for (UsdMesh& mesh : scene_->meshes)
      if (mesh.moves() || moving_ == 0) mesh.place(text_, up);
  }

  /// How many prims there are whose type ends so.
  std::int64_t count_of(std::string_view ending) const {
    std::int64_t count = 0;
    for (const auto& [kind, number] : kinds_) count += kind.ends_with(ending) ? number : 0;
    return count;
  }

  bool has_skeleton() const { return count_of("SkelRoot") + count_of("Skeleton") + count_of("SkelAnimation") > 0; }

  void note_what_is_left_out() {
    if (moving_ == 0) found_.add_note("nothing in it moves: it is a film of one frame");
    if (moving_ > 0 && has_skeleton()) found_.add_note("a skeleton is not read");
    if (refers_) found_.add_note("references to other files or prims are not followed");
    if (has_variants_) found_.add_note("variants are not read: choose one, and flatten the file, where it was made");
    if (moving_ > 0 && moving_ < scene_->meshes.size())
      found_.add_note(fmt::format("{} whose points do not move, beside what moves, are left out",
                                  counted(std::int64_t(scene_->meshes.size() - moving_), "mesh")));
    for (const std::string_view kind : other_surfaces)
      if (const auto found = kinds_.find(kind); found != kinds_.end())
        found_.add_note(
            fmt::format("{} of the kind {} are not read: make meshes of them", counted(found->second, "prim"), kind));
    if (kinds_.contains("GeomSubset"))
      found_.add_note("materials of parts of a mesh (GeomSubset) are not read: what is bound to the mesh is shown");
    if (const std::int64_t count = count_of("Camera"); count > 0)
      found_.add_remark(counted(count, "camera") + " in it: left out");
    if (const std::int64_t count = count_of("Light"); count > 0)
      found_.add_remark(counted(count, "light") + " in it: left out");
  }

  // ---- What is shown, and when ----

  void choose_frames() {
    std::map<double, std::pair<const UsdMesh*, std::string_view>> shown_at;
    std::set<double> unseen;
    for (const UsdMesh& mesh : scene_->meshes) {
      if (moving_ == 0 && seen_at_all(mesh)) shown_at[0] = {&mesh, mesh.points->value};
      for (const UsdSample& sample : mesh.points->samples) {
        if (!mesh.shown(sample.time)) {
          unseen.insert(sample.time);
          continue;
        }
        const auto [place, is_new] = shown_at.try_emplace(sample.time, &mesh, sample.value);
        if (!is_new) refuse_two(mesh, *place->second.first, sample.time);
      }
    }
    if (shown_at.empty())
      throw Unsupported(text_.file() +
                        ": whatever could be shown of it is invisible; make it visible, and write it again");
    std::vector<double> times;
    for (const auto& [time, shown] : shown_at) {
      for (const UsdMesh& mesh : scene_->meshes)
        if (mesh.moves() && &mesh != shown.first && mesh.shown(time)) refuse_two(mesh, *shown.first, time);
      times.push_back(time);
      unseen.erase(time);
      scene_->mesh_of_frame.push_back(shown.first);
      scene_->points_of_frame.push_back(shown.second);
    }
    if (!unseen.empty())
      found_.add_note(
          unseen_frames(unseen.size(), times.size() + unseen.size(), "time code", *unseen.begin(), *unseen.rbegin()));
    set_times(times);
  }

  /// Of one that stands still.
  static bool seen_at_all(const UsdMesh& mesh) {
    bool seen = mesh.shown(0);
    for (const UsdPrim* prim : mesh.line)
      if (const UsdProperty* visibility = prim->property("visibility"))
        for (const UsdSample& sample : visibility->samples) seen = seen || mesh.shown(sample.time);
    return seen;
  }

  /// A number above 0 that the layer says, if it does.
  std::optional<double> layer_number(const char* name) const {
    const std::string_view value = text_.member(text_.layer().metadata, name);
    if (value.empty()) return {};
    const auto numbers = text_.numbers(value);
    if (numbers.size() != 1 || !(numbers[0] > 0))
      text_.fail(value, fmt::format("{} is {}, wanted a number above 0", name, shown(value)));
    return numbers[0];
  }

  void set_times(const std::vector<double>& times) {
    const auto frames = layer_number("framesPerSecond"), codes = layer_number("timeCodesPerSecond");
    set_frame_times(found_, {.times = times,
                             .unit = codes.value_or(frames.value_or(default_usd_rate)),
                             .first = times.front(),
                             .word = "time codes"});
  }

  void set_unit() { found_.metres_per_unit = layer_number("metersPerUnit").value_or(default_metres_per_unit); }

  // ---- What is refused ----

  [[noreturn]] void refuse_two(const UsdMesh& a, const UsdMesh& b, double time) const {
    throw Unsupported(
        fmt::format("{}: {} and {} are both seen at time code {}, and one mesh at a time is wanted: join "
                    "them, or {}",
                    text_.file(), b.path, a.path, time, frames_instead));
  }

  [[noreturn]] void refuse_still() const {
    std::string what = scene_->meshes.empty()
                           ? "no mesh"
                           : counted(std::ssize(scene_->meshes), "mesh") + ", of none of which points move";
    if (has_skeleton()) what += ", and a skeleton, which is not read";
    if (has_variants_) what += ", and variants, of which none is read";
    if (refers_)
      what +=
          ", and references to other files or prims, which are not followed: usdcat, of Pixar's tools, flattens all "
          "into one file";
    throw Unsupported(
        fmt::format("{}: found {}; wanted a mesh whose points have time samples: bake what moves it, or {}",
                    text_.file(), what, frames_instead));
  }

  // ---- Segments ----

  void add_segment(const UsdMesh& mesh, std::string_view value) {
    const UsdBinding binding = usd_binding(text_, mesh);
    const UsdPicture picture = binding.material.empty() ? UsdPicture{} : usd_picture(text_, binding.material);
    UsdSurface surface = usd_surface(text_, mesh, mesh.positions(text_, value), picture.uv_set);
    for (const std::string& note : binding.notes) found_.add_note(note);
    for (const std::string& note : picture.notes) found_.add_note(note);
    for (const std::string& note : surface.notes) found_.add_note(note);
    for (const std::string& remark : surface.remarks) found_.add_remark(remark);
    found_.segments.push_back(std::move(surface.segment));
    found_.pictures.push_back({portable_name(picture.file)});
  }

  std::shared_ptr<UsdScene> scene_;
  const UsdText& text_;
  FoundAnimation found_;
  std::map<std::string_view, std::int64_t> kinds_;  ///< of prims, and how many there are of each
  std::size_t moving_ = 0;                          ///< meshes
  bool refers_ = false, has_variants_ = false;
};

FoundAnimation find_in_layer(const std::string& name, Bytes bytes, std::size_t begin, std::size_t size) {
  if (text_of(bytes).substr(begin, size).starts_with("PXR-USDC"))
    throw Unsupported(name +
                      ": found binary USD; write it as text first: usdcat -o walk.usda FILE, of Pixar's tools");
  return UsdFinder(std::make_shared<UsdScene>(name, std::move(bytes), begin, size)).find();
}

}  // namespace

FoundAnimation find_usda_animation(const std::string& name, Bytes bytes) {
  const std::size_t size = bytes.size();
  return find_in_layer(name, std::move(bytes), 0, size);
}

FoundAnimation find_usdz_animation(const std::string& name, Bytes bytes) {
  const std::vector<StoredFile> files = stored_files(bytes, name);
  if (files.empty()) throw IoError(name + ": it is empty");
  // The layer that a package opens is its first file.
  const std::string first = lower_extension(files[0].name);
  if (files[0].bytes.empty() || (first != ".usda" && first != ".usd" && first != ".usdc"))
    throw IoError(fmt::format("{}: its first file, {}, {}; wanted the layer that a package opens, .usda: pack it "
                              "first, as usdzip does",
                              name, shown(files[0].name), files[0].bytes.empty() ? "is empty" : "is no layer"));
  const std::string layer = fmt::format("{}[{}]", name, files[0].name);
  const std::size_t begin = std::size_t(files[0].bytes.data() - bytes.data()), size = files[0].bytes.size();
  std::map<std::string, Bytes> pictures;
  for (const StoredFile& file : files)
    if (names_picture(file.name)) pictures[file.name] = Bytes(file.bytes.begin(), file.bytes.end());
  FoundAnimation found = find_in_layer(layer, std::move(bytes), begin, size);
  const std::filesystem::path folder = std::filesystem::path(files[0].name).parent_path();
  for (FoundPicture& picture : found.pictures) {
    const std::string packed = (folder / picture.name).lexically_normal().generic_string();
    if (const auto in = pictures.find(packed); in != pictures.end()) {
      picture.bytes = in->second;
    } else if (!picture.name.empty()) {
      found.add_note(fmt::format("its picture {} is not in the package, and is left out; pack it too",
                                 shown(picture.name)));
      picture = {};
    }
  }
  return found;
}

}  // namespace mq

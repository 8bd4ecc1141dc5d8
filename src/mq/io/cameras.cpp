// Which reader a path asks for, and what is done to cameras of all formats alike: their pictures are
// found, cameras that need their size completed, and everything checked. Each format has a source of
// its own, cameras_*.cpp.
#include "mq/io/cameras.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>

#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/base/words.h"
#include "mq/io/atomic_file.h"
#include "mq/io/bytes.h"
#include "mq/io/detail/camera_entries.h"
#include "mq/io/detail/picture_finder.h"
#include "mq/io/detail/unlike_sizes.h"
#include "mq/io/file_names.h"
#include "mq/io/image_file.h"
#include "mq/io/path_status.h"

namespace mq {
namespace {

namespace fs = std::filesystem;

const char* const what_a_folder_has =
    "cameras.txt or cameras.bin (COLMAP), there or in sparse/0 or sparse, transforms.json, bundle.out, or "
    ".xmp files beside photographs (RealityCapture)";

/// COLMAP's model in `project`, or in what COLMAP makes there; none where there is none.
std::optional<CameraEntries> find_colmap(const fs::path& project) {
  for (const fs::path& folder : {project, project / "sparse" / "0", project / "sparse"}) {
    if (is_there(folder / "cameras.txt")) return read_colmap_text(folder);
    if (is_there(folder / "cameras.bin")) return read_colmap_binary(folder);
  }
  return std::nullopt;
}

CameraEntries read_folder(const fs::path& folder) {
  if (auto found = find_colmap(folder)) return std::move(*found);
  if (is_there(folder / "transforms.json")) return read_json_cameras(folder / "transforms.json");
  for (const fs::path& path : {folder / "bundle.out", folder / "bundle" / "bundle.out"})
    if (is_there(path)) return read_bundler(path);
  for (const fs::path& place : {folder, folder / "images"})
    if (const auto sidecars = xmp_cameras_in(place); !sidecars.empty()) return read_xmp_cameras(sidecars);
  throw IoError(fmt::format("{}: has no cameras.txt, nor any other cameras; wanted a folder with {}",
                            folder.string(), what_a_folder_has));
}

CameraEntries read_entries(const fs::path& path) {
  if (is_folder(path)) return read_folder(path);
  const std::string name = path.filename().string(), extension = lower_extension(path);
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  if (name == "cameras.txt" || name == "images.txt") return read_colmap_text(folder);
  if (name == "cameras.bin" || name == "images.bin") return read_colmap_binary(folder);
  if (extension == ".out") return read_bundler(path);
  if (extension == ".xml") return read_metashape(path);
  if (extension == ".xmp") return read_xmp_cameras({path});
  if (extension == ".gltf" || extension == ".glb") return read_gltf_cameras(path);
  if (extension == ".mvs") return read_openmvs(path);
  return read_json_cameras(path);
}

/// Programs keep cameras in a folder of their own (sparse/0 of a project, or sparse of undistorted
/// pictures, with the pictures in images beside sparse): so up to two folders further up. What is in these is photographs
/// where it was said or is called so: folders in them are looked through too.
PictureFinder finder_of_pictures(const fs::path& folder, const CamerasOptions& options) {
  for (const fs::path& images : options.images)
    if (!is_folder(images))
      throw IoError(images.string() + ": wanted a folder with the pictures of the cameras");
  if (!options.images.empty()) return PictureFinder(options.images, options.images);
  const fs::path here = fs::absolute(folder / ".").lexically_normal().parent_path();
  const fs::path above = here.parent_path();
  return PictureFinder({folder, folder / "images", above / "images", above, above.parent_path() / "images"},
                       {folder / "images", above / "images", above.parent_path() / "images"});
}

std::optional<fs::path> picture_of(const CameraEntry& entry, const PictureFinder& finder) {
  if (auto found = finder.find(entry.name, entry.where)) return found;
  for (const std::string& name : entry.other_names)
    if (auto found = finder.find(name, entry.where)) return found;
  return std::nullopt;
}

/// Sorts entries by whether their picture is there.
class Resolver {
 public:
  Resolver(const PictureFinder& finder, CameraSet& set) : finder_(finder), set_(set) {}

  void add(CameraEntry& entry) {
    if (const auto picture = picture_of(entry, finder_)) {
      remember(*picture, entry.where);
      PinholeCamera camera = entry.camera;
      if (entry.complete && !complete(entry, *picture, camera)) return;
      check_camera(camera, entry.where);
      set_.photographs.push_back({*picture, camera});
      return;
    }
    if (entry.complete)
      entry.camera.width = entry.camera.height = 0;
    else
      check_camera(entry.camera, entry.where);
    set_.missing.push_back({entry.name, entry.camera});
  }

  /// Once all are added: looks again at those whose size only their pictures say.
  void settle_sizes() {
    std::vector<UnsizedPicture> pictures;
    for (const Unsized& one : unsized_)
      pictures.push_back({one.info.width, one.info.height, exchanges_sides(one.info),
                          set_.photographs[one.photograph].camera.fx});
    const UsualSize usual(pictures);
    const std::vector<SizeVerdict> verdicts = judged_sizes(pictures, usual);
    std::vector<char> stays(set_.photographs.size(), 1);
    int turned = 0;
    for (std::size_t k = 0; k < unsized_.size(); ++k) {
      if (verdicts[k] != SizeVerdict::upright && orientation(unsized_[k].info.format) != 1) ++turned;
      stays[unsized_[k].photograph] = settle(unsized_[k], verdicts[k], usual);
    }
    std::vector<Photograph> left;
    for (std::size_t k = 0; k < stays.size(); ++k)
      if (stays[k]) left.push_back(std::move(set_.photographs[k]));
    set_.photographs = std::move(left);
    note_turned(turned);
  }

 private:
  /// One whose file does not say its size; it is completed with that of the picture as stored.
  struct Unsized {
    const CameraEntry* entry;
    PictureInfo info;
    std::size_t photograph;
  };

  static bool exchanges_sides(const PictureInfo& info) {
    constexpr int first_exchanging = 5;
    return orientation(info.format) >= first_exchanging;
  }

  /// What follows from the verdict; false where it is to be left out.
  bool settle(const Unsized& one, SizeVerdict verdict, const UsualSize& usual) {
    Photograph& photograph = set_.photographs[one.photograph];
    const std::string name = photograph.picture.string();
    const std::string beside = fmt::format("{} × {}, where most pictures of {} are {} × {}", one.info.width,
                                           one.info.height, set_.format, usual.width, usual.height);
    switch (verdict) {
      case SizeVerdict::as_stored: return true;
      case SizeVerdict::upright:
        set_.notes.push_back(fmt::format("{}: is {}: it is turned as its tag (EXIF) says", name, beside));
        [[fallthrough]];
      case SizeVerdict::scaled:
        photograph.camera = one.entry->camera;
        photograph.camera.width = usual.width, photograph.camera.height = usual.height;
        one.entry->complete(photograph.camera);
        return true;
      case SizeVerdict::on_its_side:
        set_.doubts.push_back(fmt::format("{}: is {}, and no tag says that it lies on its side: it is taken as it was "
                                          "taken so; turn it back if it was not", name, beside));
        return true;
      case SizeVerdict::unlike:
        set_.doubts.push_back(fmt::format("{}: is {}, unlike all others: it is taken as of another camera; leave it out "
                                          "if it has been cropped or stretched", name, beside));
        return true;
      case SizeVerdict::cropped: break;
    }
    PinholeCamera camera = one.entry->camera;
    camera.width = camera.height = 0;
    set_.unreadable.push_back({{photograph.picture, camera},
                               fmt::format("{}: is {}, though its focal length is theirs: has it been cropped or "
                                           "stretched since?", name, beside)});
    return false;
  }

  void note_turned(int turned) {
    if (turned > 0)
      set_.notes.push_back(fmt::format("{} to be turned (EXIF): cameras are of them as they are stored",
                                       turned == 1 ? "1 picture says that it is"
                                                   : counted(turned, "picture") + " say that they are"));
  }

  void remember(const fs::path& picture, const std::string& where) {
    const auto [first, fresh] = where_.emplace(full_name(picture), where);
    if (!fresh)
      throw IoError(fmt::format("{}: its picture is {}, which is that of another camera, {}, too", where,
                                picture.string(), first->second));
  }

  /// False where its picture cannot be read.
  bool complete(const CameraEntry& entry, const fs::path& picture, PinholeCamera& camera) {
    PictureInfo info;
    try {
      info = picture_info(picture);
    } catch (const IoError& error) {
      camera.width = camera.height = 0;
      set_.unreadable.push_back({{picture, camera}, error.what()});
      return false;
    }
    camera.width = info.width, camera.height = info.height;
    entry.complete(camera);
    unsized_.push_back({&entry, std::move(info), set_.photographs.size()});
    return true;
  }

  const PictureFinder& finder_;
  CameraSet& set_;
  std::map<fs::path, std::string> where_;
  std::vector<Unsized> unsized_;
};

[[noreturn]] void refuse_missing(const fs::path& path, const CameraSet& set,
                                 const PictureFinder& finder) {
  constexpr std::size_t most_named = 5;
  const std::size_t all = set.missing.size() + set.photographs.size();
  std::vector<std::string> names;
  for (std::size_t k = 0; k < std::min(most_named, set.missing.size()); ++k)
    names.push_back(set.missing[k].picture.empty() ? "(one without a name)"
                                                   : set.missing[k].picture.string());
  if (set.missing.size() > most_named) names.emplace_back("...");
  std::vector<std::string> places;
  for (const fs::path& folder : finder.folders())
    places.push_back(folder.empty() ? "." : folder.lexically_normal().string());
  throw IoError(fmt::format("{}: of {} {} not there: {}; looked in {}: move them, give the folder with the "
                            "pictures ({}), or go on without them ({} skip)",
                            path.string(), counted(std::int64_t(all), "picture"),
                            set.missing.size() == 1 ? "1 is" : fmt::format("{} are", set.missing.size()),
                            fmt::join(names, ", "), fmt::join(places, ", "), option_name("images"),
                            option_name("missing")));
}

[[noreturn]] void refuse_unreadable(const CameraSet& set) {
  constexpr std::size_t most_named = 20;
  std::vector<std::string> all;
  for (std::size_t k = 0; k < std::min(most_named, set.unreadable.size()); ++k) all.push_back(set.unreadable[k].why);
  if (set.unreadable.size() > most_named) all.push_back(fmt::format("and {} more", set.unreadable.size() - most_named));
  throw IoError(fmt::format("{}; or go on without {} ({} skip)", fmt::join(all, "\n"),
                            set.unreadable.size() == 1 ? "it" : "them", option_name("missing")));
}

nlohmann::ordered_json camera_json(const Photograph& photograph) {
  const PinholeCamera& c = photograph.camera;
  const Eigen::Matrix3d& R = c.rotation;
  nlohmann::ordered_json json = {{"image", photograph.picture.string()},
                                 {"width", c.width},
                                 {"height", c.height},
                                 {"fx", c.fx},
                                 {"fy", c.fy},
                                 {"cx", c.cx},
                                 {"cy", c.cy}};
  if (c.skew != 0) json["skew"] = c.skew;
  if (c.lens.projection != Lens::Projection::perspective)
    json["lens"] = projection_name(c.lens.projection);
  for (const LensNumber& number : lens_numbers())
    if (c.lens.*number.value != 0) json[number.name] = c.lens.*number.value;
  json["rotation"] = {{R(0, 0), R(0, 1), R(0, 2)}, {R(1, 0), R(1, 1), R(1, 2)}, {R(2, 0), R(2, 1), R(2, 2)}};
  json["translation"] = {c.translation.x(), c.translation.y(), c.translation.z()};
  return json;
}

}  // namespace

bool names_cameras(const fs::path& path) {
  constexpr const char* files[] = {".json", ".out", ".xml", ".xmp", ".mvs", ".txt", ".bin"};
  constexpr const char* in_folders[] = {"transforms.json", "cameras.txt", "images.txt", "cameras.bin", "sparse"};
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) return std::ranges::count(files, lower_extension(path)) > 0;
  return std::ranges::any_of(in_folders, [&](const char* name) { return fs::exists(path / name, ignored); });
}

CameraSet read_camera_set(const fs::path& path, const CamerasOptions& options) {
  CameraEntries entries = read_entries(path);
  if (entries.cameras.empty())
    throw IoError(path.string() + ": holds no camera" +
                  (entries.without_pose > 0
                       ? fmt::format(" that is placed: {} are not: align the photographs first",
                                     entries.without_pose)
                       : ""));
  CameraSet set{.format = entries.format,
                .photographs = {},
                .missing = {},
                .without_pose = entries.without_pose,
                .notes = entries.notes,
                .files = entries.files};
  const PictureFinder finder = finder_of_pictures(entries.folder, options);
  Resolver resolver(finder, set);
  for (CameraEntry& entry : entries.cameras) resolver.add(entry);
  resolver.settle_sizes();
  if (!set.missing.empty() && options.missing == CamerasOptions::Missing::refuse)
    refuse_missing(path, set, finder);
  if (!set.unreadable.empty() && options.unreadable == CamerasOptions::Missing::refuse) refuse_unreadable(set);
  return set;
}

std::vector<Photograph> read_cameras(const fs::path& path) {
  return std::move(read_camera_set(path).photographs);
}

CameraFormat camera_format_of(const fs::path& path) {
  const std::string extension = lower_extension(path);
  if (path.filename() == "transforms.json") return CameraFormat::transforms;
  if (extension == ".json") return CameraFormat::json;
  if (extension.empty() || is_folder(path)) return CameraFormat::colmap;
  throw InvalidInput(fmt::format("{}: names no format that cameras are written in; wanted .json, "
                                 "transforms.json, or a folder for COLMAP's",
                                 path.string()));
}

std::vector<fs::path> camera_files(const fs::path& path, CameraFormat format) {
  if (format == CameraFormat::json || format == CameraFormat::transforms) return {path};
  const std::string end = format == CameraFormat::colmap ? ".txt" : ".bin";
  return {path / ("cameras" + end), path / ("images" + end), path / ("points3D" + end)};
}

std::vector<Photograph> named_for(const fs::path& path, CameraFormat format,
                                  std::vector<Photograph> photographs) {
  const bool by_folder = format == CameraFormat::colmap || format == CameraFormat::colmap_binary;
  fs::path root = full_name(path.has_parent_path() ? path.parent_path() : fs::path("."));
  std::vector<Photograph*> there;
  for (Photograph& photograph : photographs)
    if (std::error_code ignored; fs::is_regular_file(photograph.picture, ignored))
      there.push_back(&photograph);
  if (by_folder && !there.empty()) {
    root = full_name(there.front()->picture).parent_path();
    const auto holds = [&](const Photograph* one) {
      const fs::path name = full_name(one->picture).lexically_relative(root);
      return !name.empty() && *name.begin() != "..";
    };
    while (!std::ranges::all_of(there, holds) && root.has_relative_path()) root = root.parent_path();
  }
  for (Photograph* const photograph : there) {
    const fs::path name = full_name(photograph->picture).lexically_relative(root);
    if (!name.empty()) photograph->picture = name;
  }
  return photographs;
}

void write_cameras(const fs::path& path, const std::vector<Photograph>& photographs,
                   CameraFormat format) {
  switch (format) {
    case CameraFormat::transforms: return write_transforms(path, photographs);
    case CameraFormat::colmap: return write_colmap_text(path, photographs);
    case CameraFormat::colmap_binary: return write_colmap_binary(path, photographs);
    default: break;
  }
  nlohmann::ordered_json cameras = nlohmann::ordered_json::array();
  for (const Photograph& photograph : photographs) cameras.push_back(camera_json(photograph));
  write_file(path, bytes_of(nlohmann::ordered_json{{"cameras", cameras}}.dump(2) + "\n"));
}

}  // namespace mq

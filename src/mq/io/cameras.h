#pragma once
/// Cameras of photographs as files of programs that find them; docs/cameras.md says what each is read
/// by and which conventions it has.

#include <filesystem>
#include <string>
#include <vector>

#include "mq/draw/pinhole.h"

namespace mq {

/// A photograph's file and its camera.
struct Photograph {
  std::filesystem::path picture;
  PinholeCamera camera;
};

/// One that cannot be used, and why.
struct UnusablePhotograph {
  Photograph photograph;
  std::string why;
};

/// What a file says of cameras.
struct CameraSet {
  std::string format;                   ///< "COLMAP's text", ...
  std::vector<Photograph> photographs;  ///< whose pictures were found, as the file orders them
  /// Those whose pictures were not, by the names that the file gives them; the size of their pictures
  /// is 0 where the file does not say it.
  std::vector<Photograph> missing;
  /// Whose pictures are there but cannot be read, where the file does not say their size, so that it was looked for, or
  /// have been cropped since, as far as sizes and focal lengths of the others tell; of size 0.
  std::vector<UnusablePhotograph> unreadable = {};
  int without_pose = 0;            ///< which the file lists without knowing where they stood
  std::vector<std::string> notes;  ///< what a user may want to know
  std::vector<std::string> doubts = {};  ///< what a user is to be warned of: pictures that may not be as they were
  std::vector<std::filesystem::path> files;  ///< that were read, but for pictures
};

struct CamerasOptions {
  /// Folders with the pictures. Empty: beside the file, in a folder "images" there or up to two
  /// folders further up, and in the folder above, so that projects are read as they lie. Folders in these that are
  /// given, and in those that are called "images", are looked through too.
  std::vector<std::filesystem::path> images = {};
  enum class Missing { refuse, list } missing = Missing::refuse;
  Missing unreadable = Missing::refuse;  ///< pictures that are there, of which the size is wanted
};

/// Reads `path`:
///
/// - a folder, or a file cameras.txt, images.txt, cameras.bin or images.bin in it: COLMAP's model, as
///   text or binary, in the folder or its sparse/0 or sparse;
/// - .json with "frames", or a folder with transforms.json: cameras of NeRF tools;
/// - .json with "cameras": our own, {"cameras": [{"image", "width", "height", "fx", "fy", "cx", "cy",
///   "skew", "lens" (`projection_name`) and numbers of `Lens` (0 where left out), "rotation" (three
///   rows) or "quaternion" (w, x, y, z), "translation"}, ...]}, in the conventions of
///   `PinholeCamera`;
/// - .out: Bundler's, with its list of pictures;
/// - .xml: Metashape's cameras;
/// - .xmp, or a folder with some: what RealityCapture writes beside photographs;
/// - .gltf or .glb: perspective cameras of its nodes, as Blender writes them;
/// - .mvs: a scene of OpenMVS.
///
/// A picture is found by its name as the file says it; by the last part of that; by that but for
/// capitals; by that with another extension; the same in folders of folders. Throws `IoError` naming the file, the place and what was
/// wanted: also where names fit several pictures, cameras share one, or pictures are missing that are
/// to be there; and `Unsupported` for lenses and versions that are not known.
CameraSet read_camera_set(const std::filesystem::path& path, const CamerasOptions& options = {});

/// Whether `path` is one of these but glTF, and no mesh: by the name of a file, by what is in a folder.
bool names_cameras(const std::filesystem::path& path);

/// Its photographs, none of which is missing.
std::vector<Photograph> read_cameras(const std::filesystem::path& path);

/// Formats that cameras are written in.
enum class CameraFormat {
  json,           ///< our own
  transforms,     ///< transforms.json of NeRF tools
  colmap,         ///< a folder with cameras.txt, images.txt and points3D.txt without points
  colmap_binary,  ///< the same as .bin
};

/// What a name asks for: transforms.json, another .json, or a folder, for COLMAP's text. Throws
/// `InvalidInput` for other extensions.
CameraFormat camera_format_of(const std::filesystem::path& path);

/// The files that `write_cameras` would write.
std::vector<std::filesystem::path> camera_files(const std::filesystem::path& path,
                                                CameraFormat format);

/// The same photographs with pictures named from `folder`, where their files are there; COLMAP's names
/// are from the folder that holds all of them. What is not there keeps its name.
std::vector<Photograph> named_for(const std::filesystem::path& path, CameraFormat format,
                                  std::vector<Photograph> photographs);

/// Writes cameras. Pictures are named as they are given: from the file's folder. Throws `Unsupported`
/// naming the picture whose lens the format has no words for, and `IoError`.
void write_cameras(const std::filesystem::path& path, const std::vector<Photograph>& photographs,
                   CameraFormat format = CameraFormat::json);

}  // namespace mq

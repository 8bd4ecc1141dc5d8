#include "file_kind.h"

#include <algorithm>
#include <array>

#include "mq/io/cameras.h"
#include "mq/io/file_names.h"
#include "sequence.h"

namespace mq::view {
namespace {

constexpr std::array<FileKindWords, 3> kinds = {{
    {"Open a model", "open", "models, pictures and sequences", true},
    {"Choose pictures", "choose", "pictures", true},
    {"Choose cameras", "choose", "cameras: JSON, COLMAP, Metashape, Bundler, OpenMVS, glTF, XMP", false},
}};

/// Of COLMAP, in whose folders other files of text lie.
bool is_text_of_cameras(const std::filesystem::path& path) {
  const std::string stem = path.stem().string();
  return stem == "cameras" || stem == "images";
}

}  // namespace

const FileKindWords& words_of(FileKind kind) { return kinds[std::size_t(kind)]; }

bool is_of(FileKind kind, const std::filesystem::path& path) {
  switch (kind) {
    case FileKind::models: return names_model(path) || names_picture(path) || names_sequence(path.string());
    case FileKind::pictures: return names_picture(path);
    case FileKind::cameras: break;
  }
  const std::string extension = lower_extension(path);
  if (extension == ".txt" || extension == ".bin") return is_text_of_cameras(path);
  return names_cameras(path) || names_gltf(path);
}

const std::vector<std::string>& patterns_of(FileKind kind) {
  static const std::array<std::vector<std::string>, 3> patterns = {{
      {"*.obj", "*.ply", "*.gltf", "*.glb", "*.evolving", "*.png", "*.jpg", "*.jpeg", "*.webp", "*.tif", "*.tiff",
       "*.exr", "*.bmp", "*.tga"},
      {"*.png", "*.jpg", "*.jpeg", "*.webp", "*.tif", "*.tiff", "*.exr", "*.bmp", "*.tga"},
      {"*.json", "*.xml", "*.out", "*.mvs", "*.gltf", "*.glb", "*.xmp", "cameras.txt", "cameras.bin", "images.txt",
       "images.bin"},
  }};
  return patterns[std::size_t(kind)];
}

}  // namespace mq::view

#include "mq/io/file_names.h"

#include <algorithm>

#include "mq/io/frame_files.h"

namespace mq {

std::string lower_extension(const std::filesystem::path& path) {
  std::string text = path.extension().string();
  for (char& c : text) c = c >= 'A' && c <= 'Z' ? char(c + 32) : c;
  return text;
}

bool names_model(const std::filesystem::path& path) {
  static constexpr const char* models[] = {".obj", ".ply", ".gltf", ".glb"};
  return std::ranges::count(models, lower_extension(path)) > 0;
}

bool names_gltf(const std::filesystem::path& path) {
  return lower_extension(path) == ".gltf" || lower_extension(path) == ".glb";
}

bool names_picture(const std::filesystem::path& path) {
  static constexpr const char* pictures[] = {".png",  ".jpg", ".jpeg", ".webp", ".tif",
                                             ".tiff", ".exr", ".bmp",  ".tga"};
  return std::ranges::count(pictures, lower_extension(path)) > 0;
}

bool names_animation(const std::filesystem::path& path) {
  static constexpr const char* animations[] = {".glb", ".usda", ".usdz"};
  return std::ranges::count(animations, lower_extension(path)) > 0 &&
         !has_frame_place(path.filename().string());
}

bool holds_numbers(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  return extension == ".exr" || extension == ".tif" || extension == ".tiff";
}

}  // namespace mq

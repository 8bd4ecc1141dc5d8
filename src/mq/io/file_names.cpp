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

namespace {

/// Whether the first line that is neither empty nor a remark begins with a word of OBJ files. A line that
/// is cut off counts, as does one remark of which no end is seen.
bool begins_as_obj(std::string_view text) {
  static constexpr std::string_view words[] = {"v", "vt", "vn", "f", "o", "g", "s", "mtllib", "usemtl"};
  while (!text.empty()) {
    const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
    const std::string_view line = text.substr(0, end), word = line.substr(0, line.find_first_of(" \t"));
    if (!word.empty() && !word.starts_with('#')) return std::ranges::count(words, word) > 0;
    if (end == text.size()) return word.starts_with('#');
    text.remove_prefix(end + 1);
  }
  return false;
}

}  // namespace

std::string extension_by_content(std::string_view bytes) {
  using namespace std::string_view_literals;
  static constexpr std::pair<std::string_view, const char*> beginnings[] = {
      {"\x89PNG"sv, ".png"}, {"\xff\xd8\xff"sv, ".jpg"}, {"II*\0"sv, ".tif"},  {"MM\0*"sv, ".tif"},
      {"v/1\x01"sv, ".exr"}, {"BM"sv, ".bmp"},           {"PIEH"sv, ".flo"}, {"ply\n"sv, ".ply"},
      {"ply\r"sv, ".ply"},   {"glTF"sv, ".glb"},         {"#usda"sv, ".usda"}, {"PXR-USDC"sv, ".usdc"},
      {"PK\x03\x04"sv, ".usdz"}};
  constexpr std::string_view mark = "\xef\xbb\xbf";
  if (bytes.starts_with(mark)) bytes.remove_prefix(mark.size());
  for (const auto& [beginning, extension] : beginnings)
    if (bytes.starts_with(beginning)) return extension;
  if (bytes.starts_with("RIFF") && bytes.substr(std::min<std::size_t>(8, bytes.size())).starts_with("WEBP"))
    return ".webp";
  const std::size_t word = bytes.find_first_not_of(" \t\r\n");
  if (bytes.find("\"marquetry evolving mesh\"") != std::string_view::npos) return ".evolving";
  if (word != std::string_view::npos && (bytes[word] == '{' || bytes[word] == '['))
    return bytes.find("\"asset\"") == std::string_view::npos ? ".json" : ".gltf";
  return begins_as_obj(bytes) ? ".obj" : "";
}

bool holds_numbers(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  return extension == ".exr" || extension == ".tif" || extension == ".tiff";
}

std::vector<std::filesystem::path> files_beside_made(const std::filesystem::path& model, int pictures) {
  const std::string extension = lower_extension(model);
  if (extension == ".gltf") return {std::filesystem::path(model).replace_extension(".bin")};
  if (extension == ".obj" && pictures > 0) return {std::filesystem::path(model).replace_extension(".mtl")};
  return {};
}

}  // namespace mq

// Names are looked up in a list of all folders that exist: what is read and written goes by its path through
// every layer, and only this room opens paths.
#include "mq/io/held_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <mutex>

#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/base/parallel.h"
#include "mq/base/words.h"
#include "mq/io/bytes.h"
#include "mq/io/detail/held.h"
#include "mq/io/detail/picture_values.h"
#include "mq/io/slots.h"

namespace mq {

struct HeldFiles::Data {
  std::string folder;  ///< "memory:3"
  std::mutex mutex;
  std::map<std::string, PictureView> held_pictures;
  std::map<std::string, Model> held_models;
  std::map<std::string, WrittenPicture> pictures;
  std::map<std::string, WrittenModel> models;
  std::map<std::string, std::vector<Vector3>> fields;
  std::map<std::string, std::vector<std::byte>> files;
};

namespace {

namespace fs = std::filesystem;

/// The folders there are, by name.
struct HeldFolders {
  std::mutex mutex;
  std::map<std::string, std::weak_ptr<HeldFiles::Data>> folders;
  std::int64_t made = 0;
};

HeldFolders& held_folders() {
  static HeldFolders all;
  return all;
}

/// A name in memory, taken apart.
struct HeldName {
  std::shared_ptr<HeldFiles::Data> folder;
  std::string name;
};

/// Nothing where it is a file's.
std::optional<HeldName> held_name(const fs::path& path) {
  const std::string text = path.generic_string();
  if (!text.starts_with(held_scheme)) return {};
  const std::size_t slash = text.find('/');
  const std::lock_guard lock(held_folders().mutex);
  const auto found = held_folders().folders.find(text.substr(0, slash));
  if (found == held_folders().folders.end()) return {};
  std::shared_ptr<HeldFiles::Data> folder = found->second.lock();
  if (folder == nullptr) return {};
  return HeldName{std::move(folder), slash == text.npos ? "" : text.substr(slash + 1)};
}

[[noreturn]] void fail_not_held(const fs::path& path, const char* wanted) {
  throw IoError(fmt::format("{}: is held in memory and is not {}; write it to a file, and name that",
                            path.string(), wanted));
}

/// A view, so that its bytes are not looked at under the lock.
PictureView view_of(const HeldName& held, const fs::path& path) {
  const std::lock_guard lock(held.folder->mutex);
  const auto found = held.folder->held_pictures.find(held.name);
  if (found == held.folder->held_pictures.end()) fail_not_held(path, "a picture");
  return found->second;
}

template <class Stored>
float as_value(const std::byte* at) {
  Stored stored;
  std::memcpy(&stored, at, sizeof stored);
  if constexpr (std::is_same_v<Stored, float>)
    return stored;
  else
    return float(stored) / float(std::numeric_limits<Stored>::max());
}

template <class Stored>
void copy_values(const PictureView& from, Image<float>& to) {
  parallel_for(from.height, [&](std::int64_t y) {
    const std::byte* row = static_cast<const std::byte*>(from.values) + y * from.row_step;
    float* out = to.pixel(0, int(y)).data();
    for (int x = 0; x < from.width; ++x, row += from.pixel_step)
      for (int c = 0; c < from.channels; ++c) *out++ = as_value<Stored>(row + c * from.channel_step);
  }, 16);
}

Image<float> pixels_of(const PictureView& view) {
  Image<float> pixels(view.width, view.height, view.channels);
  switch (view.depth) {
    case Depth::u8: copy_values<std::uint8_t>(view, pixels); break;
    case Depth::u16: copy_values<std::uint16_t>(view, pixels); break;
    default: copy_values<float>(view, pixels);
  }
  return pixels;
}

PixelFormat format_of(const PictureView& view) {
  return {.depth = view.depth, .file_format = view.depth < Depth::half ? "png" : "openexr", .tags = {}};
}

WrittenPicture written(const std::string& name, const Texture& texture) {
  const Image<float>& pixels = texture.pixels;
  if (pixels.empty()) throw InvalidInput(fmt::format("{}: the picture has no pixels", name));
  check_finite(name, pixels, 0, pixels.values().size(), "nothing was written");
  WrittenPicture made{.width = pixels.width(),
                      .height = pixels.height(),
                      .channels = pixels.channels(),
                      .depth = texture.format.depth};
  if (made.depth == Depth::u8)
    quantise<std::uint8_t>(pixels.values(), made.values);
  else if (made.depth == Depth::u16)
    quantise<std::uint16_t>(pixels.values(), made.values);
  else
    made.values.assign(std::as_bytes(pixels.values()).begin(), std::as_bytes(pixels.values()).end());
  return made;
}

/// How many textures the triangles of a mesh count.
int counted_textures(const Mesh& mesh) {
  return mesh.textures.empty() ? 1 : 1 + std::max(0, *std::ranges::max_element(mesh.textures));
}

/// Where triangles use several textures there is a picture for each; one, where they use one, paints the
/// whole mesh.
void take_pictures(const fs::path& path, const ReadModelOptions& options, const Progress& progress,
                   Model& model) {
  const std::string slot = options.slot.empty() ? "" : known_slot(options.slot, path.string());
  const std::size_t given = options.textures.size(), count = std::size_t(counted_textures(model.mesh));
  if (given == 0) return;
  if (given != count)
    throw InvalidInput(fmt::format("{} has {}, but {} given; give one for each", path.string(),
                                   counted(std::int64_t(count), "texture"),
                                   given == 1 ? "1 picture is" : fmt::format("{} pictures are", given)));
  if (count == 1) model.mesh.textures.clear();
  for (const fs::path& file : options.textures) {
    if (options.pictures == ReadModelOptions::Pictures::skip) {
      model.textures.emplace_back().path = file;
      continue;
    }
    model.textures.push_back(read_texture(file, progress.step("read picture", 1.0 / double(given)),
                                          options.not_finite, options.layer));
    if (!slot.empty()) model.textures.back().meaning = meaning_of_slot(slot);
  }
}

}  // namespace

HeldFiles::HeldFiles() : data_(std::make_shared<Data>()) {
  const std::lock_guard lock(held_folders().mutex);
  data_->folder = fmt::format("{}{}", held_scheme, ++held_folders().made);
  held_folders().folders[data_->folder] = data_;
}

HeldFiles::~HeldFiles() {
  const std::lock_guard lock(held_folders().mutex);
  held_folders().folders.erase(data_->folder);
}

fs::path HeldFiles::path(const std::string& name) const { return data_->folder + "/" + name; }

void HeldFiles::put(const std::string& name, const PictureView& picture) {
  require(picture.width > 0 && picture.height > 0 && picture.channels > 0,
          fmt::format("{}: the picture has no pixels", path(name).string()));
  require(picture.width <= max_picture_side && picture.height <= max_picture_side,
          fmt::format("{}: is {} x {}, and a picture has at most {} pixels a side", path(name).string(),
                      picture.width, picture.height, max_picture_side));
  require(picture.channels <= 4, fmt::format("{}: has {} channels, wanted 1 to 4 (the last of 2 and of 4 "
                                             "is alpha)",
                                             path(name).string(), picture.channels));
  const std::lock_guard lock(data_->mutex);
  data_->held_pictures[name] = picture;
}

void HeldFiles::put(const std::string& name, Model model) {
  model.path = path(name);
  const std::lock_guard lock(data_->mutex);
  data_->held_models[name] = std::move(model);
}

std::map<std::string, WrittenPicture>& HeldFiles::pictures() { return data_->pictures; }
std::map<std::string, WrittenModel>& HeldFiles::models() { return data_->models; }
std::map<std::string, std::vector<Vector3>>& HeldFiles::fields() { return data_->fields; }
std::map<std::string, std::vector<std::byte>>& HeldFiles::files() { return data_->files; }

bool names_held(const fs::path& path) { return held_name(path).has_value(); }

bool names_standard_output(const fs::path& path) {
  return path.stem() == standard_output_stem && path.parent_path().filename().string().starts_with(pipe_folder_begin);
}

std::optional<Texture> held_texture(const fs::path& path, NotFinite not_finite, const std::string& layer,
                                    const Progress& progress) {
  const std::optional<HeldName> held = held_name(path);
  if (!held) return {};
  require(layer.empty(), fmt::format("{}: has no layer {}, as an array has none; leave {} out", path.string(),
                                     shown(layer), option_name("layer")));
  const PictureView view = view_of(*held, path);
  Texture texture;
  texture.name = path.filename().string();
  texture.path = path;
  texture.format = format_of(view);
  texture.pixels = pixels_of(view);
  if (view.depth >= Depth::half && not_finite == NotFinite::refuse)
    check_finite(path.string(), texture.pixels, 0, texture.pixels.values().size(), "repair the picture");
  progress.at(1);
  return texture;
}

std::optional<PictureInfo> held_picture_info(const fs::path& path) {
  const std::optional<HeldName> held = held_name(path);
  if (!held) return {};
  const PictureView view = view_of(*held, path);
  static const std::vector<std::string> names[] = {{"Y"}, {"Y", "A"}, {"R", "G", "B"}, {"R", "G", "B", "A"}};
  return PictureInfo{view.width, view.height, names[view.channels - 1], format_of(view)};
}

std::optional<Model> held_model(const fs::path& path, const ReadModelOptions& options,
                                const Progress& progress) {
  const std::optional<HeldName> held = held_name(path);
  if (!held) return {};
  Model model;
  {
    const std::lock_guard lock(held->folder->mutex);
    const auto found = held->folder->held_models.find(held->name);
    if (found == held->folder->held_models.end()) fail_not_held(path, "a model");
    model = found->second;
  }
  require(options.uv_set <= 0,
          fmt::format("{}: has one set of texture coordinates; found {} {}", path.string(),
                      option_name("uv_set"), options.uv_set));
  take_pictures(path, options, progress, model);
  progress.at(1);
  return model;
}

bool hold_texture(const fs::path& path, const Texture& texture) {
  const std::optional<HeldName> held = held_name(path);
  if (!held) return false;
  WrittenPicture made = written(path.string(), texture);
  const std::lock_guard lock(held->folder->mutex);
  held->folder->pictures[held->name] = std::move(made);
  return true;
}

bool hold_model(const fs::path& path, const Model& model) {
  const std::optional<HeldName> held = held_name(path);
  if (!held) return false;
  WrittenModel made{.mesh = model.mesh, .colors = model.colors};
  std::map<std::string, WrittenPicture> pictures;
  for (const auto* textures : {&model.textures, &model.others})
    for (const Texture& texture : *textures) {
      const bool drawn = !texture.pixels.empty();
      const std::string name = fmt::format("{}/{}", held->name, drawn ? texture.name : "");
      if (textures == &model.textures) made.pictures.push_back(drawn ? name : "");
      if (drawn) pictures[name] = written(texture.name, texture);
    }
  const std::lock_guard lock(held->folder->mutex);
  held->folder->models[held->name] = std::move(made);
  for (auto& [name, picture] : pictures) held->folder->pictures[name] = std::move(picture);
  return true;
}

bool hold_flow(const fs::path& path, const Image<float>& field) {
  const std::optional<HeldName> held = held_name(path);
  if (!held) return false;
  const std::span<const std::byte> bytes = std::as_bytes(field.values());
  const std::lock_guard lock(held->folder->mutex);
  held->folder->pictures[held->name] = {
      field.width(), field.height(), field.channels(), Depth::f32, {bytes.begin(), bytes.end()}};
  return true;
}

bool hold_field(const fs::path& path, const std::vector<Vector3>& field) {
  const std::optional<HeldName> held = held_name(path);
  if (!held) return false;
  const std::lock_guard lock(held->folder->mutex);
  held->folder->fields[held->name] = field;
  return true;
}

bool hold_bytes(const fs::path& path, std::span<const std::byte> bytes) {
  const std::optional<HeldName> held = held_name(path);
  if (!held) return false;
  const std::lock_guard lock(held->folder->mutex);
  held->folder->files[held->name] = {bytes.begin(), bytes.end()};
  return true;
}

void require_file(const fs::path& path) {
  if (held_name(path)) fail_not_held(path, "read or written there");
}

}  // namespace mq

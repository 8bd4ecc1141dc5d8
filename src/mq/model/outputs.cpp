#include "mq/model/outputs.h"

#include <fmt/format.h>

#include <algorithm>

#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/base/words.h"
#include "mq/io/document.h"
#include "mq/io/file_names.h"
#include "mq/io/held_files.h"
#include "mq/io/materials.h"
#include "mq/io/path_status.h"
#include "mq/io/slots.h"
#include "mq/io/tiles.h"

namespace mq {
namespace {

namespace fs = std::filesystem;

/// The textures to be written. A model with texture coordinates that names no picture is given one
/// for each texture that its triangles count, named after it.
std::vector<Texture> textures_of(const Model& model) {
  std::vector<Texture> textures;
  for (const Texture& texture : model.textures) {
    Texture& added = textures.emplace_back();
    added.name = texture.name, added.path = texture.path, added.format = texture.format;
  }
  if (!textures.empty() || !model.mesh.has_uvs()) return textures;
  int count = 1;
  for (int t = 0; t < model.mesh.triangle_count(); ++t)
    count = std::max(count, model.mesh.texture(t) + 1);
  const std::string stem = model.path.stem().string();
  for (int i = 0; i < count; ++i) {
    Texture& added = textures.emplace_back();
    added.name = (count == 1 ? stem : fmt::format("{}_{}", stem, i)) + ".png";
    added.format.file_format = "png";
  }
  return textures;
}

/// The file name a texture goes by; pictures embedded in a model are named after it.
fs::path own_name(const Model& model, const std::vector<Texture>& textures, std::size_t i) {
  const Texture& texture = textures[i];
  if (!texture.path.empty()) return texture.path.filename();
  const std::string stem = texture.name.empty()
                               ? fmt::format("{}_{}", model.path.stem().string(), i)
                               : fs::path(texture.name).stem().string();
  const std::string& format = texture.format.file_format;
  return stem + (format == "jpeg" ? ".jpg" : format == "openexr" ? ".exr" : "." + format);
}

/// Whether a picture embedded in `from` becomes a file beside `to`: unless it can be embedded
/// again.
bool leaves_model(const fs::path& to, const fs::path& from) {
  return to.extension() != ".glb" && to.extension() != from.extension();
}

/// Whether pictures beside `from` go into `to`: a GLB that is made anew holds them.
bool joins_model(const fs::path& to, const fs::path& from) {
  return to.extension() == ".glb" && from.extension() != ".glb";
}

bool names_folder(const std::string& name) { return name.ends_with('/') || is_folder(name); }

/// Whether changed pictures are named after the model at `to`: beside their source, which stays, and where the model has
/// another name, so that several results share a folder. Replaced, or elsewhere under its own name, it keeps theirs.
bool names_pictures(const fs::path& to, const fs::path& from) {
  std::error_code ignored;
  if (names_held(to) || names_standard_output(to) || fs::equivalent(to, from, ignored)) return false;
  const fs::path folder = to.parent_path(), source = from.parent_path();
  return to.stem() != from.stem() || fs::equivalent(folder.empty() ? "." : folder, source.empty() ? "." : source, ignored);
}

/// Whether a file has the bytes that another one has.
bool is_copy(const fs::path& file, const fs::path& of) {
  std::error_code ignored;
  return fs::is_regular_file(file, ignored) && fs::file_size(file, ignored) == fs::file_size(of, ignored) &&
         read_file(file) == read_file(of);
}

/// A number goes after the name of all but the first of several with one file name.
fs::path numbered(const fs::path& own, int number) {
  if (number == 1) return own;
  return own.parent_path() /
         fmt::format("{}_{}{}", own.stem().string(), number, own.extension().string());
}

/// The path that `named` makes of a texture's own name, or of that with a number where another
/// texture is written to it.
template <class Named>
fs::path free_path(const std::vector<fs::path>& taken, const fs::path& own, const Named& named) {
  for (int number = 1;; ++number)
    if (fs::path path = named(numbered(own, number)); std::ranges::count(taken, path) == 0)
      return path;
}

/// Before any work: the writer would refuse it after all of it.
void refuse_unknown_formats(const std::vector<fs::path>& paths) {
  for (const fs::path& path : paths)
    require(names_picture(path),
            fmt::format("{}: found '{}', wanted a picture (.png, .jpg, .webp, .tif, .exr, .bmp or "
                        ".tga), a model (.obj, .ply, .gltf or .glb) or a folder",
                        option_name("output"), path.string()));
}

}  // namespace

Outputs::Outputs(const std::string& name, const Model& model, Kind kind)
    : is_model_(names_model(name)) {
  require(!is_model_ || !names_picture(model.path),
          fmt::format("{}: found '{}', wanted a picture: what is read is one",
                      option_name("output"), name));
  require(kind == Kind::pictures || is_model_,
          fmt::format("{}: found '{}', wanted a model (.ply, .obj, ...), since what "
                      "changes is part of it",
                      option_name("output"), name));
  if (is_model_) {
    plan_model(name, model, kind);
    return;
  }
  if (names_folder(name)) folder_ = name;
  const std::vector<Texture> textures = textures_of(model);
  if (const std::optional<TileName> tile = tile_name(name); tile && !tile->place) {
    plan_tiles(*tile, model);
    return;
  }
  const std::size_t place = name.find("%s");
  require(place != std::string::npos || !folder_.empty() || textures.size() == 1,
          fmt::format("{}: {} has {}: name a folder (with / at its end), or put %s in the "
                      "name; found '{}'",
                      option_name("output"), model.path.string(),
                      counted(std::ssize(textures), "texture"), name));
  for (std::size_t i = 0; i < textures.size(); ++i) {
    if (place == std::string::npos && folder_.empty()) {
      paths_.emplace_back(name);
      break;
    }
    paths_.push_back(free_path(paths_, own_name(model, textures, i), [&](const fs::path& own) {
      return !folder_.empty()
                 ? fs::path(name) / own
                 : fs::path(name.substr(0, place) + own.stem().string() + name.substr(place + 2));
    }));
  }
  refuse_unknown_formats(paths_);
}

void Outputs::plan_tiles(const TileName& name, const Model& model) {
  require(model.tiles.size() == model.textures.size() && !model.tiles.empty(),
          fmt::format("{}: found '{}', a name for tiles, and the pictures of {} are none",
                      option_name("output"), name.pattern(), model.path.string()));
  for (const TextureTile& tile : model.tiles) {
    require(tile.picture == model.tiles.front().picture,
            fmt::format("{}: {} has several pictures in tiles: name a folder (with / at its end) "
                        "for them; found '{}'",
                        option_name("output"), model.path.string(), name.pattern()));
    require(name.has_number_for({tile.u, tile.v}),
            fmt::format("{}: '{}' has no number for the tile from ({}, {})", option_name("output"),
                        name.pattern(), tile.u, tile.v));
    paths_.push_back(name.file({tile.u, tile.v}));
  }
  refuse_unknown_formats(paths_);
}

std::set<fs::path> Outputs::folders() const {
  std::set<fs::path> folders;
  if (!folder_.empty()) folders.insert(folder_);
  for (std::size_t i = 1; is_model_ && i < paths_.size(); ++i) {
    const fs::path own = paths_[0].parent_path(), its = paths_[i].parent_path();
    const fs::path inner = its.lexically_relative(own.empty() ? "." : own);
    if (its != own && stays_below(inner.string())) folders.insert(its);
  }
  return folders;
}

void Outputs::plan_model(const std::string& name, const Model& model, Kind kind) {
  const fs::path path(name);
  paths_ = {path};
  if (kind == Kind::model) {
    plan_copies(path, model);
    plan_libraries(path, model);
    return;
  }
  std::error_code ignored;
  const std::vector<Texture> textures = textures_of(model);
  const bool made_up = model.textures.empty() || !model.document;
  const bool alone =
      textures.size() == 1 && model.tiles.empty() &&
      std::ranges::all_of(model.others, [](const Texture& other) { return other.pixels.empty(); });
  for (std::size_t i = 0; i < textures.size(); ++i) {
    const Texture& texture = textures[i];
    const fs::path own = own_name(model, textures, i);
    if (!texture.path.empty() && joins_model(path, model.path)) {
      texture_names_.push_back(texture.name);
      continue;
    }
    const bool beside_source = fs::equivalent(path.parent_path() / own, texture.path, ignored) &&
                               !fs::equivalent(path, model.path, ignored);
    const bool renamed = beside_source || (!texture.path.empty() && names_pictures(path, model.path));
    const std::string stem = path.stem().string();
    const bool leaves = made_up ? path.extension() != ".glb"
                                : texture.path.empty() && leaves_model(path, model.path);
    const std::string wanted = !leaves && !renamed ? texture.name
                               : !leaves && alone  ? stem + own.extension().string()
                                                   : stem + "_" + own.string();
    texture_names_.push_back(wanted);
    if (!leaves && texture.path.empty()) continue;
    paths_.push_back(free_path(paths_, wanted, [&](const fs::path& name_in_model) {
      texture_names_.back() = name_in_model.generic_string();
      return path.parent_path() / name_in_model;
    }));
  }
  plan_others(path, model);
  plan_libraries(path, model);
}

namespace {

/// Whether an OBJ file comes with what it names: neither in memory nor to standard output.
bool writes_beside(const fs::path& path) {
  return lower_extension(path) == ".obj" && !names_held(path) && !names_standard_output(path);
}

/// The name of a picture in a model that is written to `folder`: one that lies elsewhere comes beside it.
std::string name_beside(const fs::path& folder, const std::string& name, const fs::path& source) {
  std::error_code ignored;
  const bool stays = stays_below(name) || fs::equivalent(folder / name, source, ignored);
  return stays ? name : fs::path(name).filename().string();
}

}  // namespace

/// Pictures that come with an OBJ file whose shape alone changes, into another folder.
void Outputs::plan_copies(const fs::path& path, const Model& model) {
  if (!writes_beside(path)) return;
  const bool keeps_all = model.document && model.document->format == Document::Format::obj;
  const std::vector<char> named = named_pictures(model, path);
  std::size_t i = 0;
  for (const auto* textures : {&model.textures, &model.others})
    for (const Texture& texture : *textures) {
      std::error_code ignored;
      const bool is_written = keeps_all || named[i];
      ++i;
      if (!is_written || texture.path.empty() || texture.name.empty() || !fs::exists(texture.path, ignored)) continue;
      const fs::path to = path.parent_path() / name_beside(path.parent_path(), texture.name, texture.path);
      if (!is_copy(to, texture.path) && std::ranges::count(paths_, to) == 0) paths_.push_back(to);
    }
}

/// What an OBJ file keeps its materials in.
void Outputs::plan_libraries(const fs::path& path, const Model& model) {
  if (!writes_beside(path)) return;
  Model named;
  named.path = model.path, named.mesh = model.mesh, named.colors = model.colors, named.document = model.document;
  named.materials = model.materials, named.slots = model.slots, named.slot = model.slot, named.tiles = model.tiles;
  named.uv_sets = model.uv_sets, named.uv_set = model.uv_set;
  std::vector<std::string> names;
  const auto add = [&](const Texture& texture, const std::string& name, std::vector<Texture>& to) {
    to.emplace_back().name = name_beside(path.parent_path(), name, texture.path);
    to.back().path = texture.path;
    names.push_back(to.back().name);
  };
  const std::vector<Texture> textures = texture_names_.empty() ? std::vector<Texture>() : textures_of(model);
  for (std::size_t i = 0; i < textures.size(); ++i) add(textures[i], texture_names_[i], named.textures);
  if (textures.empty())
    for (const Texture& texture : model.textures) add(texture, texture.name, named.textures);
  for (std::size_t i = 0; i < model.others.size(); ++i)
    add(model.others[i], i < other_names_.size() ? other_names_[i] : model.others[i].name, named.others);
  for (const std::string& library : libraries_beside(path, named, names))
    if (const fs::path to = path.parent_path() / library; std::ranges::count(paths_, to) == 0) paths_.push_back(to);
}

namespace {

/// Whether a picture of another slot, or another tile of it, has got pixels of its own.
bool is_processed(const Model& model, const Texture& texture) {
  const std::optional<TileName> tile = tile_name(texture.name);
  return std::ranges::any_of(model.others, [&](const Texture& other) {
    if (other.pixels.empty()) return false;
    const std::optional<TileName> its = tile_name(other.name);
    return &other == &texture || (tile && its && tile->same_pattern(*its));
  });
}

}  // namespace

/// Pictures of the other slots: copied, or, processed, under another name where they would replace
/// what was read.
void Outputs::plan_others(const fs::path& path, const Model& model) {
  if (!model.document || path.extension() != model.path.extension())
    return plan_new_others(path, model);
  std::error_code ignored;
  const bool named_after = names_pictures(path, model.path);
  const bool same_folder =
      fs::equivalent(path.parent_path().empty() ? "." : path.parent_path(),
                     model.path.parent_path().empty() ? "." : model.path.parent_path(), ignored);
  for (const Texture& texture : model.others) {
    other_names_.push_back(texture.name);
    const bool processed = is_processed(model, texture);
    const bool renamed = processed && named_after;
    const std::string wanted =
        renamed ? path.stem().string() + "_" + fs::path(texture.name).filename().string()
        : same_folder || stays_below(texture.name) ? texture.name
                                                   : fs::path(texture.name).filename().string();
    if (texture.path.empty()) {
      const std::optional<TileName> tile = tile_name(texture.name);
      if (tile && !tile->place) other_names_.back() = wanted;
      continue;
    }
    const fs::path to = path.parent_path() / wanted;
    const bool there = fs::equivalent(to, texture.path, ignored);
    if (!processed && (there || std::ranges::count(paths_, to) > 0 || is_copy(to, texture.path))) continue;
    paths_.push_back(free_path(paths_, wanted, [&](const fs::path& name_in_model) {
      other_names_.back() = name_in_model.generic_string();
      return path.parent_path() / name_in_model;
    }));
  }
}

/// Those that a file made anew names, or all that a glTF had in the other container; a GLB holds them.
void Outputs::plan_new_others(const fs::path& path, const Model& model) {
  std::error_code ignored;
  const bool keeps_materials = names_gltf(path) && model.document && model.document->is_gltf();
  const std::vector<char> named = named_pictures(model, path);
  for (std::size_t i = 0; i < model.others.size(); ++i) {
    const Texture& texture = model.others[i];
    other_names_.push_back(texture.name);
    const bool is_named = keeps_materials || named[model.textures.size() + i];
    if (!is_named || path.extension() == ".glb") continue;
    const fs::path own = (texture.path.empty() ? fs::path(texture.name) : texture.path).filename();
    const bool there = fs::equivalent(path.parent_path() / own, texture.path, ignored);
    if (there && texture.pixels.empty()) {
      other_names_.back() = own.string();
      continue;
    }
    const std::string wanted = path.stem().string() + "_" + own.string();
    paths_.push_back(free_path(paths_, wanted, [&](const fs::path& name_in_model) {
      other_names_.back() = name_in_model.generic_string();
      return path.parent_path() / name_in_model;
    }));
  }
}

std::vector<std::string> Outputs::write(Model model, const Progress& progress) const {
  if (is_model_) {
    for (std::size_t i = 0; i < std::min(texture_names_.size(), model.textures.size()); ++i)
      model.textures[i].name = texture_names_[i];
    for (std::size_t i = 0; i < std::min(other_names_.size(), model.others.size()); ++i)
      model.others[i].name = other_names_[i];
    return write_model(paths_.front(), model, progress);
  }
  std::vector<std::string> notes;
  for (std::size_t i = 0; i < paths_.size(); ++i)
    for (std::string& note :
         write_texture(paths_[i], model.textures[i],
                       progress.step(paths_[i].filename().string(), 1.0 / double(paths_.size()))))
      notes.push_back(std::move(note));
  return notes;
}

}  // namespace mq

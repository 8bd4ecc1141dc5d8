#include "mq/model/outputs.h"

#include <fmt/format.h>

#include <algorithm>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/io/file_names.h"

namespace mq {
namespace {

namespace fs = std::filesystem;

/// The textures to be written. A model with texture coordinates that names no picture is given one for
/// each texture that its triangles count, named after it.
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

bool is_folder(const std::string& name) { return name.ends_with('/') || fs::is_directory(name); }

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
            fmt::format("output: found '{}', wanted a picture (.png, .jpg, .tif, .exr, .bmp or "
                        ".tga), a model (.obj, .ply, .gltf or .glb) or a folder",
                        path.string()));
}

}  // namespace

Outputs::Outputs(const std::string& name, const Model& model, Kind kind)
    : is_model_(names_model(name)) {
  require(!is_model_ || !names_picture(model.path),
          fmt::format("output: found '{}', wanted a picture: what is read is one", name));
  require(kind == Kind::pictures || is_model_,
          fmt::format("output: found '{}', wanted a model (.ply, .obj, ...), since what "
                      "changes is part of it",
                      name));
  if (is_model_) {
    plan_model(name, model, kind);
    return;
  }
  if (is_folder(name)) folder_ = name;
  const std::vector<Texture> textures = textures_of(model);
  const std::size_t place = name.find("%s");
  require(place != std::string::npos || !folder_.empty() || textures.size() == 1,
          fmt::format("output: {} has {}: name a folder (with / at its end), or put %s in the "
                      "name; found '{}'",
                      model.path.string(), counted(std::ssize(textures), "texture"), name));
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

void Outputs::plan_model(const std::string& name, const Model& model, Kind kind) {
  const fs::path path(name);
  paths_ = {path};
  if (kind == Kind::model) return;
  std::error_code ignored;
  const std::vector<Texture> textures = textures_of(model);
  const bool made_up = model.textures.empty();
  for (std::size_t i = 0; i < textures.size(); ++i) {
    const Texture& texture = textures[i];
    const fs::path own = own_name(model, textures, i);
    if (!texture.path.empty() && joins_model(path, model.path)) {
      texture_names_.push_back(texture.name);
      continue;
    }
    const bool beside_source = fs::equivalent(path.parent_path() / own, texture.path, ignored) &&
                               !fs::equivalent(path, model.path, ignored);
    const std::string stem = path.stem().string();
    const bool leaves = made_up ? path.extension() != ".glb"
                                : texture.path.empty() && leaves_model(path, model.path);
    const std::string wanted = !leaves && !beside_source ? texture.name
                               : !leaves && textures.size() == 1
                                   ? stem + own.extension().string()
                                   : stem + "_" + own.string();
    texture_names_.push_back(wanted);
    if (!leaves && texture.path.empty()) continue;
    paths_.push_back(free_path(paths_, wanted, [&](const fs::path& name_in_model) {
      texture_names_.back() = name_in_model.generic_string();
      return path.parent_path() / name_in_model;
    }));
  }
}

std::vector<std::string> Outputs::write(Model model, const Progress& progress) const {
  if (is_model_) {
    for (std::size_t i = 0; i < std::min(texture_names_.size(), model.textures.size()); ++i)
      model.textures[i].name = texture_names_[i];
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

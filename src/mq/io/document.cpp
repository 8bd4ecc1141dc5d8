#include "mq/io/document.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/base/words.h"
#include "mq/io/detail/gltf.h"
#include "mq/io/detail/obj.h"
#include "mq/io/detail/ply.h"
#include "mq/io/tiles.h"

namespace mq {

std::string portable_name(std::string_view name) {
  std::string result(name);
  std::replace(result.begin(), result.end(), '\\', '/');
  while (result.starts_with("./")) result.erase(0, result.find_first_not_of('/', 2));
  return result;
}

bool stays_below(const std::string& name) {
  const std::filesystem::path path(name);
  return path.is_relative() && std::find(path.begin(), path.end(), "..") == path.end();
}

bool same_connectivity(const Mesh& a, const Mesh& b) {
  return a.vertex_count() == b.vertex_count() && a.triangles == b.triangles &&
         a.uvs.size() == b.uvs.size() && a.corner_uvs == b.corner_uvs;
}

namespace {

/// One name for each picture of the file: that of its texture, or one that stands for all its
/// tiles, in the way the file had it: a pattern, or the name of the same tile.
std::optional<std::vector<std::string>> names_of_pictures(const Model& model,
                                                          const std::vector<std::string>& names,
                                                          const std::vector<TextureSlot>& slots) {
  std::vector<std::vector<std::string>> of_picture(std::max<std::size_t>(slots.size(), 1));
  const int count = int(of_picture.size());
  for (std::size_t t = 0; t < model.tiles.size(); ++t) {
    const int picture = model.tiles[t].picture;
    if (picture < 0 || picture >= count) return {};
    const std::optional<TileName> tile = tile_name(names[t]);
    if (tile && tile->place && *tile->place != TilePlace{model.tiles[t].u, model.tiles[t].v})
      return {};
    of_picture[std::size_t(picture)].push_back(names[t]);
  }
  std::vector<std::string> result;
  for (std::size_t p = 0; p < of_picture.size(); ++p) {
    const std::vector<std::string>& tiles = of_picture[p];
    const std::optional<TileName> before =
        p < slots.size() ? tile_name(slots[p].name) : std::optional<TileName>();
    const std::string pattern = common_pattern(tiles);
    if (tiles.empty() || (pattern.empty() && tiles.size() > 1)) return {};
    result.push_back(pattern.empty() || (tiles.size() == 1 && !before) ? tiles.front()
                     : before && before->place ? tile_name(pattern)->file(*before->place)
                                               : pattern);
  }
  return result;
}

}  // namespace

std::optional<std::vector<std::string>> slot_names(const MeshFile& document, const Model& model,
                                                   const std::vector<std::string>& names) {
  const std::vector<TextureSlot>& slots = document.textures;
  const bool named = std::any_of(slots.begin(), slots.end(), [](const TextureSlot& slot) {
    return !slot.name.empty() || !slot.picture.empty();
  });
  const std::size_t count = std::min(names.size(), model.textures.size());
  std::vector<std::string> pictures(names.begin(), names.begin() + std::ptrdiff_t(count));
  if (!named && pictures.empty()) return std::vector<std::string>(slots.size());
  const bool tiled = !model.tiles.empty();
  if (tiled) {
    if (model.tiles.size() != count) return {};
    auto joined = names_of_pictures(model, pictures, named ? slots : std::vector<TextureSlot>());
    if (!joined) return {};
    pictures = std::move(*joined);
  }
  // One picture given to a model that names none paints the whole mesh.
  if (!named && pictures.size() == 1 && (tiled || model.mesh.textures.empty()))
    return std::vector<std::string>(std::max<std::size_t>(slots.size(), 1), pictures[0]);
  if (pictures.size() != slots.size() ||
      model.mesh.triangle_count() > document.mesh.triangle_count())
    return {};
  for (int t = 0; t < model.mesh.triangle_count(); ++t) {
    const int texture = model.mesh.texture(t);
    const int picture = tiled && texture >= 0 && texture < std::ssize(model.tiles)
                            ? model.tiles[std::size_t(texture)].picture
                            : texture;
    if (picture != document.mesh.texture(t)) return {};
  }
  return pictures;
}

void require_uv_set(int set, int count, const std::string& file) {
  if (set >= std::max(count, 1))
    throw InvalidInput(fmt::format("{}: {} {}: it has {} of texture coordinates, counted from 0",
                                   file, option_name("uv_set"), set, counted(count, "set")));
}

int own_uv_set(const Model& model) {
  if (model.uv_set >= 0) return model.uv_set;
  int own = -1;
  for (const MaterialSlot& slot : model.slots) {
    if (slot.name != model.slot) continue;
    for (const MaterialSlot::Use& use : slot.pictures) {
      if (own >= 0 && use.uv_set != own) return -1;
      own = use.uv_set;
    }
  }
  return std::max(own, 0);
}

std::vector<const UvSet*> other_uv_sets(const Model& model) {
  std::vector<const UvSet*> others;
  const int own = own_uv_set(model);
  for (std::size_t set = 0; set < model.uv_sets.size(); ++set)
    if (int(set) != own && model.uv_sets[set].corner_uvs.size() == model.mesh.triangles.size())
      others.push_back(&model.uv_sets[set]);
  return others;
}

unsigned stored_color(float value, unsigned largest) {
  if (!(value > 0)) return 0;
  return unsigned(std::lround(std::min(double(value), 1.0) * largest));
}

int color_channels(const VertexSignal& colors) {
  if (colors.channels == 0) return 0;
  if (colors.channels == 1 || colors.channels == 3) return 3;
  if (colors.channels == 4) return 4;
  throw Unsupported("vertex colours of " + std::to_string(colors.channels) +
                    " channels: mesh files hold 1, 3 or 4; write the others one by one");
}

float color(const VertexSignal& colors, int vertex, int channel) {
  const int stored = colors.channels == 1 ? 0 : channel;
  return colors.values[std::size_t(vertex) * colors.channels + stored];
}

MeshFile read_document(const Document& document) {
  switch (document.format) {
    case Document::Format::obj: return read_obj(document);
    case Document::Format::ply: return read_ply(document);
    case Document::Format::gltf:
    case Document::Format::glb: return read_gltf(document);
  }
  return {};
}

}  // namespace mq

#include "mq/model/textured_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "mq/atlas/footprint.h"
#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/base/words.h"
#include "mq/fem/image_space.h"
#include "mq/image/resample.h"
#include "mq/image/spread.h"
#include "mq/io/file_names.h"
#include "mq/io/image_file.h"
#include "mq/io/slots.h"

namespace mq {
namespace {

bool all_finite(const Texture& texture) {
  return texture.format.depth < Depth::half ||
         std::ranges::all_of(texture.pixels.values(),
                             [](float value) { return std::isfinite(value); });
}

/// 1 for the texels of a texture that charts read.
Image<char> used_texels(const TexturedModel& all, std::size_t texture) {
  const Image<float>& picture = all.model.textures[texture].pixels;
  Image<char> used(picture.width(), picture.height(), 1, all.atlas ? 0 : 1);
  if (!all.atlas) return used;
  const Footprints footprints(*all.atlas);
  const Wrap wrap = all.atlas->textures[texture].wrap;
  for (int t = 0; t < int(all.atlas->chart.size()); ++t) {
    if (all.atlas->chart[t] < 0 ||
        all.atlas->charts[all.atlas->chart[t]].texture != int(texture))
      continue;
    for (const TexelSpan& span : footprints.of(t))
      for (int x = span.first; x < span.end; ++x)
        used(wrapped(x, used.width(), wrap), wrapped(span.row, used.height(), wrap)) = 1;
  }
  return used;
}

void replace_unused_not_finite(TexturedModel& all, std::size_t texture, Messages& messages) {
  Image<float>& picture = all.model.textures[texture].pixels;
  const Image<char> used = used_texels(all, texture);
  Image<float> filled = picture;
  spread(used, std::numeric_limits<double>::infinity(), filled);
  std::int64_t replaced = 0;
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x)
      for (int c = 0; c < picture.channels(); ++c) {
        if (std::isfinite(picture(x, y, c))) continue;
        if (used(x, y))
          throw IoError(fmt::format(
              "{}: pixel (column {}, row {}) holds {} in channel {}{}; repair the picture",
              texture_file(all.model, texture), x, y, picture(x, y, c), c,
              all.atlas ? ", and a chart uses it" : ""));
        picture(x, y, c) = filled(x, y, c);
        ++replaced;
      }
  messages.remark(fmt::format(
      "{}: {} values outside all charts are infinite or no numbers; those of the nearest texels of "
      "a chart stand for them",
      texture_file(all.model, texture), replaced));
}

/// Of a picture that is not read.
TextureSize size_by_head(const Model& model, std::size_t i) {
  const Texture& texture = model.textures[i];
  require(!texture.path.empty(),
          fmt::format("{}: is not in a file of its own, and pictures are read one by one: export the model with its "
                      "pictures beside it (as .gltf or .obj)",
                      texture_file(model, i)));
  const PictureInfo info = picture_info(texture.path);
  return {info.width, info.height, model.tiles.empty() ? texture.wrap : Wrap::clamp};
}

/// Sizes of the textures that triangles use.
std::vector<TextureSize> sizes_of_textures(const Model& model, const LoadOptions& options,
                                           Messages& messages) {
  const int side = options.side.value_or(options.assumed_side);
  std::size_t count = std::max<std::size_t>(1, model.textures.size());
  for (int t = 0; t < model.mesh.triangle_count(); ++t)
    count = std::max(count, std::size_t(model.mesh.texture(t) + 1));
  std::vector<TextureSize> sizes(count);
  bool assumed = false;
  for (std::size_t i = 0; i < count; ++i) {
    if (options.missing == MissingPictures::by_head && i < model.textures.size()) {
      sizes[i] = size_by_head(model, i);
      continue;
    }
    const bool there = i < model.textures.size() && !model.textures[i].pixels.empty();
    require(
        there || options.side || options.missing == MissingPictures::assume || options.missing == MissingPictures::overlook,
        model.slots.empty() || !model.textures.empty()
            ? fmt::format("{}: texture {} has no picture: name one after the mesh",
                          model.path.string(),
                          i < model.textures.size() ? model.textures[i].name : std::to_string(i))
            : fmt::format("{}: its materials name no picture for {}, but for {}: choose one of these "
                          "by {}, or name a picture after the mesh",
                          model.path.string(), model.slot, names_of(model.slots),
                          option_name("slot")));
    if (there)
      sizes[i] = {model.textures[i].pixels.width(), model.textures[i].pixels.height(),
                  model.tiles.empty() ? model.textures[i].wrap : Wrap::clamp};
    else
      sizes[i] = {side, side,
                  i < model.textures.size() ? model.textures[i].wrap : Wrap::unspecified};
    assumed |= !there;
  }
  if (assumed && !options.side)
    messages.remark(
        fmt::format("no picture: texels are counted as if it had {0} × {0}", side));
  return sizes;
}

/// Charts in tiles are where they belong; triangles across the border of one are not.
void look_at_tiles(TexturedModel& all) {
  if (all.model.tiles.empty()) return;
  Defects& defects = all.atlas->defects;
  std::erase_if(defects, [](const Defect& d) { return d.kind == "charts_in_other_tiles"; });
  const Mesh& mesh = all.surface.mesh;
  std::vector<std::int64_t> across;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    if (all.atlas->chart[t] < 0) continue;
    const TextureTile& tile = all.model.tiles[std::size_t(mesh.texture(t))];
    const TextureSize& size = all.texture_sizes[std::size_t(mesh.texture(t))];
    double beyond = 0;  // texels
    for (int k = 0; k < 3; ++k) {
      const Vector2 uv = mesh.uv(t, k) - Vector2(tile.u, tile.v);
      beyond = std::max({beyond, -uv.x() * size.width, (uv.x() - 1) * size.width,
                         -uv.y() * size.height, (uv.y() - 1) * size.height});
    }
    if (beyond > 1) across.push_back(t);
  }
  add_defect(defects, "triangles_across_tiles", Defect::Severity::refused, "triangle", across,
             "triangles that reach more than a texel into a neighbouring tile: cut the charts at the "
             "borders of tiles, or move them");
}

}  // namespace

Defects TexturedModel::defects() const {
  Defects all = model.defects;
  all.insert(all.end(), surface.defects.begin(), surface.defects.end());
  if (atlas) all.insert(all.end(), atlas->defects.begin(), atlas->defects.end());
  return all;
}

void require_usable(const Defects& defects, const std::string& file) {
  std::string messages;
  for (const Defect& defect : defects)
    if (defect.severity == Defect::Severity::refused)
      messages += (messages.empty() ? "" : "; ") + defect.kind + ": " + sentence(defect);
  require(messages.empty(), file + ": " + messages);
}

Model read_picture(const std::filesystem::path& path, ImageTriangles triangles,
                   const Progress& progress, NotFinite not_finite, const std::string& layer) {
  Texture picture = read_upright(path, progress, not_finite, layer);
  Model model;
  model.path = picture.path;
  model.mesh = image_rectangle(picture.pixels.width(), picture.pixels.height(), triangles);
  model.textures.push_back(std::move(picture));
  return model;
}

Model read_input(const std::filesystem::path& path, const LoadOptions& options,
                 const Progress& progress, const ModelWatch& watch) {
  // Where only the shape counts a picture is refused as no mesh.
  if (!names_picture(path) || options.missing == MissingPictures::unneeded)
    return read_model(path,
                      {.textures = options.textures,
                       .pictures = options.missing == MissingPictures::unneeded || options.missing == MissingPictures::overlook
                                       ? ReadModelOptions::Pictures::where_there
                                   : options.missing == MissingPictures::by_head ? ReadModelOptions::Pictures::skip
                                                                                 : ReadModelOptions::Pictures::read,
                       .not_finite = NotFinite::keep,
                       .slot = options.slot,
                       .uv_set = options.uv_set,
                       .layer = options.layer},
                      progress, watch);
  require(options.textures.empty(),
          fmt::format("{}: is a picture, so nothing is read after it; found '{}'", path.string(),
                      options.textures.empty() ? "" : options.textures.front().string()));
  require(options.slot.empty() && options.uv_set <= 0,
          fmt::format("{}: is a picture, so it has one set of texture coordinates and no slots; found "
                      "{}",
                      path.string(),
                      options.slot.empty()
                          ? fmt::format("{} {}", option_name("uv_set"), options.uv_set)
                          : fmt::format("{} '{}'", option_name("slot"), options.slot)));
  return read_picture(path, options.picture, progress, NotFinite::keep, options.layer);
}

TexturedModel textured_model(Model model, const LoadOptions& options, Messages& messages,
                             const Progress& progress) {
  TexturedModel all;
  all.model = std::move(model);
  all.is_picture = names_picture(all.model.path);
  if (options.side)
    for (Texture& texture : all.model.textures) texture.pixels = {};
  const std::string file = all.model.path.string();
  for (const std::string& note : all.model.notes) messages.remark(note_on(file, note));
  for (const Texture& texture : all.model.textures)
    for (const std::string& note : texture.notes) messages.remark(note);
  require(all.model.mesh.triangle_count() > 0,
          fmt::format("{}: has {} and no faces, so no surface: check that it is a mesh, not a "
                      "point cloud or curves, and not cut short",
                      file, counted(all.model.mesh.vertex_count(), "vertex")));
  about(all.model, [&] {
    all.surface = make_surface(all.model.mesh, options.weld, progress.step("weld", 0.5));
    if (!all.model.mesh.has_uvs() || options.missing == MissingPictures::unneeded) return;
    all.texture_sizes = sizes_of_textures(all.model, options, messages);
    all.atlas = make_atlas(all.surface, all.texture_sizes, options.atlas,
                           progress.step("charts", 0.5));
    look_at_tiles(all);
  });
  for (std::size_t i = 0; i < all.model.textures.size(); ++i)
    if (!all_finite(all.model.textures[i])) replace_unused_not_finite(all, i, messages);
  return all;
}

TexturedModel textured_again(Model model, const LoadOptions& options, Messages& messages, const Progress& progress) {
  model.notes.clear();
  for (Texture& texture : model.textures) texture.notes.clear();
  return textured_model(std::move(model), options, messages, progress);
}

TexturedModel load_textured_model(const std::filesystem::path& path, const LoadOptions& options,
                                  Messages& messages, const Progress& progress) {
  Model model = read_input(path, options, progress.step("read", 0.5));
  return textured_model(std::move(model), options, messages, progress.step("find charts", 0.5));
}

void about(const Model& model, const std::function<void()>& work) {
  const std::string file = model.path.string();
  const auto named = [&](const Error& error) {
    const std::string message = error.what();
    return message.find(file) == std::string::npos ? file + ": " + message : message;
  };
  try {
    work();
  } catch (const InvalidInput& error) {
    throw InvalidInput(named(error));
  } catch (const Unsupported& error) {
    throw Unsupported(named(error));
  }
}

std::string texture_file(const Model& model, std::size_t i) {
  const Texture& texture = model.textures[i];
  if (!texture.path.empty()) return texture.path.string();
  return fmt::format("{}, the embedded picture {}", model.path.string(),
                     texture.name.empty() ? std::to_string(i) : texture.name);
}

}  // namespace mq

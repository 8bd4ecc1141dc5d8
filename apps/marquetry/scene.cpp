#include "scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "mq/atlas/footprint.h"
#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/image/resample.h"
#include "mq/image/spread.h"
#include "mq/io/document.h"

namespace mq::app {
namespace {

/// exact, none, or a distance in model units.
std::optional<WeldOptions> parse_weld(const std::string& text) {
  if (text == "exact") return WeldOptions{WeldOptions::Kind::exact};
  if (text == "none") return WeldOptions{WeldOptions::Kind::none};
  double distance = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), distance);
  if (error != std::errc() || stop != text.data() + text.size() || !(distance > 0) ||
      distance > 1e60)
    return std::nullopt;
  return WeldOptions{WeldOptions::Kind::distance, distance};
}

std::vector<std::filesystem::path> texture_paths(const OptionValues& options) {
  std::vector<std::filesystem::path> paths;
  for (const std::string& name : options.texts("texture")) paths.emplace_back(name);
  return paths;
}

bool all_finite(const Texture& texture) {
  return texture.format.depth < Depth::half ||
         std::ranges::all_of(texture.pixels.values(),
                             [](float value) { return std::isfinite(value); });
}

/// 1 for the texels of a texture that charts read.
Image<char> used_texels(const Scene& scene, std::size_t texture) {
  const Image<float>& picture = scene.model.textures[texture].pixels;
  Image<char> used(picture.width(), picture.height(), 1, scene.atlas ? 0 : 1);
  if (!scene.atlas) return used;
  const Footprints footprints(*scene.atlas);
  const Wrap wrap = scene.atlas->textures[texture].wrap;
  for (int t = 0; t < int(scene.atlas->chart.size()); ++t) {
    if (scene.atlas->chart[t] < 0 ||
        scene.atlas->charts[scene.atlas->chart[t]].texture != int(texture))
      continue;
    for (const TexelSpan& span : footprints.of(t))
      for (int x = span.first; x < span.end; ++x)
        used(wrapped(x, used.width(), wrap), wrapped(span.row, used.height(), wrap)) = 1;
  }
  return used;
}

/// Bakes hold infinities and what is no number where nothing was baked. There they become the
/// values of the nearest texel of a chart; in a chart they are refused.
void replace_unused_not_finite(Run& run, Scene& scene, std::size_t texture) {
  Image<float>& picture = scene.model.textures[texture].pixels;
  const Image<char> used = used_texels(scene, texture);
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
              texture_file(scene.model, texture), x, y, picture(x, y, c), c,
              scene.atlas ? ", and a chart uses it" : ""));
        picture(x, y, c) = filled(x, y, c);
        ++replaced;
      }
  run.terminal().remark(fmt::format(
      "{}: {} values outside all charts are infinite or no numbers; those of the nearest texels of "
      "a chart stand for them",
      texture_file(scene.model, texture), replaced));
}

/// Sizes of the textures that triangles use.
std::vector<TextureSize> texture_sizes(Run& run, const Model& model, MissingPictures missing) {
  std::size_t count = std::max<std::size_t>(1, model.textures.size());
  for (int t = 0; t < model.mesh.triangle_count(); ++t)
    count = std::max(count, std::size_t(model.mesh.texture(t) + 1));
  std::vector<TextureSize> sizes(count);
  bool assumed = false;
  for (std::size_t i = 0; i < count; ++i) {
    const bool there = i < model.textures.size() && !model.textures[i].pixels.empty();
    require(
        there || missing == MissingPictures::assume,
        fmt::format("{}: texture {} has no picture: name one after the mesh", model.path.string(),
                    i < model.textures.size() ? model.textures[i].name : std::to_string(i)));
    if (there)
      sizes[i] = {model.textures[i].pixels.width(), model.textures[i].pixels.height(),
                  model.textures[i].wrap};
    else
      sizes[i] = {assumed_texture_side, assumed_texture_side};
    assumed |= !there;
  }
  if (assumed)
    run.terminal().remark(
        fmt::format("no picture: texels are counted as if it had {0} × {0}", assumed_texture_side));
  return sizes;
}

/// All that was read, and what else the options name to be read.
void register_inputs(Run& run, const Model& model) {
  will_read_model(run, model);
  for (const Option& option : run.options().table().options())
    if (option.type == Option::Type::path && option.name != "output" && option.name != "report" &&
        option.name != "cameras" && option.name != "screenshot")
      for (const std::string& name : run.options().texts(option.name)) run.will_read(name);
}

}  // namespace

void add_scene_options(OptionTable& table, const std::string& mesh_help,
                       const std::string& texture_help) {
  using Type = Option::Type;
  constexpr auto positional = Option::Place::positional;
  table.add({.name = "mesh",
             .place = positional,
             .type = Type::path,
             .required = true,
             .help = mesh_help});
  table.add({.name = "texture",
             .place = positional,
             .type = Type::path,
             .count = Option::Count::many,
             .help = texture_help});
  table.add({.name = "weld",
             .type = Type::text,
             .default_value = "exact",
             .accepts = [](const std::string& text) { return parse_weld(text).has_value(); },
             .wanted = "exact, none or a distance in model units",
             .metavar = "exact|none|DISTANCE",
             .group = "Model",
             .help = "which vertices are one point of the surface",
             .details = "Many programs write a vertex once for every chart it lies in; exact joins "
                        "those at equal positions, a distance also those nearer than that."});
  table.add({.name = "flipped",
             .type = Type::choice,
             .default_value = "few",
             .choices = {"few", "refuse", "keep"},
             .group = "Model",
             .help = "triangles turned over against the rest of their chart",
             .details = "few: kept while they cover less than a thousandth of all charts. Kept, "
                        "both layers of the fold read and write the same texels."});
}

Scene read_scene(Run& run, MissingPictures missing, double share, const ScenePictures& pictures) {
  const OptionValues& options = run.options();
  Scene scene;
  {
    const Step step(run, "read", share / 2);
    scene.model = read_model(
        options.text("mesh"),
        {.textures = pictures.value_or(texture_paths(options)), .not_finite = NotFinite::keep},
        step);
  }
  register_inputs(run, scene.model);
  const std::string file = scene.model.path.string();
  for (const std::string& note : scene.model.notes) run.terminal().remark(file + ": " + note);
  for (const Texture& texture : scene.model.textures)
    for (const std::string& note : texture.notes) run.terminal().remark(note);
  require(scene.model.mesh.triangle_count() > 0,
          fmt::format("{}: has {} and no faces, so no surface: check that it is a mesh, not a "
                      "point cloud or curves, and not cut short",
                      file, counted(scene.model.mesh.vertex_count(), "vertex")));
  const Step step(run, "find charts", share / 2);
  about(scene.model, [&] {
    scene.surface = make_surface(scene.model.mesh, *parse_weld(options.text("weld")),
                                 step.progress().step("weld", 0.5));
    if (!scene.model.mesh.has_uvs() || missing == MissingPictures::unneeded) return;
    const std::string flipped = options.text("flipped");
    scene.texture_sizes = texture_sizes(run, scene.model, missing);
    scene.atlas = make_atlas(scene.surface, scene.texture_sizes,
                             {.flipped = flipped == "keep"     ? AtlasOptions::Flipped::keep
                                         : flipped == "refuse" ? AtlasOptions::Flipped::refuse
                                                               : AtlasOptions::Flipped::few},
                             step.progress().step("charts", 0.5));
  });
  for (std::size_t i = 0; i < scene.model.textures.size(); ++i)
    if (!all_finite(scene.model.textures[i])) replace_unused_not_finite(run, scene, i);
  describe_input(run, scene);
  run.found(scene_defects(scene));
  return scene;
}

Scene read_usable_scene(Run& run, MissingPictures missing, double share,
                        const ScenePictures& pictures) {
  Scene scene = read_scene(run, missing, share, pictures);
  const Defects defects = scene_defects(scene);
  run.warn(defects);
  require_usable(defects, scene.model.path.string());
  return scene;
}

void will_read_model(Run& run, const Model& model) {
  run.will_read(model.path);
  for (const Texture& texture : model.textures)
    if (!texture.path.empty()) run.will_read(texture.path);
  if (model.document)
    for (const Part& part : model.document->parts)
      run.will_read(model.path.parent_path() / part.name);
}

void describe_input(Run& run, const Scene& scene) {
  Json files = Json::array({scene.model.path.string()});
  Json textures = Json::array();
  for (const Texture& texture : scene.model.textures) {
    if (!texture.path.empty()) files.push_back(texture.path.string());
    textures.push_back({{"name", texture.name},
                        {"width", texture.pixels.width()},
                        {"height", texture.pixels.height()},
                        {"channels", texture.pixels.channels()},
                        {"depth", depth_name(texture.format.depth)},
                        {"format", texture.format.file_format}});
  }
  run.input = {{"files", files},
               {"vertices", scene.model.mesh.vertex_count()},
               {"triangles", scene.model.mesh.triangle_count()}};
  if (scene.atlas) {
    run.input["charts"] = scene.atlas->charts.size();
    run.input["texels"] = std::int64_t(std::llround(scene.atlas->texel_area));
  }
  run.input["textures"] = textures;
  run.input["notes"] = scene.model.notes;
}

Defects scene_defects(const Scene& scene) {
  Defects all = scene.model.defects;
  all.insert(all.end(), scene.surface.defects.begin(), scene.surface.defects.end());
  if (scene.atlas) all.insert(all.end(), scene.atlas->defects.begin(), scene.atlas->defects.end());
  return all;
}

void require_usable(const Defects& defects, const std::string& file) {
  std::string messages;
  for (const Defect& defect : defects)
    if (defect.severity == Defect::Severity::refused)
      messages += (messages.empty() ? "" : "; ") + defect.kind + ": " + sentence(defect);
  require(messages.empty(), file + ": " + messages);
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

std::string depth_name(Depth depth) {
  switch (depth) {
    case Depth::u8: return "u8";
    case Depth::u16: return "u16";
    case Depth::half: return "half";
    case Depth::f32: return "float";
  }
  return "";
}

Depth depth_from_name(const std::string& name) {
  return name == "8"      ? Depth::u8
         : name == "16"   ? Depth::u16
         : name == "half" ? Depth::half
                          : Depth::f32;
}

}  // namespace mq::app

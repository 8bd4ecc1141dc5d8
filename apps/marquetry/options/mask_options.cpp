#include "options/mask_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numeric>

#include "shell/arguments.h"
#include "verbs/shared/input_pictures.h"
#include "mq/base/error.h"
#include "mq/base/length.h"
#include "mq/filter/modulation.h"
#include "mq/image/colour.h"
#include "mq/io/file_names.h"
#include "shell/results.h"

namespace mq::app {
namespace {

/// What --spot says, before the model is known.
struct AskedSpot {
  int texture = -1;  ///< of the texel at (x, y); -1: (x, y, z) is a place in space
  double x = 0, y = 0, z = 0;
  Length radius;
  double strength = 1;
};

std::vector<std::string> parts_of(const std::string& text) {
  std::vector<std::string> parts(1);
  for (const char c : text)
    if (c == ',')
      parts.emplace_back();
    else
      parts.back() += c;
  return parts;
}

/// "texel" or "texel2"; -1 for anything else.
int texture_named(const std::string& word) {
  if (word == "texel") return 0;
  int texture = -1;
  if (!word.starts_with("texel")) return -1;
  const auto [stop, error] = std::from_chars(word.data() + 5, word.data() + word.size(), texture);
  return error == std::errc() && stop == word.data() + word.size() ? texture : -1;
}

/// x,y,z,radius[,strength] or texel[K],x,y,radius[,strength].
std::optional<AskedSpot> parse_spot(const std::string& text) {
  const std::vector<std::string> parts = parts_of(text);
  if (parts.size() != 4 && parts.size() != 5) return std::nullopt;
  AskedSpot spot;
  spot.texture = texture_named(parts[0]);
  const bool in_space = spot.texture < 0;
  const auto place = parse_numbers(
      in_space ? parts[0] + "," + parts[1] + "," + parts[2] : parts[1] + "," + parts[2] + ",0", 3);
  const auto strength = parse_numbers(parts.size() == 5 ? parts[4] : "1", 1);
  if (!place || !strength || !(std::abs(strength->front()) <= 1)) return std::nullopt;
  spot.x = (*place)[0], spot.y = (*place)[1], spot.z = (*place)[2];
  spot.strength = strength->front();
  try {
    spot.radius = parse_length(parts[3]);
  } catch (const InvalidInput&) {
    return std::nullopt;
  }
  if (!(spot.radius.value > 0)) return std::nullopt;
  return spot;
}

/// The model whose colours at vertices are the mask.
Model colours_of_mask(const std::string& file) {
  ReadModelOptions skipping;
  skipping.pictures = ReadModelOptions::Pictures::skip;
  Model model = read_model(file, skipping);
  require(model.colors.channels > 0,
          file + ": --mask: has no colours at its vertices to be the mask");
  return model;
}

std::vector<double> vertex_mask(const std::string& file, const ModelSignal& target,
                                const Progress& progress) {
  const Model model = colours_of_mask(file);
  const VertexSignal& colors = model.colors;
  const int colours = colour_channels(colors.channels);
  std::vector<double> values;
  for (int v = 0; v < model.mesh.vertex_count(); ++v) {
    const auto first = colors.values.begin() + std::ptrdiff_t(v) * colors.channels;
    values.push_back(std::accumulate(first, first + colours, 0.0) / colours);
  }
  std::vector<double> mask;
  about(model,
        [&] { mask = mask_of_vertices(model.mesh, values, target.space().positions(), -1, progress); });
  return mask;
}

std::vector<double> picture_mask(Run& run, const std::vector<std::string>& files,
                                 const TexturedModel& scene, const ModelSignal& target) {
  require(target.texel_space() != nullptr,
          files.front() +
                      ": --mask: colours at vertices have no texels; give a model with "
                      "the mask as colours at its vertices");
  std::vector<Image<float>> pictures;
  for (std::size_t i = 0; i < files.size(); ++i) {
    MaskPicture mask = read_mask(files[i], scene.texture_sizes[i]);
    for (const std::string& remark : mask.remarks) run.terminal().remark(remark);
    pictures.push_back(std::move(mask.pixels));
  }
  return mask_of_pictures(target.texel_space()->texels(), scene.texture_sizes, pictures, -1);
}

}  // namespace

void add_mask_options(OptionTable& table, const std::string& group) {
  using Type = Option::Type;
  table.add({.name = "mask",
             .type = Type::path,
             .count = Option::Count::many,
             .group = group,
             .help = "how strongly it works where: a picture per texture, or a model",
             .details =
                 "Black changes nothing, white has the full effect; below black, down to -1 in "
                 "floating point (EXR, TIFF), it smooths, whatever beta is. Pictures are painted in the "
                 "texture's coordinates, of any size, one for each texture in their order; colours "
                 "count by the mean of their channels. Of a model (OBJ, PLY, ...) the colours at "
                 "its vertices count, at the closest point of it."});
  table.add({.name = "spot",
             .type = Type::text,
             .count = Option::Count::many,
             .accepts = [](const std::string& text) { return parse_spot(text).has_value(); },
             .wanted = "x,y,z,radius or texel,x,y,radius, and perhaps ,strength from -1 to 1",
             .metavar = "PLACE,RADIUS",
             .group = group,
             .help = "work within a round spot: x,y,z,radius[,strength]",
             .details =
                 "strength (1 - (d/radius)^2)^2 at distance d in space is added to the mask, or to "
                 "nothing. A strength below 0, down to -1, takes away. The place may also be a "
                 "texel: texel,column,row,radius, or texel2,... in the texture of number 2 (from "
                 "0). The radius is a length as --length."});
}

void check_mask(Run& run, const TexturedModel& scene) {
  const std::vector<std::string> files = run.options().texts("mask");
  if (files.empty() || !names_model(files.front()))
    return check_pictures(run.options(), scene, {"mask"});
  require(files.size() == 1, "--mask: one model is enough; found " + std::to_string(files.size()));
  if (run.dry_run()) colours_of_mask(files.front());
}

std::optional<std::vector<double>> asked_mask(Run& run, const TexturedModel& scene, const ModelSignal& target,
                                              const Progress& progress) {
  const OptionValues& options = run.options();
  const std::vector<std::string> files = options.texts("mask");
  if (files.empty() && options.texts("spot").empty()) return std::nullopt;
  std::vector<double> mask(std::size_t(target.space().size()), 0.0);
  if (!files.empty() && names_model(files.front())) {
    mask = vertex_mask(files.front(), target, progress);
  } else if (!files.empty()) {
    mask = picture_mask(run, files, scene, target);
  }
  const std::vector<Vector3> positions = target.space().positions();
  const auto place_of_texel = [&](const Texels::Place& texel) -> std::optional<Vector3> {
    require(target.texel_space() != nullptr, "--spot texel: colours at vertices have no texels; give a place in space");
    const auto unknowns = target.unknowns_at(texel);
    if (unknowns.empty()) return {};
    return target.texel_space()->texels().position(*unknowns.begin());
  };
  for (const Spot& spot : asked_spots(options, scene, target.space().scale(), place_of_texel))
    if (add_spots(std::array{spot}, positions, mask) == 0) run.terminal().warning(spot_without_effect(spot, scene));
  const double count = double(std::max<std::size_t>(1, mask.size()));
  run.result["mask"] = mask_json(std::accumulate(mask.begin(), mask.end(), 0.0) / count,
                                 double(std::ranges::count_if(mask, [](double m) { return m != 0; })) / count,
                                 double(std::ranges::count_if(mask, [](double m) { return m < 0; })) / count);
  return mask;
}

MaskPicture read_mask(const std::string& file, const TextureSize& size) {
  MaskPicture mask{.pixels = read_texture(file).pixels, .remarks = {}};
  const Image<float>& picture = mask.pixels;
  const int colours = colour_channels(picture.channels());
  std::int64_t beyond = 0;
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x)
      beyond += std::ranges::any_of(picture.pixel(x, y).first(std::size_t(colours)),
                                    [](float v) { return v < -1 || v > 1; });
  if (beyond > 0)
    mask.remarks.push_back(fmt::format("{}: {} of its {} pixels have values beyond -1 to 1, which count as -1 and 1",
                                       file, beyond, picture.pixel_count()));
  if (picture.width() != size.width || picture.height() != size.height)
    mask.remarks.push_back(fmt::format("{}: is {} × {}, taken between its pixels for {} × {}", file, picture.width(),
                                       picture.height(), size.width, size.height));
  return mask;
}

std::vector<Spot> asked_spots(const OptionValues& options, const TexturedModel& scene, const SurfaceScale& scale,
                              const PlaceOfTexel& place_of_texel) {
  std::vector<Spot> spots;
  for (const std::string& text : options.texts("spot")) {
    const AskedSpot asked = *parse_spot(text);
    require(asked.radius.unit != Length::Unit::texels || scale.texel_spacing > 0,
            "--spot " + text +
                ": colours at vertices have no texels; give the radius in model "
                "units, such as 0.1, or as 1%");
    std::optional<Vector3> centre = Vector3(asked.x, asked.y, asked.z);
    if (asked.texture >= 0) {
      const Texels::Place texel{asked.texture, int(asked.x), int(asked.y)};
      const bool is_whole = texel.x == asked.x && texel.y == asked.y;
      centre = place_of_texel(texel);
      require(is_whole && centre.has_value(),
              fmt::format("--spot texel{},{},{}: no chart of {} uses such a texel (x counts columns from the left, y "
                          "rows from the top, both from 0)",
                          asked.texture, asked.x, asked.y, scene.model.path.string()));
    }
    spots.push_back({.center = *centre,
                     .radius = std::sqrt(weight_from_length(asked.radius, scale)),
                     .strength = asked.strength});
  }
  return spots;
}

std::string spot_without_effect(const Spot& spot, const TexturedModel& scene) {
  return fmt::format("--spot at {:.4g}, {:.4g}, {:.4g} changes nothing: no part of {} is within {:.4g} of it, or the "
                     "mask is full there",
                     spot.center.x(), spot.center.y(), spot.center.z(), scene.model.path.string(), spot.radius);
}

Json mask_json(double mean, double share, double below) {
  return {{"mean", mean}, {"share", share}, {"below_0", below}};
}

}  // namespace mq::app

#include "verbs/shared/geometry.h"

#include <fmt/format.h>

#include <cmath>

#include "mq/base/error.h"
#include "mq/filter/normal_fit.h"
#include "mq/model/moved_vertices.h"
#include "options/signal_options.h"
#include "shell/arguments.h"

namespace mq::app {
namespace {

Json measure_json(const BeforeAfter& measure) {
  Json json = {{"before", measure.before}, {"after", measure.after}};
  const std::optional<double> change = measure.change();
  json["change"] = change ? Json(*change) : Json();
  return json;
}

std::string measure_text(const std::string& name, const BeforeAfter& measure) {
  return fmt::format("{} {:.6g} -> {:.6g} ({:+.2f} %)", name, measure.before, measure.after,
                     100 * measure.change().value_or(0));
}

/// Area or volume changed by more than this share are warned of.
constexpr double remarkable = 0.1;

/// Says and reports what changed in size by more than that.
void warn_of_size(Run& run, const ShapeChange& change, const std::string& advice) {
  Json warnings = Json::array();
  const auto look = [&](const char* name, const BeforeAfter& measure) {
    const std::optional<double> share = measure.change();
    if (!share || std::abs(*share) <= remarkable) return;
    warnings.push_back(fmt::format("the {} changed by {:+.1f} %, more than {:.0f} %: {}", name,
                                   100 * *share, 100 * remarkable, advice));
    run.terminal().warning(warnings.back().get<std::string>());
  };
  look("area", change.area);
  if (change.volume) look("volume", *change.volume);
  run.result["warnings"] = std::move(warnings);
}

/// How far vertices moved, area and, of closed surfaces, volume.
void report_change(Run& run, std::size_t vertices, const ShapeChange& change) {
  run.result["vertices"] = vertices;
  run.result["rms_moved"] = change.rms_moved;
  run.result["largest_moved"] = change.largest_moved;
  run.result["area"] = measure_json(change.area);
  run.result["volume"] = change.volume ? measure_json(*change.volume) : Json();
  run.print(measure_text("area", change.area) +
            (change.volume ? ", " + measure_text("volume", *change.volume) : "") + "\n");
}

}  // namespace

void refuse_pictures_of_shape(const OptionValues& options) {
  const std::vector<std::string> pictures = options.texts("texture");
  require(pictures.empty(),
          fmt::format("{}: --geometry changes its shape, and '{}' would not be looked at: leave it out",
                      options.text("mesh"), pictures.empty() ? "" : pictures.front()));
}

TexturedModel read_shape(Run& run, double share) {
  for (const char* name : {"flipped", "slot", "uv-set", "layer"})
    require(!asks_for(run.options(), name),
            fmt::format("--{} is for charts of textures, and --geometry looks at none: leave it out",
                        name));
  return read_usable_model(run, MissingPictures::unneeded, share);
}

Outputs shape_outputs(const OptionValues& options, const TexturedModel& scene) {
  return Outputs(options.text("output"), scene.model, Outputs::Kind::model);
}

void add_fit_options(OptionTable& table, const std::string& group) {
  using Type = Option::Type;
  table.add({.name = "fit-weight",
             .type = Type::number,
             .default_value = as_typed(NormalFit::default_alpha),
             .least = 0,
             .most = 1e8,
             .group = group,
             .help = "how strongly vertices follow normals, on the surface scaled to unit area",
             .details = "Less keeps them nearer to where they were, except for detail."});
  table.add({.name = "fit-steps",
             .type = Type::integer,
             .default_value = "1",
             .least = 1,
             .most = 1000,
             .group = group,
             .help = "fits one after the other, each nearer to the normals"});
}

void put_positions(Run& run, TexturedModel& scene, const std::vector<Vector3>& positions,
                   const std::string& advice) {
  const ShapeChange change = shape_change(scene.surface, positions);
  report_change(run, positions.size(), change);
  warn_of_size(run, change, advice);
  if (move_vertices(positions, scene))
    run.terminal().remark(fmt::format(
        "{}: says normals: they are turned as the surface is, and the file is made anew, "
        "without comments, skins or animations",
        scene.model.path.string()));
}

}  // namespace mq::app

#include "verbs/shared/geometry.h"

#include <fmt/format.h>

#include <cmath>

#include "mq/base/error.h"
#include "mq/filter/geometry_shock.h"
#include "mq/model/model_shape.h"
#include "options/signal_options.h"
#include "shell/arguments.h"

namespace mq::app {
namespace {

Json change_json(const ShapeChange::Size& size) {
  Json json = {{"before", size.before}, {"after", size.after}};
  json["change"] = size.share() ? Json(*size.share()) : Json();
  return json;
}

std::string change_text(const std::string& name, const ShapeChange::Size& size) {
  return fmt::format("{} {:.6g} -> {:.6g} ({:+.2f} %)", name, size.before, size.after,
                     100 * size.share().value_or(0));
}

/// Area or volume changed by more than this share are warned of.
constexpr double remarkable = 0.1;

/// Says and reports what changed in size by more than that.
void warn_of_size(Run& run, const std::string& advice) {
  Json warnings = Json::array();
  for (const char* name : {"area", "volume"}) {
    const Json& json = run.result[name];
    if (!json.is_object() || !json["change"].is_number()) continue;
    const double change = json["change"];
    if (std::abs(change) <= remarkable) continue;
    warnings.push_back(fmt::format("the {} changed by {:+.1f} %, more than {:.0f} %: {}", name,
                                   100 * change, 100 * remarkable, advice));
    run.terminal().warning(warnings.back().get<std::string>());
  }
  run.result["warnings"] = std::move(warnings);
}

/// Area and, of closed surfaces, volume.
void report_change(Run& run, const ShapeChange& change, std::size_t vertices) {
  run.result["vertices"] = vertices;
  run.result["rms_moved"] = change.rms_moved;
  run.result["largest_moved"] = change.largest_moved;
  run.result["area"] = change_json(change.area);
  std::string text = change_text("area", change.area);
  run.result["volume"] = nullptr;
  if (change.volume) {
    run.result["volume"] = change_json(*change.volume);
    text += ", " + change_text("volume", *change.volume);
  }
  run.print(text + "\n");
}

}  // namespace

void refuse_pictures_of_shape(const OptionValues& options) {
  const std::vector<std::string> pictures = options.texts("texture");
  require(pictures.empty(),
          fmt::format("{}: --geometry changes its shape, and '{}' would not be looked at: leave it out",
                      options.text("mesh"), pictures.empty() ? "" : pictures.front()));
}

TexturedModel read_shape(Run& run, double share) {
  require(!asks_for(run.options(), "flipped"),
          "--flipped is for charts of textures, and --geometry looks at none: leave it out");
  return read_usable_model(run, MissingPictures::unneeded, share);
}

Outputs shape_outputs(const OptionValues& options, const TexturedModel& scene) {
  return Outputs(options.text("output"), scene.model, Outputs::Kind::model);
}

void add_fit_options(OptionTable& table, const std::string& group) {
  using Type = Option::Type;
  table.add({.name = "fit-weight",
             .type = Type::number,
             .default_value = as_typed(GeometryShockOptions{}.fit_alpha),
             .least = 0,
             .most = 1e8,
             .group = group,
             .help = "how strongly vertices follow normals, on the surface scaled to unit area",
             .details = "Less keeps them nearer to where they were, except for detail."});
  table.add({.name = "fit-steps",
             .type = Type::integer,
             .default_value = as_typed(GeometryShockOptions{}.fit_steps),
             .least = 1,
             .most = 1000,
             .group = group,
             .help = "fits one after the other, each nearer to the normals"});
}

SolveReport worst_of(const std::vector<SolveReport>& reports) {
  for (const SolveReport& report : reports)
    if (!report.converged) return report;
  return reports.empty() ? SolveReport{} : reports.back();
}

void put_positions(Run& run, TexturedModel& scene, const std::vector<Vector3>& positions,
                   const std::string& advice) {
  report_change(run, shape_change(scene.surface, positions), positions.size());
  warn_of_size(run, advice);
  if (mq::put_positions(positions, scene) == StoredNormals::left_out)
    run.terminal().remark(
        fmt::format("{}: says normals, which are those of the shape as it was: they are left out, "
                    "and the file is made anew, without comments, skins or animations",
                    scene.model.path.string()));
}

}  // namespace mq::app

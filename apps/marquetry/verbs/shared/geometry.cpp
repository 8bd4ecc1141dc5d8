#include "verbs/shared/geometry.h"

#include <fmt/format.h>

#include <cmath>

#include "mq/base/error.h"
#include "mq/io/normals.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/volume.h"
#include "options/signal_options.h"

namespace mq::app {
namespace {

Json change_json(double before, double after) {
  Json json = {{"before", before}, {"after", after}};
  json["change"] = before != 0 ? Json(after / before - 1) : Json();
  return json;
}

std::string change_text(const std::string& name, double before, double after) {
  return fmt::format("{} {:.6g} -> {:.6g} ({:+.2f} %)", name, before, after,
                     before != 0 ? 100 * (after / before - 1) : 0);
}

double total_area(const Mesh& mesh) {
  double sum = 0;
  for (const double area : triangle_areas(mesh)) sum += area;
  return sum;
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
void report_change(Run& run, const Surface& surface, const Mesh& after) {
  double sum = 0, largest = 0;
  for (std::size_t v = 0; v < after.positions.size(); ++v) {
    const double moved = (after.positions[v] - surface.mesh.positions[v]).squaredNorm();
    sum += moved;
    largest = std::max(largest, moved);
  }
  run.result["vertices"] = after.positions.size();
  run.result["rms_moved"] = std::sqrt(sum / std::max(1.0, double(after.positions.size())));
  run.result["largest_moved"] = std::sqrt(largest);
  const double area = total_area(surface.mesh), area_after = total_area(after);
  run.result["area"] = change_json(area, area_after);
  std::string text = change_text("area", area, area_after);
  run.result["volume"] = nullptr;
  if (surface.boundary_edges == 0) {
    const double volume = enclosed_volume(surface.mesh), volume_after = enclosed_volume(after);
    run.result["volume"] = change_json(volume, volume_after);
    text += ", " + change_text("volume", volume, volume_after);
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
             .default_value = "100",
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

SolveReport worst_of(const std::vector<SolveReport>& reports) {
  for (const SolveReport& report : reports)
    if (!report.converged) return report;
  return reports.empty() ? SolveReport{} : reports.back();
}

void put_positions(Run& run, TexturedModel& scene, const std::vector<Vector3>& positions,
                   const std::string& advice) {
  Mesh after = scene.surface.mesh;
  after.positions = positions;
  report_change(run, scene.surface, after);
  warn_of_size(run, advice);
  bool moved = false;
  Mesh& mesh = scene.model.mesh;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const int here = scene.surface.vertex_from_source[v];
    // Welded copies move alike, each from where it was.
    if (here < 0 || positions[std::size_t(here)] == scene.surface.mesh.positions[std::size_t(here)])
      continue;
    moved = true;
    mesh.positions[v] +=
        positions[std::size_t(here)] - scene.surface.mesh.positions[std::size_t(here)];
  }
  if (moved && leave_out_normals(scene.model))
    run.terminal().remark(
        fmt::format("{}: says normals, which are those of the shape as it was: they are left out, "
                    "and the file is made anew, without comments, skins or animations",
                    scene.model.path.string()));
}

}  // namespace mq::app

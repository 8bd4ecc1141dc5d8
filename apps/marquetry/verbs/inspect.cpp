// marquetry inspect MESH [TEXTURE...]: what a model is, in numbers.
//
// Stretch is that of the texture on the surface: per triangle the ratio of the singular values of
// the map from texels to the surface, 1 where texels are square. Percentiles weigh triangles by
// their area on the surface.
#include <fmt/format.h>

#include <algorithm>

#include "mq/base/words.h"
#include "mq/mesh/geometry.h"
#include "shell/percentiles.h"
#include "shell/run.h"
#include "options/model_options.h"
#include "shell/verb.h"
#include "verbs/shared/slots_report.h"

namespace mq::app {
namespace {

Json vector_json(const Vector3& v) { return {v.x(), v.y(), v.z()}; }

Json surface_json(const TexturedModel& scene) {
  const Box box = bounding_box(scene.surface.mesh);
  return {{"area", scene.surface.area},
          {"box", {{"low", vector_json(box.low)}, {"high", vector_json(box.high)}}},
          {"vertices", scene.surface.mesh.vertex_count()},
          {"components", scene.surface.components},
          {"boundary_edges", scene.surface.boundary_edges},
          {"euler_characteristic", scene.surface.euler_characteristic},
          {"mean_edge_length", mean_edge_length(scene.surface)},
          {"color_channels", scene.model.colors.channels}};
}

/// Percentiles of stretch and of the texel's side on the surface.
Json stretch_json(const TexturedModel& scene) {
  std::vector<Weighted> stretch, side;
  for (int t = 0; t < scene.surface.triangle_count(); ++t) {
    if (scene.atlas->chart[t] < 0) continue;
    const TexelMetric metric = texel_metric(scene.surface, *scene.atlas, t);
    const double area = triangle_area(scene.surface.mesh, t);
    stretch.push_back({metric.stretch, area});
    side.push_back({std::sqrt(metric.density), area});
  }
  return {{"stretch", percentiles_json(stretch)}, {"texel_side", percentiles_json(side)}};
}

Json atlas_json(const TexturedModel& scene) {
  const Atlas& atlas = *scene.atlas;
  double pixels = 0;
  for (const TextureSize& size : scene.texture_sizes) pixels += double(size.width) * size.height;
  const auto mirrored = std::ranges::count_if(atlas.charts, &Chart::mirrored);
  Json json = {{"charts", atlas.charts.size()},        {"mirrored_charts", mirrored},
               {"seam_edges", atlas.seam_count},       {"texel_area", atlas.texel_area},
               {"covered", atlas.texel_area / pixels}, {"texel_spacing", atlas.texel_spacing()}};
  json.update(stretch_json(scene));
  return json;
}

std::string row(const std::string& name, const std::string& value) {
  return fmt::format("  {:<18}{}\n", name, value);
}

std::string surface_text(const TexturedModel& scene) {
  const Surface& surface = scene.surface;
  const Box box = bounding_box(surface.mesh);
  const Vector3 size = box.high - box.low;
  std::string text = scene.model.path.string() + "\n";
  text +=
      row("vertices", fmt::format("{} ({} as points of the surface)",
                                  scene.model.mesh.vertex_count(), surface.mesh.vertex_count()));
  text += row("triangles", std::to_string(surface.triangle_count()));
  text += row("area", fmt::format("{:.6g}", surface.area));
  text +=
      row("box", fmt::format("{:.6g} × {:.6g} × {:.6g}, from ({:.6g}, {:.6g}, {:.6g})", size.x(),
                             size.y(), size.z(), box.low.x(), box.low.y(), box.low.z()));
  text += row("topology", fmt::format("components {}, boundary edges {}, Euler characteristic {}",
                                      surface.components, surface.boundary_edges,
                                      surface.euler_characteristic));
  if (scene.model.colors.channels > 0)
    text +=
        row("vertex colours", fmt::format("{}, {}", counted(scene.model.colors.channels, "channel"),
                                          depth_name(scene.model.colors.depth)));
  return text;
}

std::string atlas_text(const TexturedModel& scene, const Json& atlas) {
  std::string text;
  text += row("charts", fmt::format("{} ({} mirrored)", atlas["charts"].get<int>(),
                                    atlas["mirrored_charts"].get<int>()));
  text += row("seams", counted(atlas["seam_edges"].get<int>(), "edge"));
  text += row("texels",
              fmt::format("{:.0f} inside charts, {:.1f} % of the textures",
                          atlas["texel_area"].get<double>(), 100 * atlas["covered"].get<double>()));
  text += row("stretch", percentiles_text(atlas["stretch"]));
  text += row("texel side", percentiles_text(atlas["texel_side"]));
  for (const Texture& texture : scene.model.textures) {
    text += row("texture",
                fmt::format("{}: {} × {}, {}, {} {}", texture.name, texture.pixels.width(),
                            texture.pixels.height(), counted(texture.pixels.channels(), "channel"),
                            texture.format.file_format, depth_name(texture.format.depth)));
    if (const auto& layers = texture.format.layers)
      text += row("layers", fmt::format("{}; processed: {}", fmt::join(layers->names, ", "),
                                        layers->names[layers->chosen]));
  }
  return text;
}

/// What the verb check has beyond the rows of defects: notes, and what takes cutting texels to see.
std::string more_text(const TexturedModel& scene, const Defects& defects) {
  const auto notes = std::ranges::count(defects, Defect::Severity::note, &Defect::severity);
  std::string more = notes > 0 ? counted(notes, "note") : "";
  if (scene.atlas && !refused(defects))
    more += (more.empty() ? "" : ", and ") + std::string("overlaps and shared texels, which are not looked for here");
  if (more.empty() && defects.empty()) return "";
  const std::string check = fmt::format("'marquetry check {}'", scene.model.path.string());
  if (more.empty()) return row("more", check + " says what is done about them");
  return row("not listed", fmt::format("{}: {} lists all", more, check));
}

std::string defects_text(const Defects& defects) {
  std::string text;
  for (const Defect& defect : defects)
    if (defect.severity != Defect::Severity::note)
      text +=
          row("defect", fmt::format("{}: {}", defect.kind, counted(defect.count, defect.element)));
  return text;
}

Exit inspect(Run& run) {
  const TexturedModel scene = read_textured_model(run, MissingPictures::overlook, 0.9);
  const Step step(run, "measure", 0.1);
  run.result["surface"] = surface_json(scene);
  std::string text = surface_text(scene);
  if (scene.atlas) {
    run.result["atlas"] = atlas_json(scene);
    text += atlas_text(scene, run.result["atlas"]);
  } else {
    text += row("texture", "none: the mesh has no texture coordinates");
  }
  run.result.update(slots_json(scene.model));
  run.result["normals"] = normals_json(scene);
  for (const auto& [name, value] : slots_rows(scene.model)) text += row(name, value);
  for (const auto& [name, value] : normals_rows(run.result["normals"])) text += row(name, value);
  const Defects defects = scene.defects();
  run.print(text + defects_text(defects) + more_text(scene, defects));
  return Exit::done;
}

}  // namespace

Verb inspect_verb() {
  OptionTable table("inspect", "Say what a model is: counts, charts, seams, stretch, textures.");
  table.example("scan.glb", "what a model is");
  table.example("scan.glb --json", "the same for programs");
  add_model_options(table);
  add_frames_option(table);
  return {table, inspect};
}

}  // namespace mq::app

// marquetry check MESH [TEXTURE...]: every defect of a model, and whether it can be processed.
#include <fmt/format.h>

#include <algorithm>

#include "mq/atlas/overlap_depth.h"
#include "mq/base/words.h"
#include "mq/fem/texel_space.h"
#include "shell/run.h"
#include "options/model_options.h"
#include "shell/verb.h"
#include "verbs/shared/slots_report.h"

namespace mq::app {
namespace {

const char* heading(Defect::Severity severity) {
  switch (severity) {
    case Defect::Severity::note: return "note";
    case Defect::Severity::warning: return "warning";
    case Defect::Severity::refused: return "refused";
  }
  return "";
}

/// " (ids 0, 2, 5)", or where texels are.
std::string which(const Defect& defect, const std::vector<std::string>& textures) {
  const std::string places = places_text(defect.places, defect.place_count, textures, 5);
  if (!places.empty()) return " " + places;
  const std::string ids = ids_text(defect, 8);
  return ids.empty() ? "" : " (" + ids + ")";
}

/// "  warning  mirrored_charts: 3 charts (ids 0, 2, 5)" and the message below.
std::string entry(const Defect& defect, const std::vector<std::string>& textures) {
  constexpr int column = 11, width = 101;
  const std::string found =
      fmt::format("{}: {}{}", defect.kind, counted(defect.count, defect.element), which(defect, textures));
  return fmt::format("  {:<9}{}\n           {}\n", heading(defect.severity), wrap_text(found, width, column),
                     wrap_text(defect.message, 90, column));
}

/// What only shows when the texels are cut to cells. An atlas of which nothing is left is a defect.
Defects texel_defects(const TexturedModel& scene, const Progress& progress) {
  if (scene.atlas->charts.empty())
    return {{.kind = "nothing_textured",
             .severity = Defect::Severity::refused,
             .element = "triangle",
             .count = scene.surface.triangle_count(),
             .ids = {},
             .message = "no triangle has an area both on the surface and in a texture"}};
  if (Defects deep = deep_overlaps(scene.surface, *scene.atlas); !deep.empty()) return deep;
  return TexelSpace(scene.surface, *scene.atlas, {}, progress).defects();
}

Exit check(Run& run) {
  const TexturedModel scene = read_textured_model(run, MissingPictures::assume, 0.6);
  Defects defects = scene.defects();
  if (scene.atlas && !refused(defects)) {
    const Step step(run, "look at texels", 0.4);
    Defects more;
    about(scene.model, [&] { more = texel_defects(scene, step); });
    run.found(more);
    defects.insert(defects.end(), more.begin(), more.end());
  }
  std::ranges::stable_sort(defects, std::ranges::greater{}, &Defect::severity);

  const auto serious = std::ranges::count_if(
      defects, [](const Defect& defect) { return defect.severity != Defect::Severity::note; });
  std::string text = scene.model.path.string() + "\n";
  const std::vector<std::string> names = run.texture_names();
  for (const Defect& defect : defects) text += entry(defect, names);
  if (!scene.atlas) text += "  note     the mesh has no texture coordinates\n";
  for (const auto& [name, value] : slots_rows(scene.model))
    text += fmt::format("  note     {}: {}\n", name, value);
  const Json normals = normals_json(scene);
  for (const auto& [name, value] : normals_rows(normals))
    text += fmt::format("  note     {}: {}\n", name, value);
  text += refused(defects) ? "  cannot be filtered as it is\n"
          : serious > 0    ? "  can be filtered; the warnings say what is done about each\n"
                           : "  nothing to complain of\n";
  run.print(text);
  run.result = {{"usable", !refused(defects)}, {"defects", serious}};
  run.result.update(slots_json(scene.model));
  run.result["normals"] = normals;
  return serious > 0 ? Exit::defects : Exit::done;
}

}  // namespace

Verb check_verb() {
  OptionTable table("check", "List every defect of a model; exit status 1 if there are any.");
  table.example("scan.obj", "what is wrong with a model, and what would be done about it");
  add_model_options(table);
  add_frames_option(table);
  return {table, check};
}

}  // namespace mq::app

#include "verbs/shared/baking.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <utility>

#include "mq/base/words.h"
#include "mq/io/file_names.h"
#include "mq/io/slots.h"
#include "mq/model/joined_slots.h"
#include "options/signal_options.h"
#include "options/solver_options.h"
#include "shell/results.h"
#include "verbs/shared/seam_report.h"

namespace mq::app {
namespace {

void report_bake(Run& run, const BakedSignal& baked) {
  const bool is_mean = baked.kind == BakedSignal::Kind::mean;
  run.result["unknowns"] = baked.values.rows();
  run.result["channels"] = baked.values.cols();
  run.result["samples"] = baked.samples;
  run.result["points"] = baked.points;
  run.result["on_same_triangles"] = baked.same;
  run.result["unseen"] = baked.unseen;
  run.result["accuracy"] = baked.accuracy;
  run.result["values"] = is_mean ? "means" : "fitted";
  run.solve = solve_json(baked.fit);
  const double unseen =
      100.0 * double(baked.unseen) / double(std::max<Eigen::Index>(1, baked.values.rows()));
  run.print(fmt::format(
      "{} of {}, {} × {} samples for each{}\n", is_mean ? "means" : "the best fit",
      counted(baked.values.rows(), "unknown"), baked.samples, baked.samples,
      baked.unseen == 0 ? ""
                        : fmt::format("; {:.2f} % lie on nothing of the source that has a picture, "
                                      "and were filled over the surface",
                                      unseen)));
  constexpr double many = 5;
  if (unseen > many)
    run.terminal().warning(fmt::format(
        "{:.1f} % of the target lie on nothing of the source that has a picture: --within "
        "and --angle say how far off and how turned it may be",
        unseen));
  if (!baked.normals) return;
  const auto frames = [](const auto& of) { return of ? of->source() : "none: in object space"; };
  run.result["frames"] = {{"source", frames(baked.normals->source)},
                          {"target", frames(baked.normals->target)}};
}

}  // namespace

std::vector<std::string> slots_to_bake(const OptionValues& options, const Model& source) {
  const std::string output = options.text("output");
  if (source.slots.empty()) return {};
  const auto base_first = [](std::vector<std::string> slots) {
    std::ranges::stable_partition(slots, [](const std::string& slot) { return slot == base_slot; });
    return slots;
  };
  if (options.has("slot")) return base_first(slots_asked_for(source, options.text("slot")));
  if (names_picture(output) || std::filesystem::path(output).extension() == ".ply")
    return {source.slot.empty() ? source.slots.front().name : source.slot};
  return base_first(slots_asked_for(source, "all"));
}

namespace {

/// One slot onto the target, whose textures it replaces.
void bake_one(Run& run, const TexturedModel& source, TexturedModel& target,
              const ModelSignal& signal, const BakeOptions& options, double share) {
  BakedSignal baked;
  {
    const Step step(run, "bake", share);
    baked = bake(source, target, signal, options, run.terminal(), step);
  }
  report_bake(run, baked);
  put_baked(baked, signal, options.values, target);
  if (!signal.texel_space()) return;
  const bool is_painted = target.model.colors.channels > 0 && !target.model.document;
  const bool of_pictures = options.shown == BakeOptions::Shown::pictures;
  if (source.model.textures.empty() && is_painted && of_pictures && options.to_tangent_space)
    leave_out_colours(target.model, run.terminal());
  const BakedNormals normals = baked.normals ? *baked.normals : BakedNormals();
  const bool has_seams = source.atlas && options.shown == BakeOptions::Shown::pictures;
  run.result["seams"] = {{"source", has_seams ? seams_json(source, normals.source.get()) : Json()},
                         {"target", seams_json(target, normals.target.get())}};
}

}  // namespace

NormalAxes asked_axes(const OptionValues& options) {
  const bool has_option = std::ranges::any_of(options.table().options(), [](const Option& option) {
    return option.name == "normal-space";
  });
  return has_option ? normal_axes(options) : NormalAxes::as_found;
}

void bake_onto(Run& run, const std::vector<std::string>& slots, const SourceOfSlot& source,
               TexturedModel& target, BakeTo to, BakeOptions options, double share) {
  options.to_tangent_space = names_gltf(run.options().text("output"));
  if (!holds_numbers(run.options().text("output"))) options.float_colours = BakeOptions::FloatColours::displayed;
  std::unique_ptr<ModelSignal> signal;
  about(target.model, [&] {
    const Step step(run, "assemble", 0.3 * share);
    if (to == BakeTo::vertices)
      signal = std::make_unique<VertexColourSignal>(target);
    else
      signal = make_texture_signal(run, target, baking_options(target, options.values), step);
  });
  if (slots.size() < 2)
    return bake_one(run, source(slots.empty() ? "" : slots.front()), target, *signal, options,
                    0.7 * share);
  require(to == BakeTo::textures, "--vertices: holds the colours of one slot; found several");
  const std::vector<Texture> blank = target.model.textures;
  const Json before = run.result;
  Json reports = Json::array();
  std::vector<std::vector<Texture>> baked;
  for (const std::string& slot : slots) {
    run.print(slot + ": ");
    target.model.textures = blank;
    for (Texture& texture : target.model.textures) texture.meaning = meaning_of_slot(slot);
    run.result = before;
    bake_one(run, source(slot), target, *signal, options, 0.7 * share / double(slots.size()));
    reports.push_back(run.result);
    reports.back()["slot"] = slot;
    baked.push_back(std::move(target.model.textures));
  }
  target.model.textures = blank;
  for (std::size_t i = 0; i < slots.size(); ++i)
    put_slot(slots[i], std::move(baked[i]), target.model);
  run.result = reports.front();
  run.result["slots"] = std::move(reports);
}

Outputs unwrapped_outputs(const OptionValues& options, const Model& model,
                          const std::vector<std::string>& slots,
                          const std::vector<SharedSlot>& shared) {
  Model planned;
  planned.path = model.path;
  planned.mesh.positions = {Vector3::Zero(), Vector3::UnitX(), Vector3::UnitY()};
  planned.mesh.triangles = {{0, 1, 2}};
  planned.mesh.uvs = {{0, 0}, {1, 0}, {0, 1}};
  planned.mesh.corner_uvs = planned.mesh.triangles;
  if (slots.size() > 1 || !shared.empty()) {
    begin_slots(slots, 1, planned);
    share_slots(shared, planned);
  }
  return Outputs(options.text("output"), planned, Outputs::Kind::pictures);
}

void bake_unwrapped(Run& run, const std::vector<std::string>& slots, const std::vector<SharedSlot>& shared,
                    const SourceOfSlot& source, const LoadOptions& load, TexturedModel& scene, double share) {
  TexturedModel target = textured_again(std::move(scene.model), load, run.terminal());
  begin_bake(slots, shared, target);
  BakeOptions how;
  how.values.axes = asked_axes(run.options());
  if (!names_gltf(run.options().text("output"))) how.factors = factors_into_pictures(slots, target.model);
  bake_onto(run, slots, source, target, BakeTo::textures, how, share);
  scene = std::move(target);
}

}  // namespace mq::app

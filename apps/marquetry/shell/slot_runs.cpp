// Each slot is processed as if it were the only one; the models that come of it are joined in memory, and
// written once.
#include "shell/slot_runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "mq/base/error.h"
#include "mq/io/file_names.h"
#include "mq/model/joined_slots.h"
#include "shell/results.h"

namespace mq::app {
namespace {

bool has_option(const OptionValues& options, const std::string& name) {
  return std::ranges::any_of(options.table().options(),
                             [&](const Option& option) { return option.name == name; });
}

/// What was made of one slot, if the run got that far.
struct SlotRun {
  std::string slot;
  std::optional<Model> made;
  Json report;
  Exit exit = Exit::done;
};

SlotRun run_slot(const Verb& verb, OptionValues options, const std::string& slot, Terminal& terminal,
                 const Progress& progress, KeptWork& kept) {
  options.set("slot", {slot});
  SlotRun result{slot, {}, {}};
  Run run(options, terminal, progress);
  run.kept = &kept;
  run.receiver = [&](Model model) { result.made = std::move(model); };
  try {
    result.exit = verb.run(run);
  } catch (const InvalidInput& error) {
    throw InvalidInput(fmt::format("slot {}: {}", slot, error.what()));
  }
  progress.check();
  result.report = run.report();
  return result;
}

/// Every slot's pictures need a place of their own.
void check_output(const std::string& output, const Model& model) {
  const bool keeps_all = std::filesystem::path(output).extension() == model.path.extension() ||
                         (names_gltf(output) && names_gltf(model.path));
  require(!names_model(output) || keeps_all,
          fmt::format("--output: several slots go into the format that was read, {}, or into a folder; "
                      "found '{}'",
                      model.path.extension().string(), output));
}

/// Writes what all runs made. Returns the files.
Json write_slots(std::vector<SlotRun>& runs, const OptionValues& options, Terminal& terminal,
                 const Progress& progress) {
  Model model = std::move(*runs.front().made);
  for (std::size_t i = 1; i < runs.size(); ++i)
    if (runs[i].made) join_slot(std::move(*runs[i].made), model);
  const std::string output = options.text("output");
  if (!names_model(output)) model = all_pictures(std::move(model));
  Run writing(options, terminal, progress);
  for (const auto* textures : {&model.textures, &model.others})
    for (const Texture& texture : *textures)
      if (!texture.path.empty()) writing.will_read(texture.path);
  writing.will_read(model.path);
  const Outputs outputs(output, model, Outputs::Kind::pictures);
  writing.will_write(outputs.paths(), outputs.folders());
  write_outputs(writing, outputs, std::move(model), progress);
  return writing.result["outputs"];
}

}  // namespace

bool asks_for_slots(const Verb& verb, const OptionValues& options) {
  if (verb.slots == Slots::its_own || !has_option(options, "slot") || !options.given("slot"))
    return false;
  const std::string slot = options.text("slot");
  if (!names_several_slots(slot)) return false;
  require(verb.slots == Slots::several,
          fmt::format("--slot: '{}' takes one slot at a time; found '{}'", verb.table.verb(), slot));
  for (const char* name : {"vertices", "geometry"})
    require(!has_option(options, name) || !options.flag(name),
            fmt::format("--slot: it is for pictures, and --{} looks at none: leave one out", name));
  require(options.texts("texture").empty(),
          "--slot: pictures named after the mesh are for one slot; found several");
  return true;
}

SlotsOutcome run_slots(const Verb& verb, const OptionValues& options, Terminal& terminal,
                       const Progress& progress, KeptWork& kept) {
  const Model model = read_model(options.text("mesh"),
                                 {.textures = {}, .pictures = ReadModelOptions::Pictures::skip});
  check_output(options.text("output"), model);
  const std::vector<std::string> slots = slots_asked_for(model, options.text("slot"));
  std::vector<SlotRun> runs;
  SlotsOutcome all;
  for (const std::string& slot : slots) {
    terminal.remark(fmt::format("{}: slot {}", model.path.string(), slot));
    runs.push_back(run_slot(verb, options, slot, terminal,
                            progress.step("slot " + slot, 0.9 / double(slots.size())), kept));
    all.exit = std::max(all.exit, runs.back().exit);
  }
  all.report = runs.back().report;
  if (runs.front().made)
    all.report["result"]["outputs"] =
        write_slots(runs, options, terminal, progress.step("write", 0.1));
  all.report["options"] = options_json(options);
  Json reports = Json::array();
  for (SlotRun& run : runs) {
    run.report["slot"] = run.slot;
    reports.push_back(std::move(run.report));
  }
  all.report["slots"] = std::move(reports);
  return all;
}

}  // namespace mq::app

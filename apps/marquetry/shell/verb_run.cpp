#include "shell/frame_numbers.h"
#include "shell/verb_run.h"

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <filesystem>
#include <thread>

#include "mq/base/error.h"
#include "mq/io/frame_files.h"
#include "mq/io/held_files.h"
#include "mq/io/path_status.h"
#include "mq/io/tiles.h"
#include "mq/model/kept_work.h"
#include "mq/version.h"
#include "shell/slot_runs.h"
#include "verbs/shared/unwrap_evolving.h"

namespace mq::app {
namespace {

/// The options of one frame: its number put into every file name that has a place for it.
OptionValues frame_options(const OptionValues& options, int frame) {
  OptionValues one = options;
  for (const Option& option : options.table().options()) {
    if (option.type != Option::Type::path || option.scope == Option::Scope::run) continue;
    std::vector<std::string> names = options.texts(option.name);
    if (names.empty()) continue;
    for (std::string& name : names) name = frame_name(name, frame);
    one.set(option.name, names);
  }
  return one;
}

/// Every frame needs an output of its own, and inputs that are not one file with all frames.
void check_frame_places(const OptionValues& options) {
  for (const Option& option : options.table().options())
    if (option.place == Option::Place::positional)
      for (const std::string& name : options.texts(option.name))
        require(!names_evolving(name) || has_frame_place(name),
                fmt::format("--frames: {} is an evolving mesh, one file with all of its frames, "
                            "and taken whole; leave --frames out",
                            name));
  for (const Option& option : options.table().options())
    if ((option.name == "output" || option.name.starts_with("write-")) && options.has(option.name))
      require(has_frame_place(options.text(option.name)),
              fmt::format("--{}: with --frames the name needs a place for the number, such as "
                          "out_%04d.png; found '{}'",
                          option.name, options.text(option.name)));
}

/// Throws where what a frame works on is not there, before any of them is begun.
void require_frames(const OptionValues& options, const std::vector<int>& frames) {
  for (const Option& option : options.table().options())
    if (option.place == Option::Place::positional && option.type == Option::Type::path)
      for (const std::string& name : options.texts(option.name))
        for (const int frame : has_frame_place(name) && !tile_name(name) ? frames : std::vector<int>())
          if (const std::string file = frame_name(name, frame);
              !names_held(file) && !is_there(file))
            throw IoError(fmt::format("cannot read {}: frame {} of --frames is not there; check the numbers, nothing "
                                      "was written",
                                      file, frame));
}

/// Without --frames nothing says which number the place stands for.
void refuse_frame_places(const OptionValues& options) {
  for (const Option& option : options.table().options())
    if (option.name == "output" && options.has(option.name))
      require_no_frame_place(options.text(option.name));
}

VerbOutcome run_once(const Verb& verb, const OptionValues& options, Terminal& terminal,
                     const Progress& progress, KeptWork* kept) {
  if (asks_for_slots(verb, options)) {
    KeptWork of_slots;
    SlotsOutcome slots = run_slots(verb, options, terminal, progress, kept ? *kept : of_slots);
    return {slots.exit, std::move(slots.report)};
  }
  Run run(options, terminal, progress);
  run.kept = kept;
  const Exit exit = verb.run(run);
  progress.check();
  return {exit, run.report()};
}

}  // namespace

VerbOutcome run_as_asked(const Verb& verb, const OptionValues& options, Terminal& terminal,
                         const Progress& progress, KeptWork* kept) {
  const auto threads = options.integer("threads");
  const tbb::global_control control(
      tbb::global_control::max_allowed_parallelism,
      threads > 0 ? std::size_t(threads) : std::max(1U, std::thread::hardware_concurrency()));
  const bool sequence = std::ranges::any_of(
      options.table().options(), [](const Option& option) { return is_frames_option(option); });
  if (sequence && !options.has("frames")) {
    require(!options.has("shard"), "--shard: it is of frames, and there are none: give --frames too, such as 1-100");
    refuse_frame_places(options);
  }
  if (!sequence || !options.has("frames")) {
    VerbOutcome one = run_once(verb, options, terminal, progress, kept);
    terminal.say_where_more_is();
    return one;
  }

  check_frame_places(options);
  std::vector<int> frames = parse_frames(options.text("frames"));
  if (options.has("shard")) frames = frames_of(*parse_shard(options.text("shard")), frames);
  require_frames(options, frames);
  VerbOutcome all;
  Json reports = Json::array();
  KeptWork of_frames;
  if (!kept && frames.size() > 1) kept = &of_frames;
  for (const int frame : frames) {
    VerbOutcome one =
        run_once(verb, frame_options(options, frame), terminal,
                 progress.step(fmt::format("frame {}", frame), 1.0 / double(frames.size())), kept);
    all.exit = std::max(all.exit, one.exit);
    one.report["frame"] = frame;
    reports.push_back(std::move(one.report));
  }
  terminal.say_where_more_is();
  all.report = reports.empty() ? Json{{"verb", options.table().verb()}, {"version", version}} : reports.back();
  all.report.erase("frame");
  all.report["options"] = options_json(options);
  if (options.has("shard")) all.report["shard"] = options.text("shard");
  all.report["frames"] = std::move(reports);
  return all;
}

}  // namespace mq::app

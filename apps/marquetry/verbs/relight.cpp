// marquetry relight EVOLVING TEXTURES -o OUT: filters in time for the textures of an evolving mesh:
// lighting that comes and goes taken out, or all frames filtered at once.
#include <fmt/format.h>

#include <algorithm>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/model/relit_sequence.h"
#include "options/signal_options.h"
#include "options/solver_options.h"
#include "options/video_options.h"
#include "shell/arguments.h"
#include "shell/frame_numbers.h"
#include "shell/results.h"
#include "shell/run.h"
#include "shell/verb.h"
#include "verbs/shared/evolving_frames.h"

namespace mq::app {
namespace {

Json comparison_json(const TruthComparison& found) {
  return {{"factor", found.factor}, {"error", found.error}, {"sharpness", found.sharpness}, {"flicker", found.flicker}};
}

Json flicker_json(const Flicker& found) {
  Json result = {{"deviation", found.deviation}, {"step", found.step}};
  if (found.along) result["along"] = *found.along;
  return result;
}

RelightOptions::Drift drift(const OptionValues& options) {
  const std::string how = options.text("drift");
  if (how == "follow") return RelightOptions::Drift::follow;
  return how == "measure" ? RelightOptions::Drift::measure : RelightOptions::Drift::ignore;
}

Json measures_json(const RelightMeasures& found) {
  const Flicker &was = found.before.flicker, &is = found.after.flicker;
  Json result;
  result["flicker"] = {{"before", flicker_json(was)},
                       {"after", flicker_json(is)},
                       {"values", was.values}};
  result["gradients"] = found.gradients;
  if (found.before.truth)
    result["truth"] = {{"before", comparison_json(*found.before.truth)},
                       {"after", comparison_json(*found.after.truth)}};
  return result;
}

/// How frames go on from those before them.
Json onward_json(const std::vector<FrameOnward>& frames) {
  Json rows = Json::array();
  for (const FrameOnward& frame : frames) {
    Json row = {{"frame", frame.frame}, {"followed", frame.is_followed()}};
    if (frame.fit) row.update({{"texels", frame.fit->texels}, {"explained", frame.fit->explained}});
    rows.push_back(row);
  }
  return rows;
}

/// Where drift was to be followed, and was not from many a frame to the next.
void remark_on_drift(Terminal& terminal, const std::vector<FrameOnward>& frames) {
  const std::int64_t rests = std::ranges::count_if(frames, [](const FrameOnward& f) { return !f.is_followed(); }),
                     charts = std::ranges::count_if(frames, [](const FrameOnward& f) { return !f.fit; });
  if (rests == 0 || 3 * rests < std::ssize(frames)) return;
  terminal.remark(
      fmt::format("drift is not followed to {} of {} from the one before ({} where charts change, {} where no flow brings "
                  "both nearer to each other): they are joined as if nothing slid (result.drift of the report)",
                  rests, counted(std::ssize(frames), "frame"), charts, rests - charts));
}

RelightOptions relight_options(const OptionValues& options) {
  return {.method = options.text("method") == "mean" ? RelightOptions::Method::mean
                                                     : RelightOptions::Method::poisson,
          .spread = spread(options),
          .tolerance = options.number("tolerance"),
          .radius = int(options.integer("radius")),
          .crossover = options.text("crossover") == "steep" ? LightRemovalOptions::Crossover::steep
                                                            : LightRemovalOptions::Crossover::gentle,
          .drift = drift(options),
          .poisson = {.beta = options.number("beta"),
                      .gamma = options.number("gamma"),
                      .change = options.number("change"),
                      .window = int(options.integer("hold")),
                      .accuracy = options.number("accuracy")},
          .values = value_space(options)};
}

RelightFiles relight_files(const OptionValues& options) {
  return {.textures = options.text("textures"),
          .output = options.text("output"),
          .truth = options.has("truth") ? options.text("truth") : "",
          .video = video_options(options)};
}

void refuse_of_other_method(const OptionValues& options) {
  const bool mean = options.text("method") == "mean";
  for (const char* name : {"gamma", "beta", "change", "hold", "accuracy"})
    require(!mean || !asks_for(options, name),
            fmt::format("--{}: only --method poisson has it", name));
  for (const char* name : {"radius", "crossover"})
    require(mean || !asks_for(options, name), fmt::format("--{}: only --method mean has it", name));
}

/// By what it is filtered.
std::string in_words(const OptionValues& options) {
  if (options.text("method") == "poisson") return fmt::format("poisson, gamma {:g}", options.number("gamma"));
  return fmt::format("means over {} to either side", counted(options.integer("radius"), "frame"));
}

std::string in_words(const Json& result, const TemporalReport& report, const std::string& method) {
  const Json& flicker = result["flicker"];
  std::string text = fmt::format(
      "flicker {:.5f} before, {:.5f} after (from frame to frame {:.5f} and {:.5f}); gradients "
      "times {:.3f}\nby {}; {} at most held at once; {:.2g} times the residual per cycle, {} at most\n",
      flicker["before"]["deviation"].get<double>(), flicker["after"]["deviation"].get<double>(),
      flicker["before"]["step"].get<double>(), flicker["after"]["step"].get<double>(),
      result["gradients"].get<double>(), method,
      counted(report.held, "frame"), report.factor, report.solve.cycles);
  if (result.contains("truth"))
    text += fmt::format("error against the truth {:.5f} before, {:.5f} after\n",
                        result["truth"]["before"]["error"].get<double>(),
                        result["truth"]["after"]["error"].get<double>());
  return text;
}

void report(Run& run, const RelitSequence& found) {
  const TemporalReport& filter = found.filter;
  run.result.update(measures_json(found.measures));
  run.result.update({{"weight", found.weight},
                     {"windows", filter.windows},
                     {"held", filter.held},
                     {"look_ahead", filter.look_ahead},
                     {"factor", filter.factor}});
  run.solve = solve_json(filter.solve);
  run.add_seconds("solver set-up", filter.solve.setup_seconds);
  run.add_seconds("solver", filter.solve.solve_seconds);
  const RelightOptions::Drift how = drift(run.options());
  if (how != RelightOptions::Drift::ignore) run.result["drift"] = onward_json(found.onward);
  run.print(in_words(run.result, filter, in_words(run.options())));
  if (how == RelightOptions::Drift::follow) remark_on_drift(run.terminal(), found.onward);
  if (!filter.solve.converged)
    run.terminal().warning(
        "a solve did not reach --tolerance: the result is less accurate than "
        "asked for");
}

Exit relight(Run& run) {
  const OptionValues& options = run.options();
  refuse_of_other_method(options);
  require_video_for_codec(options, names_video(options.text("output")));
  const EvolvingReader reader(options.text("evolving"));
  run.will_read(options.text("evolving"));
  warn_of_broken(run.terminal(), reader);
  const std::vector<int> frames = wanted_frames(options, reader);
  RelightOptions how = relight_options(options);
  if (options.has("shard")) {
    require(!names_video(options.text("output")),
            fmt::format("--shard: {} would be a video of a part alone: write pictures, such as lit_%04d.png, and make a "
                        "video of all",
                        options.text("output")));
    const FrameRange part = asked_range(options, int(frames.size()));
    how.first = part.first;
    how.end = part.end;
  }
  SequenceRelighter relighter(reader, frames, relight_files(options), how, run.terminal());
  for (const std::filesystem::path& path : relighter.inputs()) run.will_read(path);
  relighter.rehearse();
  run.will_write(relighter.outputs(), std::filesystem::path(options.text("output")).parent_path());
  run.input = {{"frames", std::min(how.end, int(frames.size())) - how.first}, {"segments", reader.segments().size()}};
  if (run.dry_run()) return Exit::done;
  RelitSequence found;
  {
    const Step step(run, "filter", 1);
    found = relighter.run(step);
  }
  report(run, found);
  if (options.has("shard"))
    run.result["part"] = {{"shard", options.text("shard")}, {"first", how.first}, {"end", how.end}, {"of", frames.size()}};
  say_written(run, relighter.outputs());
  return Exit::done;
}

void add_poisson_options(OptionTable& table) {
  using Type = Option::Type;
  const RelightOptions defaults;
  table.add({.name = "gamma",
             .type = Type::number,
             .default_value = as_typed(defaults.poisson.gamma),
             .unit = "frames squared",
             .least = 0,
             .most = 1e6,
             .group = "Poisson",
             .help = "weight of changes in time against values",
             .details = "Values spread over about its square root to either side."});
  table.add({.name = "beta",
             .type = Type::number,
             .default_value = as_typed(defaults.poisson.beta),
             .least = -1000,
             .most = 1000,
             .group = "Poisson",
             .help = "gradients in space times this: below 1 smooths, above sharpens"});
  table.add({.name = "change",
             .type = Type::number,
             .default_value = as_typed(defaults.poisson.change),
             .least = -1000,
             .most = 1000,
             .group = "Poisson",
             .help = "changes in time times this: 0 takes them out, 1 leaves them"});
  table.add({.name = "accuracy",
             .type = Type::number,
             .default_value = as_typed(defaults.poisson.accuracy),
             .least = 1e-12,
             .most = 0.9,
             .group = "Poisson",
             .help = "what may be lost of values in frames that are too far ahead to be held"});
  table.add({.name = "hold",
             .type = Type::integer,
             .default_value = as_typed(defaults.poisson.window),
             .unit = "frames",
             .least = 0,
             .most = 1000000,
             .group = "Poisson",
             .help = "how many are held at once, 0: what --accuracy needs, twice, and 8"});
}

void add_time_options(OptionTable& table) {
  using Type = Option::Type;
  const RelightOptions defaults;
  table.add({.name = "method",
             .type = Type::choice,
             .default_value = "mean",
             .choices = {"mean", "poisson"},
             .metavar = "HOW",
             .group = "Filter",
             .help = "mean or poisson",
             .details = "mean: each frame keeps its gradients and gets the low frequencies of the "
                        "frames around it, which takes out light that comes and goes. poisson: all "
                        "frames at once, gradients in space and changes in time multiplied by what "
                        "--beta and --change say, which takes out flicker."});
  add_spread_options(table, defaults.spread, "Filter",
                     "weight of gradients in space against values of the mean or the frame", false,
                     "0 takes all from the mean, and leaves the frames to --gamma alone.");
  table.add({.name = "drift",
             .type = Type::choice,
             .default_value = "ignore",
             .choices = {"ignore", "measure", "follow"},
             .metavar = "HOW",
             .group = "Filter",
             .help = "ignore, measure or follow",
             .details = "What is not tracked exactly slides over the texels, and is blurred in time. follow: where it slid "
                        "to is found by optical flow from frame to frame, and means are taken there, and changes; each "
                        "frame stays where it was. measure: nothing but the report's flicker is taken along it."});
  table.add({.name = "radius",
             .type = Type::integer,
             .default_value = as_typed(defaults.radius),
             .unit = "frames",
             .least = 0,
             .most = 1000,
             .group = "Mean",
             .help = "how far a mean reaches to either side"});
  table.add({.name = "crossover",
             .type = Type::choice,
             .default_value = "steep",
             .choices = {"gentle", "steep"},
             .metavar = "HOW",
             .group = "Mean",
             .help = "gentle or steep",
             .details = "How waves that come from the mean are parted from those of the frame. gentle: by the thesis' "
                        "equation, in which a fifth is still the other's an octave beside the middle. steep: a tenth, and "
                        "less and less beyond, by three solves a frame."});
  add_poisson_options(table);
}

}  // namespace

Verb relight_verb() {
  using Type = Option::Type;
  OptionTable table(
      "relight",
      "Take light that comes and goes, or flicker, out of the textures of an evolving "
      "mesh.");
  table.example("walk.evolving texture_%04d.png -o lit_%04d.png", "light that comes and goes, taken out");
  table.example("walk.evolving texture_%04d.png -o lit_%04d.png --shard 2/4", "of the second of four parts of the frames");
  table.add({.name = "evolving",
             .place = Option::Place::positional,
             .type = Type::path,
             .required = true,
             .help = "the evolving mesh, with an atlas"});
  table.add({.name = "textures",
             .place = Option::Place::positional,
             .type = Type::path,
             .required = true,
             .help = "texture_%04d.png: a picture for each frame, as export --from writes them"});
  table.add({.name = "output",
             .letter = 'o',
             .type = Type::path,
             .required = true,
             .metavar = "OUT",
             .help = "a model a frame, a picture a frame, such as lit_%04d.png, or a video (.mp4, "
                     ".mov, .webm, .mkv)"});
  add_evolving_frames_option(table);
  Option shard = shard_option();
  shard.help = "write only part I of N of the frames, on one of N machines";
  shard.details = "Frames of other parts are read as far as they matter.";
  table.add(shard);
  add_rate_option(table);
  add_codec_option(table);
  add_time_options(table);
  add_space_option(table, "log");
  table.add({.name = "tolerance",
             .type = Type::number,
             .default_value = as_typed(RelightOptions{}.tolerance),
             .least = 1e-14,
             .most = 0.1,
             .group = "Solver",
             .help = "relative residual at which iterations stop"});
  table.add({.name = "truth",
             .type = Type::path,
             .group = "Measuring",
             .help = "true_%04d.png: what the textures should be; the report says how near they "
                     "come, up to one factor"});
  return {table, relight, {}, {{"window", "hold"}}};
}

}  // namespace mq::app

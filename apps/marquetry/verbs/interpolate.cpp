// marquetry interpolate A.png B.png -o OUT, marquetry interpolate MESH A.png B.png -o OUT: signals
// between two, without ghosts: both are moved along their optical flow before they are mixed.
#include <fmt/format.h>

#include "flow_options.h"
#include "flow_pair.h"
#include "mq/io/frame_files.h"
#include "mq/base/error.h"
#include "outputs.h"
#include "signal_options.h"
#include "verb.h"

namespace mq::app {
namespace {

/// A time and the name of what shows it.
struct Moment {
  double time;
  std::string output;
};

std::vector<Moment> moments(const OptionValues& options) {
  const std::string output = options.text("output");
  if (!options.has("frames")) return {{options.number("time"), output}};
  require(has_frame_place(output),
          fmt::format("--output: with --frames the name needs a place for the number, such as "
                      "out_%04d.png; found '{}'",
                      output));
  const std::vector<int> frames = parse_frames(options.text("frames"));
  require(frames.size() >= 2,
          "--frames: two or more are wanted, from the first signal to the second; "
          "for one between them give --time");
  std::vector<Moment> all;
  for (const int frame : frames)
    all.push_back({double(frame - frames.front()) / (frames.back() - frames.front()),
                   frame_name(output, frame)});
  return all;
}

Outputs outputs_for(const Moment& moment, const Model& model, Outputs::Kind kind) {
  return Outputs(moment.output, model, kind);
}

/// Says what will be written; nothing is left to do where that is all that was asked for.
std::vector<Outputs> planned(Run& run, const std::vector<Moment>& all, const Model& model,
                             Outputs::Kind kind) {
  std::vector<Outputs> outputs;
  for (const Moment& moment : all) {
    outputs.push_back(outputs_for(moment, model, kind));
    run.will_write(outputs.back().paths(), outputs.back().folder());
  }
  return outputs;
}

void say_all(Run& run, const std::vector<Moment>& all, const std::vector<Outputs>& outputs) {
  std::vector<std::filesystem::path> paths;
  Json times = Json::array();
  for (std::size_t i = 0; i < all.size(); ++i) {
    times.push_back(all[i].time);
    paths.insert(paths.end(), outputs[i].paths().begin(), outputs[i].paths().end());
  }
  run.result["times"] = times;
  say_written(run, paths);
}

Exit interpolate_pictures(Run& run) {
  const OptionValues& options = run.options();
  const ImageFlowOptions how = image_flow_options(options);
  const PicturePair pair(run);
  const std::vector<Moment> all = moments(options);
  require(!names_model(options.text("output")),
          fmt::format("--output: found '{}', wanted a picture: what is read are pictures",
                      options.text("output")));
  const std::vector<Outputs> outputs = planned(run, all, pair.model(), Outputs::Kind::pictures);
  if (run.dry_run()) return Exit::done;
  ImageFlow flow;
  {
    const Step step(run, "align", 0.6);
    about(pair.model(), [&] { flow = image_flow(pair.first(), pair.second(), how, step); });
  }
  run.result = flow_json(flow);
  const Step step(run, "write", 0.3);
  for (std::size_t i = 0; i < all.size(); ++i) {
    Model between;
    between.path = pair.model().path;
    between.textures = {pair.stored(interpolated(flow, pair.first(), pair.second(), all[i].time))};
    set_depth(options, between);
    for (const std::string& note : outputs[i].write(
             std::move(between), step.progress().step("frame", 1.0 / double(all.size()))))
      run.terminal().remark(note);
  }
  say_all(run, all, outputs);
  return Exit::done;
}

Exit interpolate_model(Run& run) {
  const OptionValues& options = run.options();
  const TextureFlowOptions how = texture_flow_options(options);
  ModelPair pair(run);
  const std::vector<Moment> all = moments(options);
  const std::vector<Outputs> outputs =
      planned(run, all, pair.scene().model,
              pair.at_vertices() ? Outputs::Kind::model : Outputs::Kind::pictures);
  if (run.dry_run()) return Exit::done;
  {
    const Step step(run, "align", 0.4);
    pair.align(how, step);
  }
  run.result = flow_json(pair.flow());
  run.result["vertices"] = pair.flow_vertices();
  const Step step(run, "write", 0.3);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Progress frame =
        step.progress().step(fmt::format("time {:.3g}", all[i].time), 1.0 / double(all.size()));
    Model between = pair.scene().model;
    pair.target().put(pair.first(), pair.between(all[i].time, frame.step("meet", 0.7)), between);
    set_depth(options, between);
    for (const std::string& note : outputs[i].write(std::move(between), frame.step("write", 0.3)))
      run.terminal().remark(note);
  }
  say_all(run, all, outputs);
  return Exit::done;
}

Exit run_interpolate(Run& run) {
  return is_picture_pair(run.options()) ? interpolate_pictures(run) : interpolate_model(run);
}

}  // namespace

Verb interpolate_verb() {
  using Type = Option::Type;
  OptionTable table(
      "interpolate",
      "Make what lies between two pictures, textures or colourings of a model, moved along "
      "their optical flow, so that nothing is seen twice.");
  add_flow_options(table);
  add_output_option(table);
  table.add({.name = "time",
             .letter = 't',
             .type = Type::number,
             .default_value = "0.5",
             .least = 0,
             .most = 1,
             .group = "Times",
             .help = "0 is the first, 1 the second"});
  table.add({.name = "frames",
             .type = Type::text,
             .accepts = [](const std::string& text) { return !parse_frames(text).empty(); },
             .wanted = "a range such as 0-24",
             .metavar = "RANGE",
             .group = "Times",
             .help =
                 "pictures at equal times, from the first for the first number to the second for "
                 "the last; %04d in --output stands for the number"});
  table.exclusive({"time", "frames"});
  add_depth_option(table);
  return {table, run_interpolate};
}

}  // namespace mq::app

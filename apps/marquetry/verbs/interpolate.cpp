// marquetry interpolate A.png B.png -o OUT, marquetry interpolate MESH A.png B.png -o OUT: signals
// between two, without ghosts: both are moved along their optical flow before they are mixed.
#include <fmt/format.h>

#include <memory>

#include "shell/arguments.h"
#include "options/flow_options.h"
#include "verbs/shared/flow_pair.h"
#include "mq/base/error.h"
#include "mq/image/colour.h"
#include "mq/io/file_names.h"
#include "mq/io/frame_files.h"
#include "mq/io/video.h"
#include "shell/results.h"
#include "options/signal_options.h"
#include "shell/frame_numbers.h"
#include "shell/verb.h"

namespace mq::app {
namespace {

/// A time and the name of what shows it.
struct Moment {
  double time;
  std::string output;
};

std::vector<Moment> moments(const OptionValues& options) {
  const std::string output = options.text("output");
  require(options.has("frames") || !names_video(output),
          fmt::format("--output: {} is a video: say with --frames how many frames it has", output));
  if (!options.has("frames")) require_no_frame_place(output);
  require(
      !options.has("frames") || has_frame_place(output) || names_video(output),
      fmt::format("--output: with --frames wanted a video (.mp4, .mov, .webm or .mkv), or a name "
                  "with a place for the number, such as out_%04d.png; found '{}'",
                  output));
  require(names_video(output) || !asks_for(options, "rate"),
          fmt::format("--rate is for videos (.mp4, .mov, .webm or .mkv); found '{}'", output));
  require(!names_video(output) || !asks_for(options, "depth") || options.text("depth") == "8",
          fmt::format("--depth: found '{}', but {} is a video, which has 8 bits: leave it out, or "
                      "write pictures (out_%04d.png)",
                      options.text("depth"), output));
  if (!options.has("frames")) return {{options.number("time"), output}};
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

/// Where what lies between goes: a picture or a model for each time, or one video.
class Results {
 public:
  /// Says what will be written.
  Results(Run& run, const Model& model, Outputs::Kind kind)
      : run_(run), moments_(moments(run.options())) {
    const std::string output = run.options().text("output");
    if (names_video(output)) {
      require(
          kind == Outputs::Kind::pictures && model.textures.size() == 1,
          fmt::format("--output: found '{}', but a video shows one picture: wanted a name with "
                      "%04d for the frame's number{}",
                      output, kind == Outputs::Kind::pictures ? " and %s for the texture's" : ""));
      run.will_write({output});
      return;
    }
    for (const Moment& moment : moments_) {
      outputs_.emplace_back(moment.output, model, kind);
      run.will_write(outputs_.back().paths(), outputs_.back().folders());
    }
  }

  const std::vector<Moment>& all() const { return moments_; }

  void write(std::size_t i, Model between, const Progress& progress) {
    set_depth(run_.options(), between);
    if (!outputs_.empty()) {
      for (const std::string& note : outputs_[i].write(std::move(between), progress))
        run_.terminal().remark(note);
      return;
    }
    const Texture& frame = between.textures.front();
    if (!video_) {
      video_ = std::make_unique<VideoWriter>(
          moments_[i].output, frame.pixels.width(), frame.pixels.height(),
          VideoOptions{.rate = run_.options().number("rate")}, run_.progress());
      for (const std::string& note : video_->notes()) run_.terminal().remark(note);
    }
    video_->write(holds_light(frame.format)
                      ? encode(frame.pixels, ColourSpace::linear, TransferFunction::srgb)
                      : frame.pixels);
    progress.check();
  }

  /// Says what was written.
  void finish() {
    if (video_) video_->finish();
    std::vector<std::filesystem::path> paths;
    if (video_) paths.emplace_back(moments_.front().output);
    for (const Outputs& output : outputs_)
      paths.insert(paths.end(), output.paths().begin(), output.paths().end());
    Json times = Json::array();
    for (const Moment& moment : moments_) times.push_back(moment.time);
    run_.result["times"] = times;
    say_written(run_, paths);
  }

 private:
  Run& run_;
  std::vector<Moment> moments_;
  std::vector<Outputs> outputs_;  ///< one per moment; none for a video
  std::unique_ptr<VideoWriter> video_;
};

Exit interpolate_pictures(Run& run) {
  const OptionValues& options = run.options();
  const ImageFlowOptions how = image_flow_options(options);
  const AskedPictures asked(run);
  const PicturePair& pair = asked.pair();
  require_scales(options, how, pair.first().width(), pair.first().height());
  require(!names_model(options.text("output")),
          fmt::format("--output: found '{}', wanted a picture: what is read are pictures",
                      options.text("output")));
  Results results(run, pair.model(), Outputs::Kind::pictures);
  if (run.dry_run()) return Exit::done;
  ImageFlow flow;
  {
    const Step step(run, "align", 0.6);
    flow = asked.align(run, how, step);
  }
  const Step step(run, "write", 0.3);
  const double share = 1.0 / double(results.all().size());
  for (std::size_t i = 0; i < results.all().size(); ++i)
    results.write(i, pair.with(pair.between(flow, results.all()[i].time)),
                  step.progress().step("frame", share));
  results.finish();
  return Exit::done;
}

Exit interpolate_model(Run& run) {
  const OptionValues& options = run.options();
  const ModelFlowOptions how = model_flow_options(options);
  const AskedModels asked(run);
  const ModelPair& pair = asked.pair();
  Results results(run, asked.model(),
                  pair.at_vertices() ? Outputs::Kind::model : Outputs::Kind::pictures);
  if (run.dry_run()) return Exit::done;
  const ModelPairFlow flow = [&] {
    const Step step(run, "align", asked.share_of_align());
    return asked.align(run, how, step);
  }();
  const Step step(run, "write", 0.3);
  const double share = 1.0 / double(results.all().size());
  for (std::size_t i = 0; i < results.all().size(); ++i) {
    const double time = results.all()[i].time;
    const Progress frame = step.progress().step(fmt::format("time {:.3g}", time), share);
    Model between = pair.with(flow.between(time, frame.step("meet", 0.7)), time);
    results.write(i, std::move(between), frame.step("write", 0.3));
  }
  results.finish();
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
  table.example("first.png second.png -o between.png", "the picture half-way");
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
  Option frames = frames_option();
  frames.wanted = "a range such as 0-24, of at most a million frames";
  frames.group = "Times";
  frames.help =
      "pictures at equal times, from the first for the first number to the second for the last; %04d in --output "
      "stands for the number, or --output is a video";
  table.add(frames);
  table.add({.name = "rate",
             .type = Type::number,
             .default_value = as_typed(VideoOptions{}.rate),
             .unit = "frames per second",
             .least = 0.001,
             .most = 1000,
             .group = "Times",
             .help = "of a video"});
  table.exclusive({"time", "frames"});
  add_depth_option(table);
  return {table, run_interpolate,
          {{.what = "what lies between two", .textures = "yes, across seams"}}};
}

}  // namespace mq::app

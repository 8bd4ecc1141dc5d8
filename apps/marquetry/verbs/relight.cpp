// marquetry relight EVOLVING TEXTURES -o OUT: filters in time for the textures of an evolving mesh:
// lighting that comes and goes taken out, or all frames filtered at once.
#include <fmt/format.h>

#include <map>
#include <memory>
#include <optional>

#include "verbs/shared/evolving_frames.h"
#include "mq/atlas/atlas.h"
#include "mq/base/error.h"
#include "mq/base/memory.h"
#include "mq/base/words.h"
#include "mq/io/frame_files.h"
#include "mq/io/image_file.h"
#include "mq/model/frame_textures.h"
#include "mq/video/gutter.h"
#include "mq/video/light_removal.h"
#include "mq/video/relight_meter.h"
#include "mq/video/temporal_poisson.h"
#include "options/signal_options.h"
#include "options/video_options.h"
#include "shell/results.h"
#include "shell/run.h"
#include "shell/verb.h"
#include "options/solver_options.h"

namespace mq::app {
namespace {

namespace fs = std::filesystem;

constexpr double most_poisson_alpha = 1e5;

Json comparison_json(const TruthComparison& found) {
  return {{"factor", found.factor}, {"error", found.error}, {"sharpness", found.sharpness}};
}

Json measures_json(const RelightMeasures& found) {
  const Flicker &was = found.before.flicker, &is = found.after.flicker;
  Json result;
  result["flicker"] = {{"before", {{"deviation", was.deviation}, {"step", was.step}}},
                       {"after", {{"deviation", is.deviation}, {"step", is.step}}},
                       {"values", was.values}};
  result["gradients"] = found.gradients;
  if (found.before.truth)
    result["truth"] = {{"before", comparison_json(*found.before.truth)},
                       {"after", comparison_json(*found.after.truth)}};
  return result;
}

/// The frames that are asked for, read as they are wanted and written as they are done.
class Film {
 public:
  Film(Run& run, const EvolvingReader& reader, std::vector<int> frames)
      : run_(run),
        reader_(reader),
        frames_(std::move(frames)),
        numbers_(numbers_of(reader, frames_)),
        output_(run.options().text("output"), "--output"),
        values_(value_space(run.options())) {}

  const std::vector<int>& numbers() const { return numbers_; }
  std::vector<fs::path> outputs() const { return output_.paths(numbers_); }

  std::vector<fs::path> inputs() const {
    std::vector<fs::path> paths;
    for (const char* option : {"textures", "truth"})
      if (run_.options().has(option))
        for (const int number : numbers_)
          paths.emplace_back(frame_name(run_.options().text(option), number));
    return paths;
  }

  TemporalFrame load(int i) {
    Frame frame;
    frame.texture = read("textures", i);
    const std::shared_ptr<AtlasFrame> atlas = atlas_of(i);
    frame.atlas = atlas;
    const TexelSpace& space = atlas->space();
    const std::vector<Image<float>> decoded_pixels = {decoded(frame.texture, values_)};
    TemporalFrame result{std::shared_ptr<const SignalSpace>(atlas, &space),
                         std::make_shared<Texels>(space.texels()),
                         space.gather(decoded_pixels),
                         {}};
    if (last_) result.links = texel_links(*last_, *atlas);
    last_ = atlas;
    open_[i] = std::move(frame);
    return result;
  }

  void store(int i, const TemporalFrame& frame, const Signal& phi) {
    Frame& open = open_.at(i);
    std::shared_ptr<AtlasFrame> atlas = open.atlas.lock();
    if (!atlas) atlas = atlas_of(i);
    const TexelSpace& space = atlas->space();
    std::vector<Image<float>> pixels = {decoded(open.texture, values_)};
    space.scatter(phi, pixels);
    pixels[0] = encoded(pixels[0], open.texture, values_);
    const Signal was = space.gather(std::vector{open.texture.pixels}), is = space.gather(pixels);
    Signal truth;
    if (run_.options().has("truth")) truth = space.gather(std::vector{read("truth", i).pixels});
    measures_.add(frame, space, was, is, truth.size() > 0 ? &truth : nullptr);
    const Image<char> inside = spread_from_charts(space.texels(), pixels[0]);
    const FrameTextures::Frame shown = {.number = numbers_[i],
                                        .mesh = atlas->surface().mesh,
                                        .inside = inside,
                                        .pixels = pixels[0],
                                        .values = holds_light(open.texture.format)
                                                      ? FrameTextures::Values::light
                                                      : FrameTextures::Values::display,
                                        .depth = open.texture.format.depth};
    output_.write(shown, video_options(run_.options()), run_.terminal(), run_.progress());
    open_.erase(i);
  }

  void finish() {
    output_.finish();
    run_.result.update(measures_json(measures_.finish()));
  }

 private:
  struct Frame {
    Texture texture;
    std::weak_ptr<AtlasFrame> atlas;  ///< made again where the filter has let it go: it is large
  };

  /// Once the first texture was read.
  std::shared_ptr<AtlasFrame> atlas_of(int i) const {
    const StoredFrame& stored = reader_.frames()[frames_[i]];
    const EvolvingSegment segment = reader_.segment(stored.segment);
    return std::make_shared<AtlasFrame>(segment, reader_.positions(frames_[i]), width_, height_);
  }

  Texture read(const char* option, int i) {
    const std::string name = frame_name(run_.options().text(option), numbers_[i]);
    Texture texture = read_texture(name);
    const Image<float>& pixels = texture.pixels;
    if (width_ == 0) {
      width_ = pixels.width();
      height_ = pixels.height();
      channels_ = pixels.channels();
    }
    require(
        pixels.width() == width_ && pixels.height() == height_ && pixels.channels() == channels_,
        fmt::format("{}: it has {} × {} texels of {} channels, and the first texture {} × {} "
                    "of {}",
                    name, pixels.width(), pixels.height(), pixels.channels(), width_, height_,
                    channels_));
    return texture;
  }

  Run& run_;
  const EvolvingReader& reader_;
  std::vector<int> frames_, numbers_;
  FrameTextures output_;
  ValueSpace values_;
  int width_ = 0, height_ = 0, channels_ = 0;
  std::map<int, Frame> open_;
  std::shared_ptr<AtlasFrame> last_;
  RelightMeter measures_;
};

struct FirstFrame {
  double weight = 0;  ///< of gradients, from its area
  double texels = 0;  ///< that charts cover
};

FirstFrame first_frame(const OptionValues& options, const EvolvingReader& reader, int frame) {
  const PictureInfo info = picture_info(
      frame_name(options.text("textures"), reader.frames()[std::size_t(frame)].number));
  const EvolvingSegment segment = reader.segment(reader.frames()[frame].segment);
  const Surface surface =
      make_surface(mesh_of(segment, reader.positions(frame)), {.kind = WeldOptions::Kind::none});
  SurfaceScale scale{surface.area, 0};
  double texels = 0;
  if (!segment.uvs.empty()) {
    const Atlas atlas = make_atlas(surface, {{.width = info.width, .height = info.height}});
    scale.texel_spacing = atlas.texel_spacing();
    for (const Chart& chart : atlas.charts) texels += chart.texel_area;
  }
  const double weight = spread_weight(options, scale), alpha = weight / surface.area;
  require(options.text("method") == "mean" || alpha <= most_poisson_alpha,
          fmt::format("--alpha: found {:g}, wanted at most {:g} with --method poisson, whose "
                      "equation rounding makes indefinite beyond; --method mean takes more",
                      alpha, most_poisson_alpha));
  return {weight, texels};
}

TemporalOptions poisson_options(const OptionValues& options, double weight) {
  return {.weight = weight,
          .beta = options.number("beta"),
          .gamma = options.number("gamma"),
          .change = options.number("change"),
          .window = int(options.integer("hold")),
          .accuracy = options.number("accuracy"),
          .solver = {.tolerance = options.number("tolerance")}};
}

/// Refuses what will not fit into memory, by what a texel of a held frame takes at the peak
/// (measured: docs/relight.md).
void require_room(const OptionValues& options, int frames, const FirstFrame& first) {
  const bool mean = options.text("method") == "mean";
  const int radius = int(options.integer("radius"));
  const int held = mean ? std::min(frames, 2 * std::min(radius, frames) + 1)
                        : frames_held(frames, poisson_options(options, first.weight));
  const double bytes = (mean ? 650.0 : 1700.0) * first.texels;
  require_memory(std::int64_t(bytes * held),
                 fmt::format("filtering with {} of {:.0f} texels held at once",
                             counted(held, "frame"), first.texels),
                 fmt::format("use smaller textures, or fewer frames ({})",
                             mean ? "--radius" : "--hold, or a larger --accuracy"));
}

TemporalReport filter(const OptionValues& options, Film& film, double weight,
                      const Progress& progress) {
  const auto load = [&](int i) { return film.load(i); };
  const auto store = [&](int i, const TemporalFrame& frame, const Signal& phi) {
    film.store(i, frame, phi);
  };
  const int count = int(film.numbers().size());
  if (options.text("method") == "mean")
    return remove_lighting(count, load, store,
                           {.weight = weight,
                            .radius = int(options.integer("radius")),
                            .tolerance = options.number("tolerance")},
                           progress);
  return temporal_poisson(count, load, store, poisson_options(options, weight), progress);
}

void refuse_of_other_method(const OptionValues& options) {
  const bool mean = options.text("method") == "mean";
  for (const char* name : {"gamma", "beta", "change", "hold", "accuracy"})
    require(!mean || !asks_for(options, name),
            fmt::format("--{}: only --method poisson has it", name));
  require(mean || !asks_for(options, "radius"), "--radius: only --method mean has it");
}

std::string in_words(const Json& result, const TemporalReport& report) {
  const Json& flicker = result["flicker"];
  std::string text = fmt::format(
      "flicker {:.5f} before, {:.5f} after (from frame to frame {:.5f} and {:.5f}); gradients "
      "times {:.3f}\n{} at most held at once; {:.2g} times the residual per cycle, {} at most\n",
      flicker["before"]["deviation"].get<double>(), flicker["after"]["deviation"].get<double>(),
      flicker["before"]["step"].get<double>(), flicker["after"]["step"].get<double>(),
      result["gradients"].get<double>(), report.held, report.factor, report.solve.cycles);
  if (result.contains("truth"))
    text += fmt::format("error against the truth {:.5f} before, {:.5f} after\n",
                        result["truth"]["before"]["error"].get<double>(),
                        result["truth"]["after"]["error"].get<double>());
  return text;
}

Exit relight(Run& run) {
  const OptionValues& options = run.options();
  refuse_of_other_method(options);
  for (const char* name : {"textures", "truth"})
    require(!options.has(name) || has_frame_place(options.text(name)),
            fmt::format("{}: found '{}', wanted pictures with a place for the frame's number, such "
                        "as texture_%04d.png",
                        name, options.has(name) ? options.text(name) : ""));
  require_video_for_codec(options, names_video(options.text("output")));
  const EvolvingReader reader(options.text("evolving"));
  run.will_read(options.text("evolving"));
  warn_of_broken(run.terminal(), reader);
  require_atlas(reader);
  const std::vector<int> frames = wanted_frames(options, reader);
  Film film(run, reader, frames);
  std::optional<PictureInfo> first;
  for (const fs::path& path : film.inputs()) {
    run.will_read(path);
    const PictureInfo info = picture_info(path);
    if (!first) first = info;
    require(info.width == first->width && info.height == first->height,
            fmt::format("{}: it has {} × {} texels, and the first texture {} × {}", path.string(),
                        info.width, info.height, first->width, first->height));
  }
  const fs::path to = options.text("output");
  if (names_video(to)) {
    require_video_options(to, video_options(options));
    require_whole_video(to, first->width, first->height);
  }
  run.will_write(film.outputs(), fs::path(options.text("output")).parent_path());
  run.input = {{"frames", frames.size()}, {"segments", reader.segments().size()}};
  const FirstFrame about = first_frame(options, reader, frames.front());
  const double weight = about.weight;
  require_room(options, int(frames.size()), about);
  if (run.dry_run()) return Exit::done;
  TemporalReport report;
  {
    const Step step(run, "filter", 1);
    report = filter(options, film, weight, step);
  }
  film.finish();
  run.result.update({{"weight", weight},
                     {"windows", report.windows},
                     {"held", report.held},
                     {"look_ahead", report.look_ahead},
                     {"factor", report.factor}});
  run.solve = solve_json(report.solve);
  run.add_seconds("solver set-up", report.solve.setup_seconds);
  run.add_seconds("solver", report.solve.solve_seconds);
  run.print(in_words(run.result, report));
  if (!report.solve.converged)
    run.terminal().warning(
        "a solve did not reach --tolerance: the result is less accurate than "
        "asked for");
  say_written(run, film.outputs());
  return Exit::done;
}

void add_time_options(OptionTable& table) {
  using Type = Option::Type;
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
  add_spread_options(table, "5e-6", "Filter",
                     "weight of gradients in space against values of the mean or the frame", false,
                     "0 takes all from the mean, and leaves the frames to --gamma alone.");
  table.add({.name = "radius",
             .type = Type::integer,
             .default_value = "10",
             .unit = "frames",
             .least = 0,
             .most = 1000,
             .group = "Mean",
             .help = "how far a mean reaches to either side"});
  table.add({.name = "gamma",
             .type = Type::number,
             .default_value = "4",
             .unit = "frames squared",
             .least = 0,
             .most = 1e6,
             .group = "Poisson",
             .help = "weight of changes in time against values",
             .details = "Values spread over about its square root to either side."});
  table.add({.name = "beta",
             .type = Type::number,
             .default_value = "1",
             .least = -1000,
             .most = 1000,
             .group = "Poisson",
             .help = "gradients in space times this: below 1 smooths, above sharpens"});
  table.add({.name = "change",
             .type = Type::number,
             .default_value = "0",
             .least = -1000,
             .most = 1000,
             .group = "Poisson",
             .help = "changes in time times this: 0 takes them out, 1 leaves them"});
  table.add({.name = "accuracy",
             .type = Type::number,
             .default_value = "0.01",
             .least = 1e-12,
             .most = 0.9,
             .group = "Poisson",
             .help = "what may be lost of values in frames that are too far ahead to be held"});
  table.add({.name = "hold",
             .type = Type::integer,
             .default_value = "0",
             .unit = "frames",
             .least = 0,
             .most = 1000000,
             .group = "Poisson",
             .help = "how many are held at once, 0: what --accuracy needs, twice, and 8"});
}

}  // namespace

Verb relight_verb() {
  using Type = Option::Type;
  OptionTable table(
      "relight",
      "Take light that comes and goes, or flicker, out of the textures of an evolving "
      "mesh.");
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
  add_rate_option(table);
  add_codec_option(table);
  add_time_options(table);
  add_space_option(table);
  table.add({.name = "tolerance",
             .type = Type::number,
             .default_value = "1e-5",
             .least = 1e-14,
             .most = 0.1,
             .group = "Solver",
             .help = "relative residual at which iterations stop"});
  table.add({.name = "truth",
             .type = Type::path,
             .group = "Measuring",
             .help = "true_%04d.png: what the textures should be; the report says how near they "
                     "come, up to one factor"});
  return {table, relight};
}

}  // namespace mq::app

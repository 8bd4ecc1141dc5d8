#include "mq/model/relit_sequence.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <utility>

#include "mq/atlas/atlas.h"
#include "mq/base/error.h"
#include "mq/base/memory.h"
#include "mq/base/option_names.h"
#include "mq/base/words.h"
#include "mq/io/frame_files.h"
#include "mq/io/image_file.h"
#include "mq/model/frame_textures.h"
#include "mq/model/stored_frames.h"
#include "mq/video/gutter.h"

namespace mq {
namespace {

namespace fs = std::filesystem;

constexpr double most_poisson_alpha = 1e5;

/// What a texel of a held frame takes at the peak, measured: docs/relight.md.
constexpr double mean_bytes = 650, poisson_bytes = 1700;

/// What following drift adds to that, and what finding it takes once.
constexpr double drift_bytes = 150, flow_bytes = 1700;

/// Measured with two balls at 512 × 512 texels, where filtering takes 1.1 s a frame by means and 2.1 s all at once.
const FrameCosts mean_costs{.load = 0.3, .store = 0.4}, poisson_costs{.load = 0.2, .store = 0.2};

/// What drift adds to that: a flow where charts stay, and lookups along it in every frame.
struct DriftCosts {
  double flow, lookups;
};
constexpr DriftCosts drift_of_means{7.5, 1.5}, drift_of_all{4, 0.2};

/// The frames that are asked for, read as they are wanted and written as they are done.
class RelitFrames {
 public:
  RelitFrames(const EvolvingReader& reader, const std::vector<int>& frames,
              const RelightFiles& files, const RelightOptions& options, Messages& messages,
              const Progress& progress)
      : reader_(reader),
        frames_(frames),
        files_(files),
        output_(files.output),
        values_(options.values),
        drift_(options.drift),
        first_(options.first),
        end_(options.end),
        messages_(messages),
        progress_(progress) {}

  bool is_written(int i) const { return i >= first_ && i < end_; }

  TemporalFrame load(int i, const Progress& progress) {
    Frame frame;
    frame.texture = read(files_.textures, i);
    const std::shared_ptr<AtlasFrame> atlas = atlas_of(i);
    frame.atlas = atlas;
    const TexelSpace& space = atlas->space();
    std::vector<Image<float>> decoded_pixels = {decoded(frame.texture, values_)};
    TemporalFrame result{std::shared_ptr<const SignalSpace>(atlas, &space),
                         std::make_shared<Texels>(space.texels()),
                         space.gather(decoded_pixels),
                         {},
                         {}};
    if (drift_ != RelightOptions::Drift::ignore) {
      const auto drift = std::make_shared<FrameDrift>(atlas, atlas->surface(), atlas->atlas(), space);
      if (last_) frame.onward = {.frame = number(i)};
      if (last_ && stored(i).segment == stored(i - 1).segment)
        frame.onward->fit = drift->follow(space.gather(last_pixels_), result.psi, drift_flow(), progress.step("follow", 0.95));
      frame.drift = drift->field();
      if (drift_ == RelightOptions::Drift::follow) result.drift = drift;
      last_pixels_ = std::move(decoded_pixels);
    }
    if (last_) result.links = texel_links(*last_, *atlas);
    last_ = atlas;
    if (is_written(i)) open_[i] = std::move(frame);
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
    if (!files_.truth.empty()) truth = space.gather(std::vector{read(files_.truth, i).pixels});
    std::optional<FrameDrift> drift;
    if (!open.drift.empty()) {
      drift.emplace(atlas, atlas->surface(), atlas->atlas(), space);
      drift->follow(std::move(open.drift));
    }
    measures_.add(frame, space, was, is, truth.size() > 0 ? &truth : nullptr, drift ? &*drift : nullptr);
    const Image<char> inside = spread_from_charts(space.texels(), pixels[0]);
    output_.write({.number = number(i),
                   .mesh = atlas->surface().mesh,
                   .inside = inside,
                   .pixels = pixels[0],
                   .values = holds_light(open.texture.format) ? FrameTextures::Values::light
                                                              : FrameTextures::Values::display,
                   .depth = open.texture.format.depth},
                  files_.video, messages_, progress_);
    if (open.onward) onward_.push_back(*open.onward);
    open_.erase(i);
  }

  std::vector<FrameOnward> onward() const { return onward_; }

  RelightMeasures finish() {
    output_.finish();
    return measures_.finish();
  }

 private:
  struct Frame {
    Texture texture;
    std::vector<std::array<double, 2>> drift;  ///< field of `FrameDrift`, empty: nothing was followed
    std::optional<FrameOnward> onward;         ///< none in the first
    std::weak_ptr<AtlasFrame> atlas;           ///< made again where the filter has let it go: it is large
  };

  const StoredFrame& stored(int i) const {
    return reader_.frames()[std::size_t(frames_[std::size_t(i)])];
  }
  int number(int i) const { return stored(i).number; }

  /// Once the first texture was read.
  std::shared_ptr<AtlasFrame> atlas_of(int i) const {
    return std::make_shared<AtlasFrame>(reader_.segment(stored(i).segment),
                                        reader_.positions(frames_[std::size_t(i)]), width_,
                                        height_);
  }

  Texture read(const std::string& pictures, int i) {
    const std::string name = frame_name(pictures, number(i));
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

  const EvolvingReader& reader_;
  const std::vector<int>& frames_;
  const RelightFiles& files_;
  FrameTextures output_;
  ValueSpace values_;
  RelightOptions::Drift drift_;
  int first_, end_;
  Messages& messages_;
  const Progress& progress_;
  int width_ = 0, height_ = 0, channels_ = 0;
  std::map<int, Frame> open_;
  std::shared_ptr<AtlasFrame> last_;
  std::vector<Image<float>> last_pixels_;  ///< where drift is followed
  RelightMeter measures_;
  std::vector<FrameOnward> onward_;
};

void require_frame_place(const std::string& name, const std::string& pictures) {
  require(
      has_frame_place(pictures),
      fmt::format("{}: found '{}', wanted pictures with a place for the frame's number, such as "
                  "texture_%04d.png",
                  name, pictures));
}

}  // namespace

SequenceRelighter::SequenceRelighter(const EvolvingReader& reader, std::vector<int> frames,
                                     RelightFiles files, RelightOptions options, Messages& messages)
    : reader_(reader),
      frames_(std::move(frames)),
      numbers_(numbers_of(reader, frames_)),
      files_(std::move(files)),
      options_(std::move(options)),
      messages_(messages) {
  require_frame_place("textures", files_.textures);
  if (!files_.truth.empty()) require_frame_place("truth", files_.truth);
  require_atlas(reader);
  const FrameTextures refuses_other_names(files_.output);
  options_.end = std::min(options_.end, int(frames_.size()));
  require(options_.first >= 0 && options_.first < options_.end, "no frame was asked for");
  read_ = std::max(0, options_.first - reach());
  read_end_ = int(std::min<std::int64_t>(std::ssize(frames_), std::int64_t(options_.end) + reach()));
}

/// How far frames matter for each other.
int SequenceRelighter::reach() const {
  return options_.method == RelightOptions::Method::mean ? options_.radius : look_ahead(poisson_options(0));
}

std::vector<int> SequenceRelighter::numbers(int first, int end) const {
  return {numbers_.begin() + first, numbers_.begin() + end};
}

std::vector<fs::path> SequenceRelighter::inputs() const {
  std::vector<fs::path> paths;
  for (const std::string* pictures : {&files_.textures, &files_.truth})
    if (!pictures->empty())
      for (const int number : numbers(read_, read_end_)) paths.emplace_back(frame_name(*pictures, number));
  return paths;
}

std::vector<fs::path> SequenceRelighter::outputs() const {
  return FrameTextures(files_.output).paths(numbers(options_.first, options_.end));
}

void SequenceRelighter::rehearse() {
  std::optional<PictureInfo> first;
  for (const fs::path& path : inputs()) {
    const PictureInfo info = picture_info(path);
    if (!first) first = info;
    require(info.width == first->width && info.height == first->height,
            fmt::format("{}: it has {} × {} texels, and the first texture {} × {}", path.string(),
                        info.width, info.height, first->width, first->height));
  }
  require(first.has_value(), "no frame was asked for");
  if (names_video(files_.output)) {
    require_video_options(files_.output, files_.video);
    require_whole_video(files_.output, first->width, first->height);
  }
  const FirstFrame about = first_frame(first->width, first->height);
  require_room(about);
  weight_ = about.weight;
}

SequenceRelighter::FirstFrame SequenceRelighter::first_frame(int width, int height) const {
  const int frame = frames_.front();
  const EvolvingSegment segment = reader_.segment(reader_.frames()[std::size_t(frame)].segment);
  const Surface surface =
      make_surface(mesh_of(segment, reader_.positions(frame)), {.kind = WeldOptions::Kind::none});
  SurfaceScale scale{surface.area, 0};
  double texels = 0;
  if (!segment.uvs.empty()) {
    const Atlas atlas = make_atlas(surface, {{.width = width, .height = height}});
    scale.texel_spacing = atlas.texel_spacing();
    for (const Chart& chart : atlas.charts) texels += chart.texel_area;
  }
  const double weight = weight_from_length(options_.spread, scale), alpha = weight / surface.area;
  require(options_.method == RelightOptions::Method::mean || alpha <= most_poisson_alpha,
          fmt::format("{}: found {:g}, wanted at most {:g} with {}, whose equation rounding makes "
                      "indefinite beyond; {} takes more",
                      option_name("alpha"), alpha, most_poisson_alpha,
                      option_name("method") + " poisson", option_name("method") + " mean"));
  return {weight, texels};
}

TemporalOptions SequenceRelighter::poisson_options(double weight) const {
  TemporalOptions poisson = options_.poisson;
  poisson.weight = weight;
  poisson.solver.tolerance = options_.tolerance;
  return poisson;
}

void SequenceRelighter::require_room(const FirstFrame& first) const {
  const bool mean = options_.method == RelightOptions::Method::mean;
  const int frames = read_end_ - read_;
  const int held = mean ? std::min(frames, 2 * std::min(options_.radius, frames) + 1)
                        : frames_held(frames, poisson_options(first.weight));
  double bytes = (mean ? mean_bytes : poisson_bytes) * held;
  if (options_.drift != RelightOptions::Drift::ignore) bytes += drift_bytes * held + flow_bytes;
  require_memory(std::int64_t(bytes * first.texels),
                 fmt::format("filtering with {} of {:.0f} texels held at once",
                             counted(held, "frame"), first.texels),
                 fmt::format("use smaller textures, or fewer frames ({})",
                             mean ? option_name("radius")
                                  : fmt::format("{}, or a larger {}", option_name("window"),
                                                option_name("accuracy"))));
}

/// Of these frames.
FrameCosts SequenceRelighter::costs(int first, int end) const {
  const bool mean = options_.method == RelightOptions::Method::mean;
  FrameCosts costs = mean ? mean_costs : poisson_costs;
  if (options_.drift == RelightOptions::Drift::ignore) return costs;
  const DriftCosts& drift = mean ? drift_of_means : drift_of_all;
  costs.store += drift.lookups;
  const auto segment = [&](int i) { return reader_.frames()[std::size_t(frames_[std::size_t(i)])].segment; };
  costs.more.assign(std::size_t(end - first), 0);
  for (int i = std::max(first, read_) + 1; i < end; ++i)
    if (segment(i) == segment(i - 1)) costs.more[std::size_t(i - first)] = drift.flow;
  return costs;
}

RelitSequence SequenceRelighter::run(const Progress& progress) {
  if (!weight_) rehearse();
  const double weight = *weight_;
  RelitFrames film(reader_, frames_, files_, options_, messages_, progress);
  const auto load = [&](int i, const Progress& reading) { return film.load(i, reading); };
  const auto store = [&](int i, const TemporalFrame& frame, const Signal& phi) {
    if (film.is_written(i)) film.store(i, frame, phi);
  };
  RelitSequence found{.weight = weight, .filter = {}, .measures = {}};
  TemporalOptions poisson = poisson_options(weight);
  poisson.costs = costs(read_, read_end_);
  found.filter =
      options_.method == RelightOptions::Method::mean
          ? remove_lighting(int(frames_.size()), load, store,
                            {.weight = weight,
                             .radius = options_.radius,
                             .tolerance = options_.tolerance,
                             .crossover = options_.crossover,
                             .first = options_.first,
                             .end = options_.end,
                             .costs = costs(0, int(frames_.size()))},
                            progress)
          : temporal_poisson(
                read_end_ - read_, [&](int i, const Progress& reading) { return load(read_ + i, reading); },
                [&](int i, const TemporalFrame& frame, const Signal& phi) { store(read_ + i, frame, phi); },
                poisson, progress);
  found.measures = film.finish();
  found.onward = film.onward();
  return found;
}

}  // namespace mq

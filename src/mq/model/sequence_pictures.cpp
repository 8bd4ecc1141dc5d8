#include "mq/model/sequence_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <unordered_map>
#include <utility>

#include "mq/draw/contact_sheet.h"
#include "mq/draw/frame_strip.h"
#include "mq/draw/line_plot.h"
#include "mq/io/vertex_colours.h"
#include "mq/mesh/closest_point.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

constexpr int most_columns = 8;
constexpr float added_later = 0.55F;  // grey
constexpr double unknown = FollowedFrame::unknown;

/// A number of each frame, NaN where it is not known.
template <class Of>
std::vector<double> numbers(const std::vector<FollowedFrame>& frames, Of of) {
  std::vector<double> result;
  for (const FollowedFrame& frame : frames) result.push_back(of(frame));
  return result;
}

double count(int known) { return known < 0 ? unknown : double(known); }

/// Those of a panel's lines of which some frame has a number that is not 0, each in the colour it
/// always has.
std::vector<PlotLine> known(std::vector<PlotLine> lines) {
  for (std::size_t i = 0; i < lines.size(); ++i) lines[i].colour = int(i);
  std::erase_if(lines, [](const PlotLine& line) {
    return std::ranges::none_of(line.values, [](double v) { return std::isfinite(v) && v != 0; });
  });
  return lines;
}

/// How many of 100 triangles live on from the frame before; NaN where there is none.
double kept_share(const FollowedFrame& frame) {
  const double kept = count(frame.kept);
  return 100 * kept / (kept + count(frame.removed));
}

/// The next ten below the least of them.
double tenth_below(const std::vector<double>& shares) {
  double least = 100;
  for (const double share : shares)
    if (std::isfinite(share)) least = std::min(least, share);
  return std::max(0.0, 10 * (std::ceil(least / 10) - 1));
}

std::vector<PlotLine> time_lines(const std::vector<FollowedFrame>& frames) {
  const auto of_match = [&](auto of) {
    return numbers(frames,
                   [&](const FollowedFrame& f) { return f.match ? of(*f.match) : unknown; });
  };
  using Match = FollowedFrame::Match;
  return {{"all", numbers(frames, [](const FollowedFrame& f) { return f.seconds; })},
          {"follow", of_match([](const Match& m) { return m.seconds.total; })},
          {"colours", of_match([](const Match& m) { return m.seconds.colour; })},
          {"remesh", of_match([](const Match& m) { return m.remesh_seconds.value_or(unknown); })}};
}

std::vector<PlotPanel> panels_of(const std::vector<FollowedFrame>& frames) {
  using Frame = FollowedFrame;
  const auto of = [&](auto number) { return numbers(frames, number); };
  const std::vector<double> shares = of(kept_share);
  std::vector<double> added = of([](const Frame& f) { return count(f.added); });
  if (!added.empty()) added[0] = unknown;  // all of them are
  std::vector<PlotPanel> panels = {
      {.title = "distance [% of the diagonal]",
       .lines = {{"mean", of([](const Frame& f) { return 100 * f.distance.mean; })},
                 {"95 %", of([](const Frame& f) { return 100 * f.distance.p95; })},
                 {"largest", of([](const Frame& f) { return 100 * f.distance.max; })}},
       .scale = PlotPanel::Scale::logarithmic},
      {.title = "triangles kept [%]",
       .lines = {{"of the frame before", shares}},
       .base = tenth_below(shares)},
      {.title = "triangles",
       .lines = {{"added", added},
                 {"removed", of([](const Frame& f) { return count(f.removed); })}},
       .scale = PlotPanel::Scale::logarithmic},
      {.title = "distortion since rest [ratio]",
       .lines = {{"mean", of([](const Frame& f) { return f.distortion.mean; })},
                 {"95 %", of([](const Frame& f) { return f.distortion.p95; })}},
       .base = 1},
      {.title = "time [s]", .lines = time_lines(frames)},
      {.title = "drift [mean edges]", .lines = {{"mean", of([](const Frame& f) {
                                                   return f.drift ? f.drift->mean_edges : unknown;
                                                 })}}}};
  std::erase_if(panels, [](PlotPanel& panel) {
    panel.lines = known(std::move(panel.lines));
    return panel.lines.empty();
  });
  return panels;
}

/// The least of 1, 2 and 5 times a power of ten that is not below it.
double rounded_up(double value) {
  if (!(value > 0)) return 1;
  const double power = std::pow(10, std::floor(std::log10(value)));
  for (const double digit : {1.0, 2.0, 5.0})
    if (digit * power >= value * (1 - 1e-9)) return digit * power;
  return 10 * power;
}

std::vector<float> values_of(const Signal& colours) {
  std::vector<float> values;
  if (colours.cols() == 0) return values;
  for (Eigen::Index v = 0; v < colours.rows(); ++v)
    for (int c = 0; c < 3; ++c) values.push_back(float(std::clamp(colours(v, c), 0.0, 1.0)));
  return values;
}

/// What the first frame shows where vertices are, by their ids.
std::unordered_map<int, Colour> first_colours(const EvolvingReader& reader, const Model& captured) {
  const EvolvingSegment segment = reader.segment(reader.frames().front().segment);
  const Mesh mesh = mesh_of(segment, reader.positions(0));
  std::vector<float> values = colours_of_places(mesh);
  if (const Signal colours = vertex_colours(captured); colours.cols() > 0) {
    values.clear();
    for (const ClosestPoint& p : ClosestPointFinder(captured.mesh)(mesh.positions))
      for (int c = 0; c < 3; ++c) {
        const double colour = interpolate(p.barycentric, [&](int k) {
          return colours(captured.mesh.triangles[p.triangle][k], c);
        });
        values.push_back(float(std::clamp(colour, 0.0, 1.0)));
      }
  }
  std::unordered_map<int, Colour> result;
  for (std::size_t v = 0; v < segment.vertex_ids.size(); ++v)
    result[segment.vertex_ids[v]] = {values[3 * v], values[3 * v + 1], values[3 * v + 2]};
  return result;
}

/// Of so many frames, some that are evenly spread, with the first and the last.
std::vector<int> spread_frames(int count) {
  const int columns = std::min(count, most_columns);
  std::vector<int> frames;
  for (int i = 0; i < columns; ++i)
    frames.push_back(columns == 1 ? 0 : int(std::int64_t(i) * (count - 1) / (columns - 1)));
  return frames;
}

Mesh stored_mesh(const EvolvingReader& reader, int frame) {
  return mesh_of(reader.segment(reader.frames()[std::size_t(frame)].segment),
                 reader.positions(frame));
}

/// Of the vertices of a frame, those they have in the first one.
std::vector<float> followed_colours(const EvolvingReader& reader, int frame,
                                    const std::unordered_map<int, Colour>& colours) {
  const EvolvingSegment segment = reader.segment(reader.frames()[std::size_t(frame)].segment);
  std::vector<float> values;
  for (const int id : segment.vertex_ids) {
    const auto found = colours.find(id);
    const Colour colour =
        found == colours.end() ? Colour{added_later, added_later, added_later} : found->second;
    values.insert(values.end(), colour.begin(), colour.end());
  }
  return values;
}

}  // namespace

Image<float> sequence_plot(const std::vector<FollowedFrame>& frames) {
  const std::vector<PlotPanel> panels = panels_of(frames);
  if (panels.empty()) return {};
  LinePlotOptions options{.marked = "triangles replaced"};
  for (std::size_t f = 1; f < frames.size(); ++f)
    if (frames[f].added > 0) options.marks.push_back(double(frames[f].number));
  return line_plot(numbers(frames, [](const FollowedFrame& f) { return double(f.number); }), panels,
                   options);
}

Image<float> sequence_strip(const EvolvingReader& reader,
                            const std::function<Model(int frame)>& captured, const View& view,
                            const Progress& progress) {
  const std::vector<int> frames = spread_frames(int(reader.frames().size()));
  double extent = 0, worst = 0;
  for (const int f : frames) {
    extent = std::max(extent, bounding_box(stored_mesh(reader, f)).diagonal());
    const StoredFrame& stored = reader.frames()[std::size_t(f)];
    worst = std::max(worst, followed_frame(stored.number, stored.measured).distance.p95);
  }
  const double most = rounded_up(2 * worst);  // of the diagonal
  StripOptions options{.view = view, .extent = extent};

  std::unordered_map<int, Colour> colours;
  std::array<std::vector<Tile>, 3> rows;
  for (const int f : frames) {
    const Model model = captured(f);
    if (colours.empty()) colours = first_colours(reader, model);
    const Mesh mesh = stored_mesh(reader, f);
    const std::vector<float> values = followed_colours(reader, f, colours);
    const std::vector<float> own = values_of(vertex_colours(model));
    options.most = most * bounding_box(model.mesh).diagonal();
    std::array<Image<float>, 3> pictures =
        draw_strip_frame({.captured = model.mesh,
                          .captured_colours = own,
                          .followed = mesh,
                          .followed_colours = values},
                         options, progress.step("strip", 1.0 / double(frames.size())));
    for (std::size_t row = 0; row < 3; ++row)
      rows[row].push_back(
          {std::move(pictures[row]),
           row == 0 ? fmt::format("frame {}", reader.frames()[std::size_t(f)].number) : ""});
  }
  std::vector<Tile> tiles;
  for (std::vector<Tile>& row : rows) std::ranges::move(row, std::back_inserter(tiles));
  return contact_sheet(
      tiles, {.columns = int(frames.size()),
              .gap = 6,
              .text_scale = 1,
              .title = fmt::format("captured; followed; distance, light: {:g} % of the diagonal",
                                   100 * most)});
}

}  // namespace mq

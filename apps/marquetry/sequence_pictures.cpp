#include "sequence_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "mq/base/error.h"
#include "mq/draw/contact_sheet.h"
#include "mq/draw/frame_strip.h"
#include "mq/draw/line_plot.h"
#include "mq/io/file_names.h"
#include "mq/io/image_file.h"
#include "mq/io/vertex_colours.h"
#include "mq/mesh/closest_point.h"
#include "mq/mesh/geometry.h"
#include "shell/results.h"
#include "render_request.h"

namespace mq::app {
namespace {

constexpr const char* wanted_picture = "a picture: .png, .jpg, .tif, .exr, .bmp or .tga";
constexpr int most_columns = 8;
constexpr float added_later = 0.55F;  // grey

/// A number of each frame, times `factor`; not a number where a frame has none. `name` may lead
/// into an object: "seconds.all".
std::vector<double> numbers(const Json& frames, const std::string& name, double factor = 1) {
  const std::size_t dot = name.find('.');
  std::vector<double> result;
  for (const Json& frame : frames) {
    const Json* at = &frame;
    for (const std::string& word : dot == std::string::npos
                                       ? std::vector{name}
                                       : std::vector{name.substr(0, dot), name.substr(dot + 1)})
      at = at->is_object() && at->contains(word) ? &at->at(word) : nullptr;
    result.push_back(at != nullptr && at->is_number() ? factor * at->get<double>()
                                                      : std::numeric_limits<double>::quiet_NaN());
  }
  return result;
}

/// Those of a panel's lines of which some frame has a number that is not 0, each in the colour it
/// always has.
std::vector<PlotLine> known(std::vector<PlotLine> lines) {
  for (std::size_t i = 0; i < lines.size(); ++i) lines[i].colour = int(i);
  std::erase_if(lines, [](const PlotLine& line) {
    return std::ranges::none_of(line.values, [](double v) { return std::isfinite(v) && v != 0; });
  });
  return lines;
}

/// How many of 100 triangles live on from the frame before; not a number where there is none.
std::vector<double> kept_shares(const Json& frames) {
  const std::vector<double> kept = numbers(frames, "triangles_kept"),
                            removed = numbers(frames, "triangles_died");
  std::vector<double> shares;
  for (std::size_t f = 0; f < kept.size(); ++f)
    shares.push_back(100 * kept[f] / (kept[f] + removed[f]));
  return shares;
}

/// The next ten below the least of them.
double tenth_below(const std::vector<double>& shares) {
  double least = 100;
  for (const double share : shares)
    if (std::isfinite(share)) least = std::min(least, share);
  return std::max(0.0, 10 * (std::ceil(least / 10) - 1));
}

std::vector<PlotPanel> panels_of(const Json& frames) {
  const std::vector<double> shares = kept_shares(frames);
  std::vector<double> added = numbers(frames, "triangles_born");
  if (!added.empty()) added[0] = std::numeric_limits<double>::quiet_NaN();  // all of them are
  std::vector<PlotPanel> panels = {
      {.title = "distance [% of the diagonal]",
       .lines = {{"mean", numbers(frames, "distance_mean", 100)},
                 {"95 %", numbers(frames, "distance_p95", 100)},
                 {"largest", numbers(frames, "distance_max", 100)}},
       .scale = PlotPanel::Scale::logarithmic},
      {.title = "triangles kept [%]",
       .lines = {{"of the frame before", shares}},
       .base = tenth_below(shares)},
      {.title = "triangles",
       .lines = {{"born", added}, {"died", numbers(frames, "triangles_died")}},
       .scale = PlotPanel::Scale::logarithmic},
      {.title = "distortion since birth [ratio]",
       .lines = {{"mean", numbers(frames, "distortion_mean")},
                 {"95 %", numbers(frames, "distortion_p95")}},
       .base = 1},
      {.title = "time [s]",
       .lines = {{"all", numbers(frames, "seconds.all")},
                 {"follow", numbers(frames, "seconds.total")},
                 {"colours", numbers(frames, "seconds.colour")},
                 {"remesh", numbers(frames, "seconds.remesh")}}}};
  std::vector<double> drifts;
  for (const Json& frame : frames)
    drifts.push_back(frame.contains("drift") ? frame["drift"].value("mean_edges", 0.0)
                                             : std::numeric_limits<double>::quiet_NaN());
  panels.push_back({.title = "drift [mean edges]", .lines = {{"mean", drifts}}});
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
        double sum = 0;
        for (int k = 0; k < 3; ++k)
          sum += p.barycentric[k] * colours(captured.mesh.triangles[p.triangle][k], c);
        values.push_back(float(std::clamp(sum, 0.0, 1.0)));
      }
  }
  std::unordered_map<int, Colour> result;
  for (std::size_t v = 0; v < segment.vertex_ids.size(); ++v)
    result[segment.vertex_ids[v]] = {values[3 * v], values[3 * v + 1], values[3 * v + 2]};
  return result;
}

}  // namespace

void add_plot_option(OptionTable& table) {
  table.add({.name = "plot",
             .type = Option::Type::text,
             .accepts = [](const std::string& name) { return names_picture(name); },
             .wanted = wanted_picture,
             .metavar = "FILE",
             .group = "Pictures",
             .help = "draw distances, triangles, distortion and time over the frames"});
}

void add_sequence_picture_options(OptionTable& table) {
  add_plot_option(table);
  table.add({.name = "strip",
             .type = Option::Type::text,
             .accepts = [](const std::string& name) { return names_picture(name); },
             .wanted = wanted_picture,
             .metavar = "FILE",
             .group = "Pictures",
             .help = "draw some frames, what follows them, and how far it is from them",
             .details = "In the colours of the first frame, or of places in it where it has none; "
                        "grey where it was born later."});
}

std::vector<std::filesystem::path> sequence_picture_paths(const OptionValues& options) {
  std::vector<std::filesystem::path> paths;
  for (const char* name : {"plot", "strip"})
    if (options.has(name)) paths.emplace_back(options.text(name));
  return paths;
}

Json measured_of(const EvolvingReader& reader) {
  Json frames = Json::array();
  for (const StoredFrame& frame : reader.frames()) {
    Json measured = Json::parse(frame.measured, nullptr, false);
    if (!measured.is_object()) measured = Json::object();
    measured["frame"] = frame.number;
    frames.push_back(std::move(measured));
  }
  return frames;
}

void write_plot(const Run& run, const Json& frames) {
  if (!run.options().has("plot")) return;
  const std::vector<PlotPanel> panels = panels_of(frames);
  require(!panels.empty(), "--plot: nothing was measured of these frames; follow them anew");
  LinePlotOptions options{.marked = "triangles replaced"};
  for (std::size_t f = 1; f < frames.size(); ++f)
    if (frames[f].value("triangles_born", 0) > 0)
      options.marks.push_back(frames[f].at("frame").get<double>());
  write_image(run.options().text("plot"), line_plot(numbers(frames, "frame"), panels, options));
}

void write_strip(const Run& run, const EvolvingReader& reader,
                 const std::function<Model(int frame)>& captured, const Progress& progress) {
  if (!run.options().has("strip")) return;
  const int count = int(reader.frames().size()), columns = std::min(count, most_columns);
  std::vector<int> frames;
  for (int i = 0; i < columns; ++i)
    frames.push_back(columns == 1 ? 0 : int(std::int64_t(i) * (count - 1) / (columns - 1)));
  double extent = 0, worst = 0;
  for (const int f : frames) {
    const Mesh mesh =
        mesh_of(reader.segment(reader.frames()[std::size_t(f)].segment), reader.positions(f));
    extent = std::max(extent, bounding_box(mesh).diagonal());
    const Json measured = Json::parse(reader.frames()[std::size_t(f)].measured, nullptr, false);
    if (measured.is_object()) worst = std::max(worst, measured.value("distance_p95", 0.0));
  }
  const double most = rounded_up(2 * worst);  // of the diagonal
  StripOptions options{.view = parse_view(run.options().text("view")), .extent = extent};

  std::unordered_map<int, Colour> colours;
  std::array<std::vector<Tile>, 3> rows;
  for (const int f : frames) {
    const Model model = captured(f);
    if (colours.empty()) colours = first_colours(reader, model);
    const EvolvingSegment segment = reader.segment(reader.frames()[std::size_t(f)].segment);
    const Mesh mesh = mesh_of(segment, reader.positions(f));
    std::vector<float> values;
    for (const int id : segment.vertex_ids) {
      const auto found = colours.find(id);
      const Colour colour =
          found == colours.end() ? Colour{added_later, added_later, added_later} : found->second;
      values.insert(values.end(), colour.begin(), colour.end());
    }
    const std::vector<float> own = values_of(vertex_colours(model));
    options.most = most * bounding_box(model.mesh).diagonal();
    std::array<Image<float>, 3> pictures =
        draw_strip_frame({.captured = model.mesh,
                          .captured_colours = own,
                          .followed = mesh,
                          .followed_colours = values},
                         options, progress.step("strip", 1.0 / columns));
    for (std::size_t row = 0; row < 3; ++row)
      rows[row].push_back(
          {std::move(pictures[row]),
           row == 0 ? fmt::format("frame {}", reader.frames()[std::size_t(f)].number) : ""});
  }
  std::vector<Tile> tiles;
  for (std::vector<Tile>& row : rows) std::ranges::move(row, std::back_inserter(tiles));
  write_image(run.options().text("strip"),
              contact_sheet(
                  tiles, {.columns = columns,
                          .gap = 6,
                          .text_scale = 1,
                          .title = fmt::format("captured; followed; distance, light: {:g} % of the "
                                               "diagonal",
                                               100 * most)}));
}

}  // namespace mq::app

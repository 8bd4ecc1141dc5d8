// A picture is made in bands of pixel rows, each by one task: rays through a regular grid of
// samples, light on what they hit, lines over it, the mean per pixel. Bands overlap by the rows
// that decide whether a line is hidden, so no band needs another. Pictures with one camera share
// rays and light, which take most of the time.

#include "mq/draw/render.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/draw/corner_normals.h"
#include "mq/draw/detail/lines.h"
#include "mq/draw/detail/shader.h"
#include "mq/draw/scene.h"
#include "mq/draw/detail/textures.h"
#include "mq/image/resample.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

using Paint = RenderOptions::Paint;
using Lines = RenderOptions::Lines;

constexpr int band_pixels = 24;  ///< rows of pixels per band

enum Style { wire, end, seam, style_count };

/// The style of lines in space of that colour; how many there are where none is.
std::size_t style_of(const std::vector<LineStyle>& styles, const Colour& colour) {
  std::size_t k = style_count;
  while (k < styles.size() && styles[k].colour != colour) ++k;
  return k;
}

std::vector<LineStyle> line_styles(const RenderOptions& options) {
  const float half = float(options.line_width * options.samples / 2);
  std::vector<LineStyle> styles(style_count);
  styles[wire] = {{0.05f, 0.05f, 0.07f}, 0.55f, half / 3, 0, {}, 0};
  styles[end] = {{0.25f, 0.65f, 1.f}, 1, half, 0.7f * half, {0.02f, 0.03f, 0.05f}, 0.65f};
  styles[seam] = {{1.f, 0.45f, 0.05f}, 1, half, 0.7f * half, {0.05f, 0.03f, 0.02f}, 0.65f};
  for (const SpaceLine& line : options.lines)
    if (style_of(styles, line.colour) == styles.size())
      styles.push_back({line.colour, 1, 0.75F * half, 0.5F * half, {1, 1, 1}, 0.5F});
  return styles;
}

/// The edges drawn as lines, each once.
struct Edge {
  int from, to, style;
};

std::vector<Edge> edges_of(const Surface& surface, const Atlas* atlas,
                           const RenderOptions& options) {
  std::vector<Edge> edges;
  const Mesh& mesh = surface.mesh;
  for (HalfEdge h = 0; h < 3 * mesh.triangle_count(); ++h) {
    const int t = h / 3, twin = surface.twins[h];
    if (surface.degenerate[t]) continue;
    const bool first = twin < 0 || surface.degenerate[twin / 3] || h < twin;
    const Edge edge{mesh.triangles[t][h % 3], mesh.triangles[t][(h % 3 + 1) % 3], wire};
    if (options.wires == Lines::show && first) edges.push_back(edge);
    if (options.seams != Lines::show) continue;
    if (atlas != nullptr && atlas->chart[t] >= 0) {
      if (atlas->edges[h] == EdgeKind::seam && h < twin)
        edges.push_back({edge.from, edge.to, seam});
      if (atlas->edges[h] == EdgeKind::boundary) edges.push_back({edge.from, edge.to, end});
    } else if (twin < 0) {
      edges.push_back({edge.from, edge.to, end});
    }
  }
  return edges;
}

/// Appends the part that lies in front of the camera, which may stand amid the model.
void add_projected_line(const Vector3& from, const Vector3& to, const Camera& camera, int samples, int style,
                        std::vector<ScreenLine>& lines) {
  constexpr double nearest = 1e-4;  // of the depth of the farther end
  Camera::Projected a = camera.project(from), b = camera.project(to);
  const double near = nearest * std::max(a.depth, b.depth);
  if (camera.is_perspective() && std::min(a.depth, b.depth) < near) {
    const Vector3 cut = from + (near - a.depth) / (b.depth - a.depth) * (to - from);
    (a.depth < near ? a : b) = camera.project(cut);
  }
  if (camera.is_perspective() && !(near > 0)) return;
  const float s = float(samples);
  lines.push_back({float(a.x) * s, float(a.y) * s, float(a.depth), float(b.x) * s, float(b.y) * s, float(b.depth),
                   style});
}

std::vector<ScreenLine> projected(const Mesh& mesh, const std::vector<Edge>& edges,
                                  const RenderOptions& options,
                                  const std::vector<LineStyle>& styles, const Camera& camera) {
  std::vector<ScreenLine> lines;
  lines.reserve(edges.size() + options.lines.size());
  for (const Edge& edge : edges)
    add_projected_line(mesh.positions[edge.from], mesh.positions[edge.to], camera, options.samples, edge.style,
                       lines);
  for (const SpaceLine& line : options.lines)
    add_projected_line(line.from, line.to, camera, options.samples, int(style_of(styles, line.colour)), lines);
  return lines;
}

/// A camera whose view holds the lines too, as triangles without area.
Camera camera_with_lines(const Mesh& mesh, const RenderOptions& options, int right_inset) {
  if (options.lines.empty())
    return {mesh, options.view, options.width, options.height, right_inset};
  Mesh all;
  all.positions = mesh.positions, all.triangles = mesh.triangles;
  for (const SpaceLine& line : options.lines) {
    const int from = all.vertex_count();
    all.positions.push_back(line.from), all.positions.push_back(line.to);
    all.triangles.push_back({from, from + 1, from + 1});
  }
  return {all, options.view, options.width, options.height, right_inset};
}

/// One of the pictures that are drawn together.
struct Drawing {
  const RenderOptions& options;
  Shader shader;
  std::vector<LineStyle> styles;
  std::vector<ScreenLine> lines;
  std::vector<std::vector<int>> lines_of;  ///< per band
  int like = -1;                           ///< an earlier one that differs by its lines alone; -1: none
  Image<float> picture;

  bool isolines() const { return shows_numbers(options) && options.scale.isolines > 0; }
  bool is_lit() const { return options.light == RenderOptions::Light::studio; }
  bool covers_like(const Drawing& other) const {
    return !shows_numbers(options) && options.paint == other.options.paint && options.light == other.options.light;
  }
};

/// What the rays of a row of samples hit, and the light there where somebody wants it.
struct ShotRow {
  std::vector<Hit> hits;
  std::vector<LightAt> lights;
};

void shoot(const Scene& scene, const Shader& shader, int samples, int row, ShotRow& shot) {
  const double step = 1.0 / samples;
  for (int x = 0; x < int(shot.hits.size()); ++x) {
    shot.hits[x] = scene.hit(shader.camera.ray((x + 0.5) * step, (row + 0.5) * step));
    if (!shot.lights.empty() && shot.hits[x].triangle >= 0) shot.lights[x] = shader.light_at(shot.hits[x]);
  }
}

/// A band of one of the pictures.
struct DrawnBand {
  SampleBand samples;
  std::vector<int> levels;  ///< between isolines, -1: of nothing

  bool holds(int row) const { return row >= samples.first_row && row < samples.first_row + samples.rows; }

  void shade(const Drawing& drawing, const ShotRow& shot, int row, const DrawnBand* like) {
    for (int x = 0; x < samples.width; ++x) {
      const Hit& hit = shot.hits[x];
      const std::size_t at = samples.at(x, row);
      if (!samples.depths.empty())
        samples.depths[at] = hit.triangle < 0 ? std::numeric_limits<float>::infinity()
                                              : float(drawing.shader.camera.project(hit.point).depth);
      if (hit.triangle < 0) continue;
      if (like != nullptr && like->holds(row)) {
        samples.colours[at] = like->samples.colours[like->samples.at(x, row)];
        continue;
      }
      Colour colour = drawing.shader.albedo(hit);
      if (drawing.is_lit()) colour = drawing.shader.lit(colour, shot.lights[x]);
      samples.colours[at] = {colour[0], colour[1], colour[2], 1};
      if (const auto value = levels.empty() ? std::nullopt : drawing.shader.number(hit))
        levels[at] = isoline_band(*value, drawing.options.scale);
    }
  }

  /// Darkens the samples whose isoline band is not that of a neighbour on the same surface.
  void draw_isolines(const RenderOptions& options, float depth_slack) {
    const int width = std::max(1, int(std::lround(0.5 * options.line_width * options.samples)));
    for (int row = samples.first_row; row < samples.first_row + samples.rows; ++row)
      for (int x = 0; x < samples.width; ++x) {
        const std::size_t at = samples.at(x, row);
        const auto differs = [&](int other_x, int other_row) {
          if (other_x >= samples.width || other_row >= samples.first_row + samples.rows) return false;
          const std::size_t other = samples.at(other_x, other_row);
          return levels[other] >= 0 && levels[other] != levels[at] &&
                 std::abs(samples.depths[other] - samples.depths[at]) < depth_slack;
        };
        bool line = false;
        for (int k = 1; k <= width && levels[at] >= 0 && !line; ++k)
          line = differs(x + k, row) || differs(x, row + k);
        if (line) samples.colours[at] = {0.1f, 0.1f, 0.12f, 1};
      }
  }
};

/// The rows of pixels that every picture's band `b` has, with those around them that decide what lines show.
DrawnBand new_band(const Drawing& drawing, int b) {
  const RenderOptions& options = drawing.options;
  const int begin = b * band_pixels, end = std::min(begin + band_pixels, options.height);
  const int margin = int(std::ceil(drawing.styles[seam].half_width + drawing.styles[seam].casing)) + 2;
  const int extra = drawing.lines_of[b].empty() && !drawing.isolines() ? 0 : margin;
  DrawnBand band{SampleBand(options.width * options.samples, begin * options.samples - extra,
                            (end - begin) * options.samples + 2 * extra),
                 {}};
  if (extra > 0) band.samples.depths.resize(band.samples.colours.size());
  if (drawing.isolines()) band.levels.assign(band.samples.colours.size(), -1);
  return band;
}

void check_channel(const Paints& paints, int channel) {
  for (std::size_t k = 0; k < paints.textures.size(); ++k)
    if (channel < 0 || channel >= paints.textures[k]->channels())
      throw InvalidInput(fmt::format("texture {} has {} channels: there is no channel {}", k,
                                     paints.textures[k]->channels(), channel));
}

void check(const Surface& surface, const Atlas* atlas, const Paints& paints,
           const RenderOptions& options) {
  const auto within = [](int value, int most) { return value >= 1 && value <= most; };
  if (!within(options.width, 16384) || !within(options.height, 16384))
    throw InvalidInput(fmt::format("a picture of {} x {} pixels cannot be drawn: 1 to 16384 a side",
                                   options.width, options.height));
  require(within(options.samples, 16), "samples per pixel and direction are from 1 to 16");
  require(options.line_width > 0 && options.line_width <= 100,
          "the width of lines is above 0 and at most 100 pixels");
  const bool texture = options.paint == Paint::texture || options.paint == Paint::texture_numbers;
  require(atlas != nullptr || (!texture && options.paint != Paint::charts),
          "a surface without texture coordinates has no textures and charts to show");
  if (texture) check_textures(*atlas, paints.textures);
  if (options.paint == Paint::texture_numbers) check_channel(paints, options.channel);
  const std::size_t each = options.paint == Paint::vertex_colours   ? 3
                           : options.paint == Paint::vertex_numbers ? 1
                                                                    : 0;
  if (each > 0 && paints.vertex_values.size() != each * std::size_t(surface.mesh.vertex_count()))
    throw InvalidInput(fmt::format("{} values are given for {} vertices, {} wanted for each",
                                   paints.vertex_values.size(), surface.mesh.vertex_count(), each));
}

Image<float> legend_for(const RenderOptions& options) {
  const int text_scale = std::max(1, int(std::lround(options.height / 400.0)));
  LegendOptions wanted;
  wanted.text_scale = text_scale;
  wanted.title = options.legend_title;
  wanted.height =
      std::clamp(options.height * 3 / 5, std::min(options.height, 60 * text_scale), options.height);
  return legend(options.scale, wanted);
}

void put_legend(const Image<float>& legend, const RenderOptions& options, Image<float>& picture) {
  const int x0 = picture.width() - legend.width() - std::min(options.width, options.height) / 50;
  const int y0 = (picture.height() - legend.height()) / 2;
  for (int y = 0; y < legend.height(); ++y)
    for (int x = 0; x < legend.width(); ++x) {
      const auto pixel = picture.pixel(x0 + x, y0 + y);
      std::ranges::copy(legend.pixel(x, y), pixel.begin());
      if (pixel.size() == 4) pixel[3] = 1;
    }
}

/// Parallel lines of sight on a grid across the picture: what they meet near the place is open.
void look(const Surface& surface, const Scene& scene, const Vector3& point, Sight& sight) {
  constexpr int half = 4;  // nine by nine lines
  const Vector3 back = direction_of(sight.view), side = back.unitOrthogonal();
  const double extent = sight.view.extent;
  const double far = bounding_box(surface.mesh).diagonal() + extent;
  int near = 0;
  for (int j = -half; j <= half; ++j)
    for (int i = -half; i <= half; ++i) {
      const Vector3 start = point + extent / (2 * half) * (i * side + j * back.cross(side));
      const Hit hit = scene.hit({start + far * back, -back});
      const double distance = hit.triangle < 0 ? far : (hit.point - point).norm();
      near += distance < 0.75 * extent;
      if (i == 0 && j == 0) sight.clear = distance < 0.02 * extent;
    }
  sight.open = near / double((2 * half + 1) * (2 * half + 1));
}

}  // namespace

struct Renderer::Shared {
  const Surface& surface;
  const Atlas* atlas;
  Scene scene;
  std::vector<Eigen::Vector3f> normals;
};

Renderer::Renderer(const Surface& surface, const Atlas* atlas)
    : shared_(new Shared{surface, atlas, Scene(surface), corner_normals(surface.mesh)}) {}

Renderer::~Renderer() = default;

const Surface& Renderer::surface() const { return shared_->surface; }

Sight sight_of(const Surface& surface, const Scene& scene, const Vector3& point, const Vector3& normal,
               double extent, View::Up up) {
  constexpr double degrees = 180 / std::numbers::pi;
  const Vector3 n = to_upright(up, normal);
  Sight best;
  best.view.up = up;
  best.view.target = point;
  best.view.extent = extent;
  best.view.azimuth = std::atan2(n.x(), n.z()) * degrees;
  best.view.elevation =
      std::asin(std::clamp(n.y() / std::max(n.norm(), 1e-300), -1.0, 1.0)) * degrees;
  const View straight = best.view;
  double most = 0;
  for (const double tilt : {0.0, 12.0, 25.0, 40.0, 60.0})
    for (int turn = 0; turn < (tilt == 0 ? 1 : 8); ++turn) {
      Sight sight{straight};
      sight.view.azimuth += tilt * std::sin(turn * std::numbers::pi / 4);
      sight.view.elevation = std::clamp(
          sight.view.elevation + tilt * std::cos(turn * std::numbers::pi / 4), -90.0, 90.0);
      look(surface, scene, point, sight);
      const double worth = sight.clear ? sight.open * std::cos(tilt / degrees) : 0;
      if (worth > most) most = worth, best = sight;
    }
  return best;
}

Sight Renderer::sight_of(const Vector3& point, const Vector3& normal, double extent,
                         View::Up up) const {
  return mq::sight_of(shared_->surface, shared_->scene, point, normal, extent, up);
}

namespace {

/// Throws `InvalidInput` unless rays and light are the same for all.
void check_alike(std::span<const RenderOptions> wanted) {
  require(!wanted.empty(), "no picture is asked for: ask for one at least");
  const RenderOptions& first = wanted.front();
  for (const RenderOptions& other : wanted.subspan(1)) {
    require(other.view == first.view && other.width == first.width && other.height == first.height &&
                other.samples == first.samples,
            "pictures that are drawn together have one view and size");
    require(!shows_numbers(other) && !shows_numbers(first) && other.lines.empty() && first.lines.empty(),
            "pictures with legends or lines in space are drawn one by one");
  }
}

std::vector<Drawing> drawings_of(std::span<const RenderOptions> wanted, const Shader& shader, const Bands& bands) {
  std::vector<Drawing> drawings;
  for (const RenderOptions& options : wanted) {
    const Shader own{shader.surface, shader.atlas, shader.normals, shader.paints, options, shader.camera};
    Drawing drawing{options, own, line_styles(options), {}, {}, -1,
                    Image<float>(options.width, options.height, options.backdrop.channels())};
    drawing.lines = projected(shader.surface.mesh, edges_of(shader.surface, shader.atlas, options), options,
                              drawing.styles, shader.camera);
    drawing.lines_of = lines_by_band(drawing.lines, drawing.styles, bands);
    for (int k = 0; k < int(drawings.size()) && drawing.like < 0; ++k)
      if (drawing.covers_like(drawings[k])) drawing.like = k;
    drawings.push_back(std::move(drawing));
  }
  return drawings;
}

void draw_band(const Scene& scene, int b, float slack, std::vector<Drawing>& drawings) {
  std::vector<DrawnBand> bands;
  int first = std::numeric_limits<int>::max(), last = std::numeric_limits<int>::min();
  for (const Drawing& drawing : drawings) {
    bands.push_back(new_band(drawing, b));
    first = std::min(first, bands.back().samples.first_row);
    last = std::max(last, bands.back().samples.first_row + bands.back().samples.rows);
  }
  ShotRow shot;
  shot.hits.resize(std::size_t(bands[0].samples.width));
  if (std::ranges::any_of(drawings, &Drawing::is_lit)) shot.lights.resize(shot.hits.size());
  const auto shows_clay = [](const Drawing& drawing) { return drawing.options.paint == Paint::clay; };
  const auto clay_one = std::ranges::find_if(drawings, shows_clay);
  const Shader& lights = (clay_one != drawings.end() ? *clay_one : drawings[0]).shader;
  for (int row = first; row < last; ++row) {
    shoot(scene, lights, drawings[0].options.samples, row, shot);
    for (std::size_t k = 0; k < drawings.size(); ++k)
      if (bands[k].holds(row))
        bands[k].shade(drawings[k], shot, row, drawings[k].like < 0 ? nullptr : &bands[drawings[k].like]);
  }
  for (std::size_t k = 0; k < drawings.size(); ++k) {
    Drawing& drawing = drawings[k];
    const RenderOptions& options = drawing.options;
    const DepthRule rule = options.view.projection == View::Projection::perspective ? DepthRule::reciprocal
                                                                                   : DepthRule::linear;
    if (drawing.isolines()) bands[k].draw_isolines(options, 20 * slack);
    draw_lines(drawing.lines, drawing.lines_of[b], drawing.styles, rule, slack, bands[k].samples);
    const int begin = b * band_pixels;
    resolve(bands[k].samples, options.samples, options.backdrop, begin, std::min(begin + band_pixels, options.height),
            drawing.picture);
  }
}

}  // namespace

Image<float> Renderer::draw(const Paints& paints, const RenderOptions& options,
                            const Progress& progress) const {
  return std::move(draw_together(paints, {&options, 1}, progress).front());
}

std::vector<Image<float>> Renderer::draw_together(const Paints& paints, std::span<const RenderOptions> wanted,
                                                  const Progress& progress) const {
  const Surface& surface = shared_->surface;
  check_alike(wanted);
  for (const RenderOptions& options : wanted) check(surface, shared_->atlas, paints, options);
  const RenderOptions& options = wanted.front();
  const bool with_legend = shows_numbers(options) && options.legend == RenderOptions::Legend::show;
  const Image<float> scale = with_legend ? legend_for(options) : Image<float>();
  require(scale.width() + std::min(options.width, options.height) / 25 < options.width,
          "the picture is too narrow for a legend: make it wider or hide the legend");
  const Camera camera = camera_with_lines(surface.mesh, options, scale.width());

  const Bands bands{band_pixels * options.samples, (options.height + band_pixels - 1) / band_pixels};
  const Shader shader{surface, shared_->atlas, shared_->normals, paints, options, camera};
  std::vector<Drawing> drawings = drawings_of(wanted, shader, bands);
  const Vector3& some = surface.mesh.position(0, 0);
  const float slack = float(2 * camera.pixel_size(std::abs(camera.project(some).depth)));
  std::atomic<int> done{0};
  parallel_for(
      bands.count,
      [&](std::int64_t b) {
        draw_band(shared_->scene, int(b), slack, drawings);
        progress.at(double(++done) / bands.count);
      },
      1);
  std::vector<Image<float>> pictures;
  for (Drawing& drawing : drawings) pictures.push_back(std::move(drawing.picture));
  if (with_legend) put_legend(scale, options, pictures.front());
  return pictures;
}

Colour chart_colour(int id) {
  constexpr double golden = 137.50776405;  // degrees: the turn that repeats latest
  static constexpr double lightness[] = {0.80, 0.70, 0.87, 0.62};
  static const std::vector<Colour> colours = [] {
    std::vector<Colour> all;
    for (int k = 0; k < 1024; ++k)
      all.push_back(colour_of(lightness[k % 4], 0.12, 20 + golden * k));
    return all;
  }();
  return colours[std::size_t(id) % colours.size()];
}

}  // namespace mq

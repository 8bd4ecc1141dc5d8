// A picture is made in bands of pixel rows, each by one task: rays through a regular grid of
// samples, light on what they hit, lines over it, the mean per pixel. Bands overlap by the rows
// that decide whether a line is hidden, so no band needs another.
//
// Light is multiplied as light, not as displayed values, and scaled so that a surface that faces
// the viewer keeps its stored colour.

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
#include "mq/draw/scene.h"
#include "mq/draw/detail/textures.h"
#include "mq/image/resample.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/surface_point.h"

namespace mq {
namespace {

using Paint = RenderOptions::Paint;
using Lines = RenderOptions::Lines;

constexpr Colour clay = {0.80f, 0.79f, 0.765f};
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

/// A displayed value in `light` times the light; `power` is light^(1/2.4). With the curved part of
/// sRGB on both sides that is (v + 0.055) · power − 0.055, with the straight part v · light.
double brightened(double v, double light, double power) {
  const double curved = (v + 0.055) * power - 0.055, straight = v * light;
  if (light < 1) return std::max(curved, straight);
  return std::min({curved, straight, std::max(v, 1.0)});  // white stays white
}

bool shows_numbers(const RenderOptions& options) {
  return options.paint == Paint::vertex_numbers || options.paint == Paint::texture_numbers;
}

/// Everything one picture needs while it is drawn.
struct Job {
  const Surface& surface;
  const Atlas* atlas;
  const Scene& scene;
  const std::vector<Eigen::Vector3f>& normals;
  const Paints& paints;
  const RenderOptions& options;
  const Camera& camera;
  const Vector3 key_light =
      (-0.5 * camera.right() + 0.65 * camera.up() + 0.57 * camera.backward()).normalized();

  /// Values of the texture where the ray hit; false where there is none.
  bool texture_values(const Hit& hit, std::span<float> values) const {
    if (atlas == nullptr || atlas->chart[hit.triangle] < 0) return false;
    const auto& corners = atlas->corners[hit.triangle];
    const double column =
        interpolate(hit.barycentric, [&](int k) { return corners[k].column(); });
    const double row = interpolate(hit.barycentric, [&](int k) { return corners[k].row(); });
    const int texture = surface.mesh.texture(hit.triangle);
    sample(*paints.textures[texture], column, row, atlas->textures[texture].wrap, values);
    return true;
  }

  Colour textured(const Hit& hit) const {
    std::array<float, 16> values;
    if (atlas == nullptr || atlas->chart[hit.triangle] < 0) return clay;
    const int channels = paints.textures[surface.mesh.texture(hit.triangle)]->channels();
    if (!texture_values(hit, std::span(values).first(std::min(channels, 3)))) return clay;
    if (channels < 3) return {values[0], values[0], values[0]};
    return {values[0], values[1], values[2]};
  }

  /// The number shown where the ray hit; none where the surface has no texture.
  std::optional<float> number(const Hit& hit) const {
    if (options.paint == Paint::vertex_numbers) return vertex_value(hit, 1, 0);
    if (options.paint != Paint::texture_numbers || atlas->chart[hit.triangle] < 0) return {};
    std::vector<float> values(paints.textures[surface.mesh.texture(hit.triangle)]->channels());
    texture_values(hit, values);
    return values[options.channel];
  }

  float vertex_value(const Hit& hit, int count, int channel) const {
    const Triangle& triangle = surface.mesh.triangles[hit.triangle];
    return float(interpolate(hit.barycentric, [&](int k) {
      return paints.vertex_values[std::size_t(triangle[k]) * count + channel];
    }));
  }

  Colour albedo(const Hit& hit) const {
    switch (options.paint) {
      case Paint::clay: return clay;
      case Paint::texture: return textured(hit);
      case Paint::charts:
        return atlas->chart[hit.triangle] < 0 ? clay : chart_colour(atlas->chart[hit.triangle]);
      case Paint::vertex_colours:
        return {vertex_value(hit, 3, 0), vertex_value(hit, 3, 1), vertex_value(hit, 3, 2)};
      case Paint::vertex_numbers:
      case Paint::texture_numbers: break;
    }
    const std::optional<float> value = number(hit);
    return value ? false_colour(*value, options.scale) : clay;
  }

  Vector3 shading_normal(const Hit& hit) const {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (int k = 0; k < 3; ++k) sum += float(hit.barycentric[k]) * normals[3 * hit.triangle + k];
    return sum.cast<double>().normalized();
  }

  /// The light that reaches a place, 1 where the surface faces the viewer.
  double light_at(const Hit& hit, const Vector3& view, const Vector3& normal) const {
    const double key = std::max(0.0, normal.dot(key_light));
    const double light =
        0.22 + 0.10 * normal.dot(camera.up()) + 0.44 * normal.dot(view) + 0.36 * key;
    const bool back = triangle_normal(surface.mesh, hit.triangle).dot(view) < 0;
    return light / (0.22 + 0.44 + 0.36 * 0.57) * (back ? 0.45 : 1.0);
  }

  Colour lit(const Colour& colour, const Hit& hit) const {
    const Vector3 view = camera.towards_viewer(hit.point);
    Vector3 normal = shading_normal(hit);
    if (normal.dot(view) < 0) normal -= 2 * normal.dot(view) * view;  // the back, or past the rim
    const double light = light_at(hit, view, normal);
    const double power = std::pow(light, 1 / 2.4);
    const double gloss =
        options.paint == Paint::clay
            ? 0.06 * std::pow(std::max(0.0, (key_light + view).normalized().dot(normal)), 40)
            : 0;
    Colour result;
    for (int k = 0; k < 3; ++k) result[k] = float(brightened(colour[k], light, power) + gloss);
    return result;
  }

  /// Darkens the samples whose isoline band is not that of a neighbour on the same surface.
  void draw_isolines(SampleBand& band, const std::vector<int>& levels, float depth_slack) const {
    const int width = std::max(1, int(std::lround(0.5 * options.line_width * options.samples)));
    for (int row = band.first_row; row < band.first_row + band.rows; ++row)
      for (int x = 0; x < band.width; ++x) {
        const std::size_t at = band.at(x, row);
        const auto differs = [&](int other_x, int other_row) {
          if (other_x >= band.width || other_row >= band.first_row + band.rows) return false;
          const std::size_t other = band.at(other_x, other_row);
          return levels[other] >= 0 && levels[other] != levels[at] &&
                 std::abs(band.depths[other] - band.depths[at]) < depth_slack;
        };
        bool line = false;
        for (int k = 1; k <= width && levels[at] >= 0 && !line; ++k)
          line = differs(x + k, row) || differs(x, row + k);
        if (line) band.colours[at] = {0.1f, 0.1f, 0.12f, 1};
      }
  }

  void shoot(SampleBand& band, float depth_slack) const {
    const bool isolines = shows_numbers(options) && options.scale.isolines > 0;
    std::vector<int> levels(isolines ? band.colours.size() : 0, -1);
    const double step = 1.0 / options.samples;
    for (int row = band.first_row; row < band.first_row + band.rows; ++row)
      for (int x = 0; x < band.width; ++x) {
        const Hit hit = scene.hit(camera.ray((x + 0.5) * step, (row + 0.5) * step));
        const std::size_t at = band.at(x, row);
        if (!band.depths.empty())
          band.depths[at] = hit.triangle < 0 ? std::numeric_limits<float>::infinity()
                                             : float(camera.project(hit.point).depth);
        if (hit.triangle < 0) continue;
        Colour colour = albedo(hit);
        if (options.light == RenderOptions::Light::studio) colour = lit(colour, hit);
        band.colours[at] = {colour[0], colour[1], colour[2], 1};
        if (const auto value = isolines ? number(hit) : std::nullopt)
          levels[at] = isoline_band(*value, options.scale);
      }
    if (isolines) draw_isolines(band, levels, depth_slack);
  }
};

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

Sight Renderer::sight_of(const Vector3& point, const Vector3& normal, double extent,
                         View::Up up) const {
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
      look(shared_->surface, shared_->scene, point, sight);
      const double worth = sight.clear ? sight.open * std::cos(tilt / degrees) : 0;
      if (worth > most) most = worth, best = sight;
    }
  return best;
}

Image<float> Renderer::draw(const Paints& paints, const RenderOptions& options,
                            const Progress& progress) const {
  const Surface& surface = shared_->surface;
  check(surface, shared_->atlas, paints, options);
  const bool with_legend = shows_numbers(options) && options.legend == RenderOptions::Legend::show;
  const Image<float> scale = with_legend ? legend_for(options) : Image<float>();
  require(scale.width() + std::min(options.width, options.height) / 25 < options.width,
          "the picture is too narrow for a legend: make it wider or hide the legend");
  const Camera camera = camera_with_lines(surface.mesh, options, scale.width());
  const Job job{surface, shared_->atlas, shared_->scene, shared_->normals, paints, options, camera};

  const int samples = options.samples, rows = band_pixels * samples;
  const Bands bands{rows, (options.height + band_pixels - 1) / band_pixels};
  const std::vector<LineStyle> styles = line_styles(options);
  const std::vector<ScreenLine> lines =
      projected(surface.mesh, edges_of(surface, shared_->atlas, options), options, styles, camera);
  const auto lines_of = lines_by_band(lines, styles, bands);
  const DepthRule rule = options.view.projection == View::Projection::perspective
                             ? DepthRule::reciprocal
                             : DepthRule::linear;
  const int margin = int(std::ceil(styles[seam].half_width + styles[seam].casing)) + 2;

  const bool isolines = shows_numbers(options) && options.scale.isolines > 0;
  const Vector3& some = surface.mesh.position(0, 0);
  const float slack = float(2 * camera.pixel_size(std::abs(camera.project(some).depth)));

  Image<float> picture(options.width, options.height, options.backdrop.channels());
  std::atomic<int> done{0};
  parallel_for(
      bands.count,
      [&](std::int64_t b) {
        const int begin = int(b) * band_pixels, end = std::min(begin + band_pixels, options.height);
        const int extra = lines_of[b].empty() && !isolines ? 0 : margin;
        SampleBand band(options.width * samples, begin * samples - extra,
                        (end - begin) * samples + 2 * extra);
        if (extra > 0) band.depths.resize(band.colours.size());
        job.shoot(band, 20 * slack);
        draw_lines(lines, lines_of[b], styles, rule, slack, band);
        resolve(band, samples, options.backdrop, begin, end, picture);
        progress.at(double(++done) / bands.count);
      },
      1);
  if (with_legend) put_legend(scale, options, picture);
  return picture;
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

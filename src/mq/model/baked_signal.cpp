#include "mq/model/baked_signal.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <utility>

#include "mq/atlas/coverage.h"
#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/base/parallel.h"
#include "mq/base/words.h"
#include "mq/filter/chart_borders.h"
#include "mq/filter/fill_unseen.h"
#include "mq/filter/seam_values.h"
#include "mq/mesh/facing_points.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/orient.h"
#include "mq/model/detail/bake_source.h"
#include "mq/model/texture_fill.h"

namespace mq {
namespace {

/// A target whose unknowns are so much farther apart than the source's is given means.
constexpr double coarser = 1.5;
/// Samples for each texel of the source, in each direction, and how many there may be for one of
/// the target.
constexpr double per_source_texel = 1.5;
constexpr int fewest = 2, most = 32;
constexpr std::size_t block = 1 << 17;

struct Samples {
  std::vector<SurfacePoint> points;  ///< of the target
  std::vector<double> areas;

  void clear() {
    points.clear();
    areas.clear();
  }
};

/// Gives samples on, a block at a time.
class SampleStream {
 public:
  SampleStream(std::function<void(const Samples&)> take) : take_(std::move(take)) {}

  void add(int triangle, const Vector3& barycentric, double area) {
    samples_.points.push_back({triangle, barycentric});
    samples_.areas.push_back(area);
    if (samples_.points.size() == block) end();
  }
  void end() {
    if (!samples_.points.empty()) take_(samples_);
    samples_.clear();
  }

 private:
  std::function<void(const Samples&)> take_;
  Samples samples_;
};

/// Places (i + ½)/s, (j + ½)/s of a grid that lie in a triangle of the plane, by their barycentric
/// coordinates.
template <class Visit>
void for_each_place(const std::array<Vector2, 3>& corners, int s, const Visit& visit) {
  const Vector2 a = corners[1] - corners[0], b = corners[2] - corners[0];
  const double twice = cross(a, b);
  if (twice == 0) return;
  const auto low = [&](int k) {
    return std::min({corners[0][k], corners[1][k], corners[2][k]}) * s - 0.5;
  };
  const auto high = [&](int k) {
    return std::max({corners[0][k], corners[1][k], corners[2][k]}) * s - 0.5;
  };
  for (double row = std::ceil(low(1)); row <= high(1); ++row)
    for (double column = std::ceil(low(0)); column <= high(0); ++column) {
      const Vector2 p = Vector2((column + 0.5) / s, (row + 0.5) / s) - corners[0];
      const double second = cross(p, b) / twice, third = cross(a, p) / twice;
      if (second >= 0 && third >= 0 && second + third <= 1)
        visit(Vector3(1 - second - third, second, third));
    }
}

/// Samples of the triangles with charts, `samples` per texel and direction; a triangle that is
/// smaller than its samples' distance has one.
void sample_textures(const TexturedModel& target, int samples, SampleStream& stream,
                     const Progress& progress) {
  const Mesh& mesh = target.surface.mesh;
  const Atlas& atlas = *target.atlas;
  const int count = mesh.triangle_count();
  for (int t = 0; t < count; ++t) {
    if (atlas.chart[std::size_t(t)] < 0) continue;
    const TextureSize& size = atlas.textures[std::size_t(mesh.texture(t))];
    std::array<Vector2, 3> corners;
    for (int k = 0; k < 3; ++k)
      corners[std::size_t(k)] = {mesh.uv(t, k).x() * size.width,
                                 (1 - mesh.uv(t, k).y()) * size.height};
    int found = 0;
    for_each_place(corners, samples, [&](const Vector3&) { ++found; });
    const double area = triangle_area(mesh, t) / std::max(1, found);
    if (found == 0)
      stream.add(t, Vector3::Constant(1.0 / 3), area);
    else
      for_each_place(corners, samples, [&](const Vector3& b) { stream.add(t, b, area); });
    if (t % 256 == 0) progress.at(double(t) / count);
  }
  stream.end();
}

/// Samples of all triangles, no farther apart than `spacing` as far as `most` to an edge allow: the
/// centroids of the parts that cut each edge into as many.
void sample_vertices(const Mesh& mesh, double spacing, SampleStream& stream,
                     const Progress& progress) {
  const int count = mesh.triangle_count();
  for (int t = 0; t < count; ++t) {
    double longest = 0;
    for (int k = 0; k < 3; ++k)
      longest = std::max(longest, (mesh.position(t, (k + 1) % 3) - mesh.position(t, k)).norm());
    const int n =
        spacing > 0 ? std::clamp(int(std::ceil(longest / spacing)), fewest, most) : fewest;
    const double area = triangle_area(mesh, t) / (n * n);
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        const auto add = [&](double x, double y) {
          stream.add(t, Vector3(1 - (x + y) / n, x / n, y / n), area);
        };
        add(i + 1.0 / 3, j + 1.0 / 3);
        if (i + j + 1 < n) add(i + 2.0 / 3, j + 2.0 / 3);
      }
    if (t % 256 == 0) progress.at(double(t) / count);
  }
  stream.end();
}

/// Per triangle of the target whether the source's of this number has its corners.
std::vector<char> same_triangles(const Mesh& source, const Mesh& target) {
  std::vector<char> same(std::size_t(target.triangle_count()), 0);
  if (source.triangle_count() != target.triangle_count()) return same;
  const double near = 1e-6 * bounding_box(source).diagonal();
  for (int t = 0; t < target.triangle_count(); ++t) {
    bool is_same = true;
    for (int k = 0; k < 3; ++k)
      is_same = is_same && (source.position(t, k) - target.position(t, k)).norm() <= near;
    same[std::size_t(t)] = is_same;
  }
  return same;
}

/// Finds the source's point for points of the target.
class SourcePoints {
 public:
  SourcePoints(const Mesh& source, const Mesh& target, const BakeOptions& options)
      : same_(same_triangles(source, target)) {
    if (std::ranges::count(same_, 0) > 0)
      facing_.emplace(
          target, source,
          FacingPointsOptions{.most_distance = options.within, .most_angle = options.angle});
  }

  bool is_same(int triangle) const { return same_[std::size_t(triangle)] != 0; }
  SurfacePoint operator()(const SurfacePoint& p) const {
    if (is_same(p.triangle)) return p;
    return (*facing_)(p.triangle, p.barycentric);
  }
  double accuracy() const { return facing_ ? facing_->accuracy() : 0; }

 private:
  std::vector<char> same_;  ///< per triangle
  std::optional<FacingPoints> facing_;
};

/// The n-th place of a sequence that fills a triangle evenly (the two-dimensional Kronecker sequence of the plastic
/// number), from its middle on.
Vector3 nth_place(std::int64_t n) {
  const double plastic = 1.32471795724474602596;
  double whole;
  double u = std::modf(1.0 / 3 + double(n) / plastic, &whole), v = std::modf(1.0 / 3 + double(n) / (plastic * plastic), &whole);
  if (u + v > 1) u = 1 - u, v = 1 - v;
  return {1 - u - v, u, v};
}

/// Whether the source is met at some of many places spread over the target's triangles: looking everywhere takes as
/// long as a bake, and finds nothing where models have nothing to do with each other.
bool is_met(const SourcePoints& source_points, const Mesh& target) {
  constexpr std::int64_t tried = 1 << 14;
  const std::int64_t triangles = std::min<std::int64_t>(target.triangle_count(), tried);
  const std::int64_t count = triangles * (tried / std::max<std::int64_t>(1, triangles));
  std::atomic<bool> met = false;
  parallel_for(
      count,
      [&](std::int64_t i) {
        if (met) return;
        const int t = int(i % triangles * target.triangle_count() / triangles);
        if (source_points({t, nth_place(i / triangles)}).triangle >= 0) met = true;
      },
      64);
  return met;
}

/// What is not known, harmonic between what is; on a part of which nothing is, the mean of all.
void fill(const SignalSpace& space, const std::vector<char>& known, Signal& values) {
  Eigen::RowVectorXd mean = Eigen::RowVectorXd::Zero(values.cols());
  const double count = double(std::ranges::count(known, 1));
  for (std::size_t i = 0; i < known.size(); ++i)
    if (known[i]) mean += values.row(Eigen::Index(i)) / count;
  for (std::size_t i = 0; i < known.size(); ++i)
    if (!known[i]) values.row(Eigen::Index(i)) = mean;
  values = fill_unseen(space, known, values);
}

void check(const TexturedModel& target, const ModelSignal& signal, const BakeOptions& options) {
  require(options.within > 0 && options.angle > 0 && options.angle <= 180 && options.samples >= 0 &&
              options.samples <= most,
          fmt::format(
              "a bake within {:g} diagonals and {:g} degrees with {} samples: wanted above 0, up "
              "to 180 degrees, and 0 to {} samples",
              options.within, options.angle, options.samples, most));
  require(!signal.texel_space() || target.atlas,
          target.model.path.string() + ": has no charts to bake to");
}

/// The source's mesh facing as the target does; where they are the same triangles, as it is.
Mesh facing_mesh(const TexturedModel& source, const Mesh& target, Messages& messages) {
  if (std::ranges::count(same_triangles(source.model.mesh, target), 0) == 0)
    return source.model.mesh;
  Oriented oriented = oriented_like(source.model.mesh, target);
  for (const Defect& defect : oriented.defects)
    if (defect.severity == Defect::Severity::warning)
      messages.warning(source.model.path.string() + ": " + short_sentence(defect));
  return std::move(oriented.mesh);
}

}  // namespace

TextureSignalOptions baking_options(const TexturedModel& target, const ValueSpace& values) {
  require(target.atlas.has_value(),
          target.model.path.string() + ": has no texture coordinates; unwrap it first");
  return {.values = values,
          .space = soft_seams(*target.atlas),
          .pictures = TextureSignalOptions::Pictures::replaced};
}

BakedSignal bake(const TexturedModel& source, const TexturedModel& target,
                 const ModelSignal& signal, const BakeOptions& options, Messages& messages,
                 const Progress& progress) {
  check(target, signal, options);
  const Mesh& surface = target.surface.mesh;
  const Mesh source_mesh = facing_mesh(source, surface, messages);
  const BakeSource shown(source, source_mesh, target, signal, options);
  BakedSignal baked{.normals = shown.normals(), .depth = shown.depth(), .is_light = shown.is_light()};
  const double spacing = signal.scale().texel_spacing;
  const double ratio = shown.spacing() > 0 ? spacing / shown.spacing() : 1;
  baked.kind = ratio >= coarser ? BakedSignal::Kind::mean : BakedSignal::Kind::least_squares;
  baked.samples = options.samples > 0
                      ? options.samples
                      : std::clamp(int(std::ceil(per_source_texel * ratio)), fewest, most);

  const SourcePoints source_points(source_mesh, surface, options);
  const auto require_met = [&](bool met) {
    require(met, fmt::format(
                     "{}: no part of it lies within {:g} % of the diagonal of {} and faces as it does; "
                     "give {} more, or bring them to one place",
                     source.model.path.string(), 100 * options.within, target.model.path.string(),
                     option_name("within")));
  };
  require_met(is_met(source_points, surface));
  baked.accuracy = source_points.accuracy();
  SampleFit fit(signal.space(), shown.channels(), progress.step("space", 0.15));
  SampleStream stream([&](const Samples& samples) {
    Signal values = Signal::Zero(std::ssize(samples.points), shown.channels());
    std::vector<char> seen(samples.points.size(), 0);
    parallel_for(
        std::ssize(samples.points),
        [&](std::int64_t s) {
          const SurfacePoint& point = samples.points[std::size_t(s)];
          const SurfacePoint found = source_points(point);
          if (found.triangle < 0) return;
          seen[std::size_t(s)] =
              shown.at(found, point, {values.row(s).data(), std::size_t(shown.channels())});
        },
        256);
    for (const SurfacePoint& point : samples.points)
      baked.same += source_points.is_same(point.triangle);
    baked.points += std::ssize(samples.points);
    fit.add(samples.points, samples.areas, values, seen);
  });
  const Progress looking = progress.step("look", 0.6);
  if (signal.texel_space())
    sample_textures(target, baked.samples, stream, looking);
  else
    sample_vertices(surface, spacing / baked.samples, stream, looking);

  const std::vector<char> known = fit.known();
  const std::int64_t filled = std::ranges::count(known, 0);
  require_met(filled < std::ssize(known));
  baked.unseen = fit.unseen();
  if (baked.kind == BakedSignal::Kind::mean) {
    baked.values = fit.mean();
    baked.fit = nothing_to_solve();
  } else {
    Filtered found = fit.least_squares(progress.step("fit", 0.15));
    baked.values = std::move(found.signal);
    baked.fit = std::move(found.report);
  }
  if (filled > 0) fill(signal.space(), known, baked.values);
  return baked;
}

void put_baked(const BakedSignal& baked, const ModelSignal& signal, const ValueSpace& values,
               TexturedModel& target) {
  const TexelSpace* space = signal.texel_space();
  const bool is_coded = baked.normals && space;
  signal.replace(
      is_coded ? coded_normals(*baked.normals, baked.values, *space, target) : baked.values,
      baked.depth, target.model);
  if (!space) {
    target.model.colors.is_light = baked.is_light;
    return;
  }
  spread_past_charts(signal.texels(), target);
  if (is_coded) return;
  for (Texture& texture : target.model.textures) texture.pixels = encoded(texture.pixels, texture, values);
}

}  // namespace mq

// Around a point the process with the nearest texel tells the unknowns. The discs around points reach over the borders
// of parts: all processes gather their rows and find the same.
#include "geodesic_sources.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "mq/base/error.h"
#include "mq/filter/geodesic_steps.h"
#include "mq/io/image_file.h"
#include "verbs/shared/input_pictures.h"

namespace mq::shared {
namespace {

/// A row of the heat's matrix near a point, and its entries.
struct DiscRow {
  std::int64_t number;
  double at[3];
  int entries;
};
struct DiscEntry {
  std::int64_t column;
  double value;
  double at[3];
};

auto raster(const Texels::Place& p) { return std::tuple(p.texture, p.y, p.x); }

/// What all processes have, in their order.
template <class T>
std::vector<T> everywhere(const Processes& processes, const std::vector<T>& here) {
  std::vector<T> all;
  for (const auto& one : processes.exchange(std::vector(std::size_t(processes.count()), here)))
    all.insert(all.end(), one.begin(), one.end());
  return all;
}

bool has_texel(const TexelPart& part, const Texels::Place& texel) {
  const auto place = [&](int i) { return raster(part.places()[std::size_t(i)]); };
  const auto at = std::ranges::lower_bound(part.own(), raster(texel), {}, place);
  return at != part.own().end() && place(*at) == raster(texel);
}

int wrapped_texel(int at, int count, Wrap wrap) {
  return wrap == Wrap::repeat ? (at % count + count) % count : std::clamp(at, 0, count - 1);
}

/// Texels², from the point to the nearest own one.
double nearest_texel(const SourceSpace& space, const SurfacePoint& point) {
  constexpr int around = 2;
  const auto& corners = space.atlas.corners[std::size_t(point.triangle)];
  double x = 0, y = 0;
  for (int k = 0; k < 3; ++k) {
    x += point.barycentric[k] * corners[std::size_t(k)].column();
    y += point.barycentric[k] * corners[std::size_t(k)].row();
  }
  const int texture = space.scene.surface.mesh.texture(point.triangle);
  const TextureSize& size = space.atlas.textures[std::size_t(texture)];
  double least = std::numeric_limits<double>::infinity();
  for (int row = int(std::floor(y)) - around; row <= int(std::floor(y)) + 1 + around; ++row)
    for (int column = int(std::floor(x)) - around; column <= int(std::floor(x)) + 1 + around; ++column)
      if (has_texel(space.part, {texture, wrapped_texel(column, size.width, size.wrap),
                                 wrapped_texel(row, size.height, size.wrap)}))
        least = std::min(least, std::pow(column - x, 2) + std::pow(row - y, 2));
  return least;
}

PointSource at_unknown(const SourceSpace& space, const GeodesicSource& source) {
  const Vector3 at = source.from.value_or(Vector3::Zero());
  return {space.numbering.numbers()[std::size_t(source.unknown)], source.distance, {at.x(), at.y(), at.z()}};
}

/// Those of places on the surface, by the process that is nearest to each.
void add_on_surface(const SourceSpace& space, std::span<const app::SourcePlace> places,
                    std::vector<PointSource>& here) {
  std::vector<double> own;
  for (const app::SourcePlace& place : places)
    own.push_back(place.on_surface && !space.part.empty() ? nearest_texel(space, *place.on_surface)
                                                          : std::numeric_limits<double>::infinity());
  const auto all = space.processes.exchange(std::vector(std::size_t(space.processes.count()), own));
  for (std::size_t k = 0; k < places.size(); ++k) {
    if (!places[k].on_surface) continue;
    int nearest = 0;
    for (int p = 0; p < space.processes.count(); ++p)
      if (all[std::size_t(p)][k] < all[std::size_t(nearest)][k]) nearest = p;
    if (nearest != space.processes.rank() || space.part.empty()) continue;
    for (const GeodesicSource& source :
         sources_at_point(space.scene.surface.mesh, space.part.space(), *places[k].on_surface))
      here.push_back(at_unknown(space, source));
  }
}

void add_texels(const SourceSpace& space, const app::SourcePlace& place, std::vector<PointSource>& here) {
  for (int n = 0; n < int(space.part.own().size()); ++n) {
    if (raster(space.copies.home(n)) != raster(*place.texel) || !space.copies.is_meant(n)) continue;
    const int i = space.part.own()[std::size_t(n)];
    here.push_back(at_unknown(space, {i, 0, space.part.space().texels().position(i)}));
  }
}

/// Each process reads the masks of the textures that it has texels of.
std::vector<int> marked_by_masks(const SourceSpace& space, const std::vector<std::string>& masks) {
  std::vector<int> marked;
  space.processes.together([&] {
    for (std::size_t k = 0; k < masks.size(); ++k) {
      if (!space.part.has_texture(int(k))) continue;
      const Image<float> pixels = read_texture(masks[k]).pixels;
      app::require_size(masks[k], pixels.width(), pixels.height(), space.scene, k);
      for (int n = 0; n < int(space.part.own().size()); ++n) {
        const Texels::Place at = space.copies.home(n);
        if (at.texture == int(k) && pixels(at.x, at.y) > 0.5F && space.copies.is_meant(n))
          marked.push_back(space.part.own()[std::size_t(n)]);
      }
    }
  });
  return marked;
}

int local_of(const SourceSpace& space, std::int64_t number) {
  const std::int64_t row = number - space.numbering.first();
  return row >= 0 && row < space.numbering.own_count() ? space.part.own()[std::size_t(row)] : -1;
}

Vector3 vector_of(const double (&at)[3]) { return {at[0], at[1], at[2]}; }

/// The matrix of the rows near points, the same in all processes.
struct Discs {
  std::vector<std::int64_t> numbers;  ///< ascending
  std::vector<Vector3> positions;
  SparseMatrix A;

  int index(std::int64_t number) const { return int(std::ranges::lower_bound(numbers, number) - numbers.begin()); }
};

Discs gathered_discs(const SourceSpace& space, const std::vector<PointSource>& points, const SparseMatrix& heat,
                     std::span<const Vector3> positions) {
  std::vector<double> radius(points.size(), 0);
  for (std::size_t k = 0; k < points.size(); ++k)
    if (const int i = local_of(space, points[k].number); i >= 0)
      radius[k] = disc_radius(heat, positions, space.atlas.texel_spacing(), i);
  space.processes.largest(radius);
  std::vector<DiscRow> rows;
  std::vector<DiscEntry> entries;
  for (std::size_t n = 0; n < space.part.own().size(); ++n) {
    const int i = space.part.own()[n];
    const Vector3& at = positions[std::size_t(i)];
    const std::int64_t number = space.numbering.first() + std::int64_t(n);
    bool is_near = false;
    for (std::size_t k = 0; k < points.size() && !is_near; ++k)
      is_near = points[k].number == number || (at - vector_of(points[k].at)).norm() <= radius[k];
    if (!is_near) continue;
    rows.push_back({number, {at.x(), at.y(), at.z()}, 0});
    for (SparseMatrix::InnerIterator it(heat, i); it; ++it) {
      if (it.value() == 0) continue;
      const Vector3& to = positions[std::size_t(it.col())];
      entries.push_back({space.numbering.numbers()[std::size_t(it.col())], it.value(), {to.x(), to.y(), to.z()}});
      ++rows.back().entries;
    }
  }
  rows = everywhere(space.processes, rows);
  entries = everywhere(space.processes, entries);
  std::map<std::int64_t, Vector3> at;
  for (const DiscEntry& entry : entries) at[entry.column] = vector_of(entry.at);
  for (const DiscRow& row : rows) at[row.number] = vector_of(row.at);
  Discs discs;
  for (const auto& [number, position] : at) discs.numbers.push_back(number), discs.positions.push_back(position);
  std::vector<Eigen::Triplet<double>> triplets;
  auto entry = entries.begin();
  for (const DiscRow& row : rows)
    for (int e = 0; e < row.entries; ++e, ++entry)
      triplets.emplace_back(discs.index(row.number), discs.index(entry->column), entry->value);
  const auto size = Eigen::Index(discs.numbers.size());
  discs.A = SparseMatrix(size, size);
  discs.A.setFromTriplets(triplets.begin(), triplets.end());
  return discs;
}

std::vector<GeodesicSource> as_sources(const std::map<int, double>& distances) {
  std::vector<GeodesicSource> sources;
  for (const auto& [i, distance] : distances) sources.push_back({i, distance});
  return sources;
}

void add_least(int i, double distance, std::map<int, double>& to) {
  const auto [at, is_new] = to.try_emplace(i, distance);
  if (!is_new) at->second = std::min(at->second, distance);
}

}  // namespace

SharedSources shared_sources(const app::Run& run, const SourceSpace& space, std::span<const app::SourcePlace> places) {
  SharedSources sources;
  std::vector<PointSource> here;
  space.processes.talking([&] { add_on_surface(space, places, here); });
  for (const app::SourcePlace& place : places) {
    if (!place.texel) continue;
    const std::size_t before = here.size();
    add_texels(space, place, here);
    const double found = space.processes.largest(double(here.size() - before));
    space.processes.together([&] {
      if (!(found > 0)) app::refuse_texel(space.scene, place.text);
    });
  }
  space.processes.talking([&] { sources.points = everywhere(space.processes, here); });
  const std::vector<std::string> masks = run.options().texts("from-mask");
  sources.marked = marked_by_masks(space, masks);
  double marked = double(sources.marked.size());
  space.processes.sum({&marked, 1});
  sources.count = std::ssize(sources.points) + std::int64_t(marked);
  space.processes.together([&] {
    require(masks.empty() || marked > 0,
            (masks.empty() ? "" : masks.front()) + ": --from-mask: no texel of a chart is brighter than half in it");
    require(sources.count > 0, "--from: no texel of a chart is there");
  });
  return sources;
}

std::vector<GeodesicSource> sources_here(const SourceSpace& space, const SharedSources& sources) {
  std::map<int, double> distances;
  for (const PointSource& point : sources.points)
    if (const int i = local_of(space, point.number); i >= 0) add_least(i, point.distance, distances);
  for (const int i : sources.marked) add_least(i, 0, distances);
  return as_sources(distances);
}

std::vector<GeodesicSource> grown_here(const SourceSpace& space, const SharedSources& sources, const SparseMatrix& heat,
                                       std::span<const Vector3> positions) {
  std::map<int, double> distances;
  for (const int i : sources.marked) add_least(i, 0, distances);
  const Discs discs = gathered_discs(space, sources.points, heat, positions);
  std::vector<GeodesicSource> points;
  for (const PointSource& point : sources.points)
    points.push_back({discs.index(point.number), point.distance, vector_of(point.at)});
  for (const GeodesicSource& found : grown_sources(discs.A, discs.positions, space.atlas.texel_spacing(), points))
    if (const int i = local_of(space, discs.numbers[std::size_t(found.unknown)]); i >= 0)
      add_least(i, found.distance, distances);
  return as_sources(distances);
}

}  // namespace mq::shared

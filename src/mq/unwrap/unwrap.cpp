#include "mq/unwrap/unwrap.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "mq/base/error.h"
#include "mq/mesh/geometry.h"
#include "mq/unwrap/detail/chart_surface.h"
#include "mq/unwrap/flat_charts.h"
#include "mq/unwrap/detail/laps.h"

namespace mq {
namespace {

constexpr double least_size = 1e-60;

/// The surface at unit area, on a grid, so that the unit of length leaves no trace.
Surface normalised(const Surface& surface) {
  const Box box = bounding_box(surface.mesh);
  const double size = (box.high - box.low).maxCoeff();
  require(size > 0 && (surface.area > 0 || size < least_size),
          "the surface has no area, so there is nothing to unwrap");
  require(
      size >= least_size,
      fmt::format("the surface is {:g} wide, and areas of less than {:g} cannot be told from none: "
                  "give it a larger unit",
                  size, least_size));
  Surface result = surface;
  double area = 0;
  for (Vector3& p : result.mesh.positions)
    for (int k = 0; k < 3; ++k)
      p[k] = std::nearbyint((p[k] - box.low[k]) / size * 0x1p32) * 0x1p-32;
  for (const double a : triangle_areas(result.mesh)) area += a;
  require(area > 0, "the surface has no area, so there is nothing to unwrap");
  for (Vector3& p : result.mesh.positions) p /= std::sqrt(area);
  result.area = 1;
  return result;
}

// ---- Figures ----

double seam_length(const Surface& surface, const ChartMerging& merging) {
  double length = 0;
  for (HalfEdge h = 0; h < HalfEdge(surface.twins.size()); ++h)
    if (surface.twins[h] > h && !merging.merged()[h])
      length +=
          (surface.mesh.position(h / 3, (h + 1) % 3) - surface.mesh.position(h / 3, h % 3)).norm();
  return length;
}

// ---- The atlas ----

/// Triangles with two equal vertices, at a corner that a chart has.
void place_collapsed(const Mesh& mesh, Unwrapped& unwrapped) {
  std::vector<int> at_vertex(mesh.positions.size(), -1), chart_at(mesh.positions.size(), -1);
  for (int t = 0; t < mesh.triangle_count(); ++t)
    for (int k = 0; k < 3 && unwrapped.chart[t] >= 0; ++k) {
      at_vertex[mesh.triangles[t][k]] = unwrapped.corner_uvs[t][k];
      chart_at[mesh.triangles[t][k]] = unwrapped.chart[t];
    }
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    if (unwrapped.chart[t] >= 0) continue;
    int uv = 0;
    for (const int v : mesh.triangles[t])
      if (at_vertex[v] >= 0) uv = at_vertex[v], unwrapped.chart[t] = chart_at[v];
    unwrapped.corner_uvs[t] = {uv, uv, uv};
    unwrapped.chart[t] = std::max(unwrapped.chart[t], 0);
  }
}

}  // namespace

Unwrapped unwrap(const Surface& given, const UnwrapOptions& options, const Progress& progress) {
  require(options.stretch > 1,
          fmt::format("the bound on stretch: found {}, wanted more than 1", options.stretch));
  ChartSurfaceOptions chart_options{.stretch = options.stretch, .largest = options.largest};
  // Sums of areas may be more than the whole by rounding.
  if (options.largest >= 1)
    chart_options.largest = chart_options.longest = std::numeric_limits<double>::infinity();
  const Surface surface = normalised(given);
  Unwrapped unwrapped;
  Laps lap(unwrapped.figures.seconds);
  const ChartHistory history = find_charts(surface, chart_options, progress.step("charts", 0.12));
  lap("charts");
  ChartMerging merging(surface, history.patches.patch, history.patches.count);
  std::vector<FlatChart> flats =
      lay_flat(surface, history, options.stretch, nullptr, merging, progress.step("flatten", 0.18));
  lap("flatten");
  std::vector<PackChart> outlines;
  for (FlatChart& flat : flats) {
    scale_for_stretch(flat);
    outlines.push_back(outline_of(flat));
  }
  const Packing packing = pack(outlines,
                               {.width = options.width,
                                .height = options.height,
                                .gutter = options.gutter,
                                .trials = options.trials},
                               progress.step("pack", 0.7));
  lap("pack");
  unwrapped.corner_uvs.resize(surface.mesh.triangles.size());
  unwrapped.chart.assign(surface.mesh.triangles.size(), -1);
  for (std::size_t c = 0; c < flats.size(); ++c) {
    const int base = int(unwrapped.uvs.size());
    append_uvs(flats[c], packing.places[c], packing.scale, options.width, options.height,
               unwrapped.uvs);
    const Sheet& sheet = flats[c].sheet;
    for (std::size_t i = 0; i < sheet.triangles.size(); ++i) {
      unwrapped.chart[sheet.sources[i]] = int(c);
      for (int k = 0; k < 3; ++k)
        unwrapped.corner_uvs[sheet.sources[i]][k] = base + sheet.triangles[i][k];
    }
    unwrapped.figures.overlapping += !is_injective(sheet, flats[c].x);
  }
  place_collapsed(surface.mesh, unwrapped);
  unwrapped.figures.charts = int(flats.size());
  unwrapped.figures.seam_length = seam_length(surface, merging);
  unwrapped.figures.stretch =
      atlas_stretch(given, unwrapped.uvs, unwrapped.corner_uvs, options.width, options.height);
  return unwrapped;
}

}  // namespace mq

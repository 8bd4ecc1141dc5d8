// horizon_packing SIZE MODEL...: how full a texture of SIZE x SIZE texels is with the charts of `unwrap`, or those of
// an evolving mesh, STORE.evolving, over time, in the places of `pack` and in those of the thesis' packing by 16 + 16
// horizons, with charts in one direction and in the sixteen that `pack` has. Gutter 2.
#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "tool.h"
#include "mq/base/error.h"
#include "mq/base/stopwatch.h"
#include "mq/baseline/horizon_pack.h"
#include "mq/evolving/lifespan_atlas.h"
#include "mq/io/evolving_file.h"
#include "mq/io/model.h"
#include "mq/mesh/geometry.h"
#include "mq/unwrap/unwrap.h"

namespace mq {
namespace {

constexpr int gutter = 2;

/// Triangles of texture coordinates as a chart, in texels.
PackChart outline(const std::vector<Triangle>& triangles, const std::vector<Vector2>& uvs, int size) {
  PackChart chart;
  std::multimap<int, int> sides;
  for (const Triangle& t : triangles) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
    chart.area += size * double(size) * std::abs(cross(uvs[t[1]] - uvs[t[0]], uvs[t[2]] - uvs[t[0]])) / 2;
    for (int k = 0; k < 3; ++k) sides.emplace(t[k], t[(k + 1) % 3]);
  }
  const auto find = [&](int from, int to) {
    for (auto [i, end] = sides.equal_range(from); i != end; ++i)
      if (i->second == to) return i;
    return sides.end();
  };
  for (auto i = sides.begin(); i != sides.end();) {
    const auto twin = find(i->second, i->first);
    if (twin == sides.end()) {
      ++i;
      continue;
    }
    sides.erase(twin);
    i = sides.erase(i);
  }
  while (!sides.empty()) {
    chart.loops.emplace_back();
    const int start = sides.begin()->first;
    for (int at = start; chart.loops.back().empty() || at != start;) {
      chart.loops.back().push_back(size * uvs[at]);
      const auto side = sides.find(at);
      require(side != sides.end(), "the boundary of a chart has an end");
      at = side->second;
      sides.erase(side);
    }
  }
  return chart;
}

std::vector<PackChart> charts_of_model(const std::string& file, int size) {
  const Unwrapped unwrapped =
      unwrap(make_surface(read_model(file).mesh), {.width = size, .height = size, .gutter = gutter});
  std::vector<std::vector<Triangle>> triangles(std::size_t(unwrapped.figures.charts));
  for (std::size_t t = 0; t < unwrapped.chart.size(); ++t)
    triangles[std::size_t(unwrapped.chart[t])].push_back(unwrapped.corner_uvs[t]);
  std::vector<PackChart> charts;
  for (const auto& chart : triangles) charts.push_back(outline(chart, unwrapped.uvs, size));
  return charts;
}

std::vector<PackChart> charts_of_store(const std::string& file, int size) {
  EvolvingMesh evolving = EvolvingReader(file).read();
  LifespanAtlasOptions options;
  options.unwrap = {.width = size, .height = size, .gutter = gutter, .trials = 20};
  const LifespanAtlas atlas = lay_out(evolving, options);
  std::vector<PackChart> charts;
  for (const AtlasPrism& prism : atlas.charts) {
    const EvolvingSegment& segment = evolving.segments[std::size_t(evolving.frames[std::size_t(prism.first)].segment)];
    std::map<int, int> place;
    for (int t = 0; t < segment.triangle_count(); ++t) place[segment.triangle_ids[std::size_t(t)]] = t;
    std::vector<Triangle> triangles;
    for (const int id : prism.triangles) triangles.push_back(segment.corner_uvs[std::size_t(place.at(id))]);
    charts.push_back(outline(triangles, segment.uvs, size));
    charts.back().first = prism.first;
    charts.back().last = prism.last;
  }
  return charts;
}

int main(int count, char** words) {
  require(count >= 3, "usage: horizon_packing SIZE MODEL...");
  const int size = std::atoi(words[1]);
  require(size > 0, fmt::format("SIZE: found '{}', wanted a number of texels, such as 1024", words[1]));
  std::printf("| model | charts | `pack` | horizons, one direction | horizons, sixteen | seconds of each |\n"
              "|---|---|---|---|---|---|\n");
  for (int i = 2; i < count; ++i) {
    const std::filesystem::path file = words[i];
    const std::vector<PackChart> charts =
        file.extension() == ".evolving" ? charts_of_store(words[i], size) : charts_of_model(words[i], size);
    double occupancy[3], seconds[3];
    for (int how = 0; how < 3; ++how) {
      const Stopwatch watch;
      occupancy[how] =
          100 * (how == 0 ? pack(charts, {.width = size, .height = size, .gutter = gutter})
                          : horizon_pack(charts, {.width = size, .height = size, .gutter = gutter,
                                                  .directions = how == 1 ? 1 : 16}))
                    .occupancy;
      seconds[how] = watch.seconds();
    }
    std::printf("| %s | %zu | %.1f %% | %.1f %% | %.1f %% | %.1f, %.1f, %.1f |\n", file.stem().c_str(), charts.size(),
                occupancy[0], occupancy[1], occupancy[2], seconds[0], seconds[1], seconds[2]);
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace
}  // namespace mq

int main(int count, char** words) { return mq::run_tool(mq::main, count, words); }

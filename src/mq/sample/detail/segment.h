#pragma once
/// Cutting a surface into charts.

#include <cstdint>
#include <vector>

#include "mq/mesh/surface.h"

namespace mq {

struct SegmentOptions {
  int charts = 28;        ///< exactly as many are made, if there are as many triangles
  int rounds = 12;        ///< of moving chart centres; 0 leaves them where chance put them
  double unevenness = 0;  ///< 0: charts of about one size; 1: from single triangles to large ones
  std::uint64_t seed = 1;
};

/// Per triangle its chart: the nearest of some centres along the surface, where distance counts
/// more across bends. Every chart is a disc: connected, with one boundary loop. Where the surface
/// needs more charts than asked for, there are more. The surface must be connected and without
/// degenerate triangles.
std::vector<int> segment(const Surface& surface, const SegmentOptions& options);

/// Per half-edge: 1 where its two triangles belong to different charts (never at the boundary).
std::vector<char> seams_between(const Surface& surface, const std::vector<int>& charts);

/// Per half-edge: 1 along shortest paths from vertex `root` to `tips` vertices spread as far as
/// can be: a tree, along which a closed surface of genus 0 becomes one disc.
std::vector<char> seams_along_tree(const Surface& surface, int root, int tips);

}  // namespace mq

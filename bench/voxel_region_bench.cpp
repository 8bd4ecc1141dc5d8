// voxel_region_bench [BEFORE AFTER]...: how much of a surface is replaced by `remesh`, and how much would be within the
// region that voxels are grown to from the same seeds, as the thesis does it, with voxels as wide as the tolerance and
// twice. Pairs are those of remesh_pairs_bench, or models. BEFORE is also put against itself, moved by a quarter of the
// tolerance, with one vertex as the seed, for 20 vertices: how many voxels that grows to on the mean, where nothing
// needs to be replaced.
#include <fmt/format.h>

#include <string>
#include <vector>

#include "mq/baseline/voxel_region.h"
#include "mq/io/model.h"
#include "mq/mesh/closest_point.h"
#include "mq/mesh/geometry.h"
#include "mq/remesh/detail/seeds.h"
#include "remesh/remesh_models.h"

namespace mq {
namespace {

std::vector<int> above_one(const std::vector<double>& scores) {
  std::vector<int> seeds;
  for (std::size_t v = 0; v < scores.size(); ++v)
    if (scores[v] > 1) seeds.push_back(int(v));
  return seeds;
}

/// Shares of the areas of both.
std::string shares(const VoxelRegion& region, const Surface& from, const Surface& to) {
  return fmt::format("{:.2f} %, {:.2f} %", 100 * region.template_area / from.area, 100 * region.target_area / to.area);
}

void print_row(const std::string& what, const Mesh& before, const Mesh& after) {
  const Surface from = make_surface(before), to = make_surface(after);
  const ClosestPointFinder of_before(from.mesh), of_after(to.mesh);
  const SeedScores scores = seed_scores({from, of_before}, {to, of_after}, {});
  const Remeshed found = remesh(from, to);
  double gone = from.area, come = 0;
  for (const int t : found.template_triangles)
    if (t >= 0) gone -= triangle_area(from.mesh, t);
  for (int t = 0; t < found.mesh.triangle_count(); ++t)
    if (found.template_triangles[std::size_t(t)] < 0) come += triangle_area(found.mesh, t);
  std::string row = fmt::format("| {} | {:.2f} %, {:.2f} %", what, 100 * gone / from.area, 100 * come / to.area);
  Mesh beside = from.mesh;
  for (Vector3& p : beside.positions) p += scores.tolerance / 4 * Vector3(1, 1, 1).normalized();
  const Surface moved = make_surface(beside);
  std::string still;
  for (const double side : {1.0, 2.0}) {
    const double voxel = side * scores.tolerance;
    row += " | " + shares(voxel_region(from.mesh, to.mesh, above_one(scores.of_template.scores),
                                       above_one(scores.of_target.scores), voxel),
                          from, to);
    constexpr int trials = 20;
    double voxels = 0;
    for (int trial = 0; trial < trials; ++trial) {
      const std::vector<int> seed = {int(from.mesh.positions.size()) * trial / trials};
      voxels += voxel_region(from.mesh, moved.mesh, seed, {}, voxel).voxels / double(trials);
    }
    still += fmt::format(" | {:.1f}", voxels);
  }
  fmt::print("{}{} |\n", row, still);
}

int run(int count, char** words) {
  using namespace test;
  fmt::print("| pair | `remesh`: goes, comes | voxels of the tolerance | twice that | moved, voxels of the tolerance | "
             "twice that |\n|---|---|---|---|---|---|\n");
  for (int i = 1; i + 1 < count; i += 2)
    print_row(fmt::format("{}, {}", words[i], words[i + 1]), read_model(words[i]).mesh, read_model(words[i + 1]).mesh);
  if (count > 1) return 0;
  const auto both_ways = [](const std::string& what, const Mesh& before, const Mesh& after) {
    print_row(what, before, after);
    print_row(what + ", and back", after, before);
  };
  both_ways("a figure gets a handle", meshed(figure, 20'000, 2), meshed(figure_with_handle, 36'000, 0));
  both_ways("two balls are joined", meshed(apart, 20'000, 4), meshed(joined, 30'000, 2));
  both_ways("the hole of a ring is plugged", meshed(ring, 20'000, 0), meshed(plugged, 20'000, 2));
  return 0;
}

}  // namespace
}  // namespace mq

int main(int count, char** words) { return mq::run(count, words); }

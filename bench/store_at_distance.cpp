// store_at_distance FRAMES DISTANCE STORE.evolving...: how many bytes the stores of evolving meshes take at an equal
// distance from what was captured, DISTANCE in % of the diagonal: the mean over all frames of what `track` measures
// (`surface_distance`, the mean). Positions are rounded to as coarse a step as that allows.
//
// Bytes are those of blocks: connectivity, ids, positions, and texture coordinates as finely as the store has them.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "tool.h"
#include "mq/base/error.h"
#include "mq/io/evolving_file.h"
#include "mq/io/frame_files.h"
#include "mq/io/model.h"
#include "mq/mesh/geometry.h"
#include "mq/track/tracking.h"

namespace mq {
namespace {

namespace fs = std::filesystem;
using Targets = std::vector<std::unique_ptr<TrackTarget>>;

Targets targets_of(const std::string& frames, const EvolvingMesh& evolving) {
  std::vector<int> numbers;
  for (const EvolvingFrame& frame : evolving.frames) numbers.push_back(frame.number);
  Targets targets;
  for (const FrameFile& file : find_frames(frames, numbers))
    targets.push_back(std::make_unique<TrackTarget>(read_model(file.path).mesh));
  return targets;
}

/// Means over all frames of the mean and the 95th percentile, and the largest of all.
SurfaceDistance distance(const EvolvingMesh& evolving, const Targets& targets, double step) {
  SurfaceDistance sum;
  for (std::size_t f = 0; f < targets.size(); ++f) {
    const EvolvingFrame& frame = evolving.frames[f];
    const Mesh mesh = mesh_of(evolving.segments[std::size_t(frame.segment)], rounded(frame.positions, step));
    const SurfaceDistance found = surface_distance(mesh, *targets[f]);
    sum.mean += found.mean / double(targets.size());
    sum.p95 += found.p95 / double(targets.size());
    sum.max = std::max(sum.max, found.max);
  }
  return sum;
}

int main(int count, char** words) {
  require(count >= 4, "usage: store_at_distance FRAMES DISTANCE STORE.evolving...");
  const double wanted = std::stod(words[2]) / 100;
  std::printf("| store | sets | distance as followed, mean | rounded, mean | 95 %% | by at most | bytes |\n"
              "|---|---|---|---|---|---|---|\n");
  for (int i = 3; i < count; ++i) {
    const EvolvingReader reader(words[i]);
    const EvolvingMesh evolving = reader.read();
    const Targets targets = targets_of(words[1], evolving);
    const double diagonal = targets[0]->diagonal();
    const SurfaceDistance before = distance(evolving, targets, reader.step());
    double low = reader.step() / diagonal, high = 0.02;  // by how much positions are off, of the diagonal
    const auto far = [&](double error) { return distance(evolving, targets, step_within(error * diagonal)); };
    require(before.mean < wanted, std::string(words[i]) + ": is farther than that as it was followed");
    while (high > 1.02 * low) {
      const double middle = std::sqrt(low * high);
      (far(middle).mean <= wanted ? low : high) = middle;
    }
    // Where positions lie on planes, as those of marching cubes do, distances do not only grow.
    double coarser = low;
    for (int more = 0; more < 12; ++more)
      if (far(coarser *= 1.05).mean <= wanted) low = coarser;
    const SurfaceDistance after = far(low);
    const fs::path made = fs::temp_directory_path() / ("store_at_distance_" + std::to_string(getpid()) + ".evolving");
    write_evolving(made, evolving, step_within(low * diagonal), "{}", {}, reader.uv_step());
    const fs::path blocks = fs::path(made).replace_extension(".blocks");
    std::printf("| %s | %zu | %.4f %% | %.4f %% | %.4f %% | %.4f %% | %zu |\n", fs::path(words[i]).stem().c_str(),
                evolving.segments.size(), 100 * before.mean, 100 * after.mean, 100 * after.p95, 100 * low,
                std::size_t(fs::file_size(blocks)));
    std::fflush(stdout);
    fs::remove(made);
    fs::remove(blocks);
  }
  return 0;
}

}  // namespace
}  // namespace mq

int main(int count, char** words) { return mq::run_tool(mq::main, count, words); }

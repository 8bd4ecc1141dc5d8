// Runs are joined with those of the row above that they touch: a union-find over runs, of which there are
// far fewer than texels.

#include "mq/atlas/texel_patches.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace mq {
namespace {

int root_of(std::vector<int>& parents, int run) {
  while (parents[run] != run) run = parents[run] = parents[parents[run]];
  return run;
}

void join(std::vector<int>& parents, int a, int b) {
  const int root_a = root_of(parents, a), root_b = root_of(parents, b);
  parents[std::max(root_a, root_b)] = std::min(root_a, root_b);
}

/// The patch of every run, named by its first run.
std::vector<int> joined_runs(std::span<const TexelRun> runs) {
  std::vector<int> parents(runs.size());
  std::iota(parents.begin(), parents.end(), 0);
  std::size_t above = 0;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const TexelRun& run = runs[i];
    const auto before = [&](const TexelRun& other) {
      return other.texture < run.texture || (other.texture == run.texture && other.row < run.row - 1) ||
             (other.texture == run.texture && other.row == run.row - 1 && other.last < run.first - 1);
    };
    while (above < i && before(runs[above])) ++above;
    for (std::size_t k = above; k < i && runs[k].row == run.row - 1 && runs[k].first <= run.last + 1; ++k)
      join(parents, int(k), int(i));
  }
  for (int i = 0; i < int(runs.size()); ++i) parents[i] = root_of(parents, i);
  return parents;
}

struct Middle {
  double columns = 0, rows = 0;                              ///< sums over texels
  double nearest = std::numeric_limits<double>::infinity();  ///< distance² of the texel taken so far
};

}  // namespace

std::vector<TexelRun> texel_runs(const TexelGrid& grid, std::vector<std::int64_t> texels) {
  std::ranges::sort(texels);
  std::vector<TexelRun> runs;
  int texture = 0;
  for (const std::int64_t texel : texels) {
    while (texture + 1 < grid.texture_count() && texel >= grid.first_texel(texture + 1)) ++texture;
    const int local = int(texel - grid.first_texel(texture)), width = grid.texture(texture).width;
    const int row = local / width, column = local % width;
    const bool beside = !runs.empty() && runs.back().texture == texture && runs.back().row == row &&
                        column <= runs.back().last + 1;
    if (beside)
      runs.back().last = column;
    else
      runs.push_back({texture, row, column, column});
  }
  return runs;
}

std::vector<Defect::Place> texel_patches(std::span<const TexelRun> runs) {
  const std::vector<int> patch = joined_runs(runs);
  std::vector<Defect::Place> places(runs.size());  // of first runs; others stay without texels
  std::vector<Middle> middles(runs.size());
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const TexelRun& run = runs[i];
    const int count = run.last - run.first + 1;
    places[patch[i]].texels += count;
    middles[patch[i]].columns += 0.5 * count * (run.first + run.last);
    middles[patch[i]].rows += double(count) * run.row;
  }
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const TexelRun& run = runs[i];
    Defect::Place& place = places[patch[i]];
    Middle& middle = middles[patch[i]];
    const double x = middle.columns / double(place.texels), y = middle.rows / double(place.texels);
    const int column = std::clamp(int(std::lround(x)), run.first, run.last);
    const double distance = (column - x) * (column - x) + (run.row - y) * (run.row - y);
    if (distance >= middle.nearest) continue;
    middle.nearest = distance;
    place.texture = run.texture, place.column = column, place.row = run.row;
  }
  std::erase_if(places, [](const Defect::Place& place) { return place.texels == 0; });
  std::ranges::stable_sort(places, std::ranges::greater(), &Defect::Place::texels);
  return places;
}

void list_places(const TexelGrid& grid, std::vector<std::int64_t> texels, Defect& defect) {
  const std::vector<TexelRun> runs = texel_runs(grid, std::move(texels));
  defect.places = texel_patches(runs);
  defect.place_count = std::ssize(defect.places);
  defect.places.resize(std::min<std::size_t>(defect.places.size(), Defect::max_places));
}

}  // namespace mq

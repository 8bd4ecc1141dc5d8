// Pairs of bodies of which one has what the other has not, and how much of each local remeshing
// keeps, as docs/remesh.md has them.
//
//     remesh_pairs_bench            the table, as Markdown
//     remesh_pairs_bench FOLDER     the pairs as NAME_before.ply and NAME_after.ply
//     remesh_pairs_bench 0 1000     random pairs (tests/sequence/remesh_models.h) with numbers from
//     0
//                                   to 999: what is wrong with any result, and how many have
//                                   nothing
//
// Seconds are processor time of the library alone, of all threads together.

#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <string>
#include <vector>

#include "mq/base/error.h"
#include "mq/io/model.h"
#include "mq/mesh/closest_point.h"
#include "remesh/remesh_models.h"

namespace mq {
namespace {

struct Side {
  Solid solid;
  int triangles;
  int euler_characteristic;
};

struct Pair {
  std::string name, what;
  Side before, after;
};

std::vector<Pair> pairs() {
  using namespace test;
  return {
      {"figure", "a figure gets a handle", {figure, 86'000, 2}, {figure_with_handle, 160'000, 0}},
      {"coarse", "the same, coarse", {figure, 20'000, 2}, {figure_with_handle, 36'000, 0}},
      {"balls", "two balls are joined", {apart, 20'000, 4}, {joined, 30'000, 2}},
      {"ring", "the hole of a ring is plugged", {ring, 20'000, 0}, {plugged, 20'000, 2}}};
}

Mesh mesh_of(const Side& side) {
  return test::meshed(side.solid, side.triangles, side.euler_characteristic);
}

void write(const std::string& path, Mesh mesh) {
  Model model;
  model.path = path;
  model.mesh = std::move(mesh);
  write_model(path, model);
}

/// Triangles of which all corners are nearer to the other surface than the tolerance: none of them
/// has to go for itself.
int shown_triangles(const Surface& surface, const Surface& other, double tolerance) {
  const std::vector<ClosestPoint> places = ClosestPointFinder(other.mesh)(surface.mesh.positions);
  return int(std::ranges::count_if(surface.mesh.triangles, [&](const Triangle& t) {
    return std::ranges::all_of(
        t, [&](int v) { return places[std::size_t(v)].squared_distance <= tolerance * tolerance; });
  }));
}

void print_row(const std::string& what, const Mesh& before, const Mesh& after) {
  const Surface from = make_surface(before), to = make_surface(after);
  const std::clock_t start = std::clock();
  const Remeshed found = remesh(from, to);
  const double seconds = double(std::clock() - start) / CLOCKS_PER_SEC;
  const double diagonal = bounding_box(to.mesh).diagonal();
  const std::string wrong = test::problems(from, to, found);
  const int shown = shown_triangles(from, to, found.tolerance);
  fmt::print("| {} | {} | {} | {:.2f} % | {:.2f} % | {} | {} | {:.1e} | {:.1e} | {} | {:.2f} |\n",
             what, from.triangle_count(), to.triangle_count(),
             100.0 * found.kept / from.triangle_count(), 100.0 * found.kept / shown, found.added,
             found.removed, found.from_target.mean / diagonal, found.from_target.max / diagonal,
             wrong.empty() ? "yes" : wrong, seconds);
}

/// Random pairs of surfaces, results that are none or have triangles turned over along their seams.
int fuzz(std::uint64_t first, std::uint64_t last) {
  int sound = 0, turned_pairs = 0, wrong_pairs = 0, refused = 0;
  for (std::uint64_t seed = first; seed < last; ++seed) {
    const auto [before, after] = test::random_pair(seed);
    const Surface from = make_surface(before), to = make_surface(after);
    try {
      const Remeshed found = remesh(from, to);
      const std::string wrong = test::problems(from, to, found);
      const int turned = test::turned_triangles(from, to, found);
      if (!wrong.empty() || turned > 0)
        fmt::print("pair {}: {} + {} triangles, {} kept, {} born, {} rounds: {}{} turned\n", seed,
                   from.triangle_count(), to.triangle_count(), found.kept, found.added,
                   found.rounds, wrong, turned);
      wrong_pairs += !wrong.empty();
      turned_pairs += turned > 0;
      sound += wrong.empty() && turned == 0;
    } catch (const InvalidInput& error) {
      ++refused;
    }
  }
  fmt::print("{} sound, {} with triangles turned over, {} no surface, {} refused\n", sound,
             turned_pairs, wrong_pairs, refused);
  return wrong_pairs;
}

int run(int count, char** words) {
  if (count > 2) return fuzz(std::stoull(words[1]), std::stoull(words[2]));
  if (count > 1) {
    for (const Pair& pair : pairs()) {
      const std::string start = std::string(words[1]) + "/" + pair.name;
      write(start + "_before.ply", mesh_of(pair.before));
      write(start + "_after.ply", mesh_of(pair.after));
    }
    return 0;
  }
  fmt::print(
      "| pair | template | target | kept | of what is shown | born | died | distance, mean | max | "
      "manifold | s |\n|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const Pair& pair : pairs()) {
    const Mesh before = mesh_of(pair.before), after = mesh_of(pair.after);
    print_row(pair.what, before, after);
    print_row(pair.what + ", and back", after, before);
  }
  return 0;
}

}  // namespace
}  // namespace mq

int main(int count, char** words) { return mq::run(count, words); }

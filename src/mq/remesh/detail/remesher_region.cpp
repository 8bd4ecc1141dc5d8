// The region in which the template is replaced: it grows where the cut fails, and a component of
// which it takes too much goes as a whole.

#include "mq/remesh/detail/remesher.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

#include "mq/mesh/geometry.h"
#include "mq/mesh/weld.h"

namespace mq {
namespace {

constexpr int most_rounds = 60;
constexpr double grown_farther = 0.5;  // in radii: what grows, grows by less

/// Sets of points that hang together by steps of at most this.
DisjointSets near_one_another(const std::vector<Vector3>& points, double step) {
  using Key = std::array<long, 3>;
  std::map<Key, std::vector<int>> cells;
  const auto cell = [&](const Vector3& p) {
    const Vector3 q = ((p - points[0]) / step).array().floor();
    return Key{long(q.x()), long(q.y()), long(q.z())};
  };
  for (std::size_t i = 0; i < points.size(); ++i) cells[cell(points[i])].push_back(int(i));
  DisjointSets sets(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Key middle = cell(points[i]);
    for (long n = 0; n < 27; ++n) {
      const auto found =
          cells.find({middle[0] + n % 3 - 1, middle[1] + n / 3 % 3 - 1, middle[2] + n / 9 - 1});
      if (found == cells.end()) continue;
      for (const int other : found->second)
        if (other < int(i) && (points[other] - points[i]).norm() <= step)
          sets.join(int(i), other);
    }
  }
  return sets;
}

}  // namespace

/// Area inside the region, per group.
std::vector<double> Remesher::inside_area() const {
  std::vector<double> area(replaced_.size(), 0);
  for (int t = 0; t < pair_.mesh.triangle_count(); ++t) {
    int inside = 0;
    for (const int v : pair_.mesh.triangles[t])
      inside += region_->distances()[v] < region_->radius();
    area[group(t)] += triangle_area(pair_.mesh, t) * inside / 3;
  }
  return area;
}

/// Adds them to the region, as seeds or grown; whether any was not in it.
bool Remesher::mark(const std::vector<int>& vertices, Mark how) {
  marked_.resize(pair_.mesh.positions.size(), Mark::none);
  std::vector<char> marked(marked_.size()), fresh(marked_.size(), 0);
  bool any = false;
  for (const int v : vertices)
    if (marked_[v] == Mark::none) marked_[v] = how, fresh[v] = 1, any = true;
  for (std::size_t v = 0; v < marked.size(); ++v) marked[v] = marked_[v] != Mark::none;
  region_->mark(pair_, marked, fresh, how == Mark::grown ? grown_farther * region_->radius() : 0);
  return any;
}

/// These vertices and all of the triangles around them.
std::vector<int> Remesher::with_neighbours(const std::vector<int>& vertices) const {
  std::vector<char> asked(pair_.mesh.positions.size(), 0);
  for (const int v : vertices) asked[v] = 1;
  std::vector<int> all = vertices;
  for (const Triangle& t : pair_.mesh.triangles)
    if (asked[t[0]] || asked[t[1]] || asked[t[2]]) all.insert(all.end(), t.begin(), t.end());
  return all;
}

/// 1 for groups that these vertices belong to.
std::vector<char> Remesher::groups_of(const std::vector<int>& vertices) const {
  std::vector<char> asked(pair_.mesh.positions.size(), 0), groups(replaced_.size(), 0);
  for (const int v : vertices) asked[v] = 1;
  for (int t = 0; t < pair_.mesh.triangle_count(); ++t)
    for (const int v : pair_.mesh.triangles[t])
      if (asked[v]) groups[group(t)] = 1;
  return groups;
}

/// The region anew, without the groups that are replaced as a whole.
void Remesher::restart_region() {
  std::vector<char> live(pair_.mesh.positions.size(), 0);
  for (int t = 0; t < pair_.mesh.triangle_count(); ++t)
    if (!replaced_[group(t)])
      for (const int v : pair_.mesh.triangles[t]) live[v] = 1;
  marked_.resize(live.size(), Mark::none);
  const std::vector<Mark> before = marked_;
  marked_.assign(live.size(), Mark::none);
  region_.emplace(result_.tolerance);
  for (const Mark how : {Mark::seed, Mark::grown}) {
    std::vector<int> all;
    for (std::size_t v = 0; v < live.size(); ++v)
      if (live[v] && before[v] == how) all.push_back(int(v));
    mark(all, how);
  }
}

/// Takes these groups out of what is cut; cuts made so far are forgotten.
void Remesher::replace(const std::vector<char>& groups) {
  for (std::size_t g = 0; g < groups.size(); ++g)
    if (groups[g]) replaced_[g] = 1;
  pair_ = join(template_, target_);
  restart_region();
}

/// Whether anything of the template lies outside the region.
bool Remesher::template_stays() const {
  for (int t = 0; t < template_.triangle_count(); ++t)
    for (const int v : pair_.mesh.triangles[t])
      if (!replaced_[group(t)] && region_->distances()[v] > region_->radius()) return true;
  return false;
}

/// 1 for groups that grew too much; empty where none did.
std::vector<char> Remesher::outgrown_groups() const {
  const std::vector<double> inside = inside_area();
  std::vector<char> outgrown(replaced_.size(), 0);
  bool any = false;
  for (std::size_t g = 0; g < outgrown.size(); ++g) {
    outgrown[g] = !replaced_[g] && inside[g] > first_inside_[g] + options_.growth * group_area_[g];
    any |= outgrown[g] != 0;
  }
  return any ? outgrown : std::vector<char>();
}

void Remesher::replace_outgrown() {
  const std::vector<char> outgrown = outgrown_groups();
  if (!outgrown.empty()) replace(outgrown);
}

/// Gives up what grew too much of it: all marks near one another of which some grew.
void Remesher::leave_outgrown() {
  const std::vector<char> outgrown = outgrown_groups();
  if (outgrown.empty()) return;
  std::vector<int> marked;
  std::vector<Vector3> points;
  std::vector<char> in_group(pair_.mesh.positions.size(), 0);
  for (int t = 0; t < pair_.mesh.triangle_count(); ++t)
    if (outgrown[group(t)])
      for (const int v : pair_.mesh.triangles[t]) in_group[v] = 1;
  marked_.resize(pair_.mesh.positions.size(), Mark::none);
  for (std::size_t v = 0; v < marked_.size(); ++v)
    if (marked_[v] != Mark::none && in_group[v])
      marked.push_back(int(v)), points.push_back(pair_.mesh.positions[v]);
  DisjointSets near = near_one_another(points, 2 * region_->radius());
  std::vector<char> grew(points.size(), 0);
  for (std::size_t i = 0; i < points.size(); ++i)
    if (marked_[marked[i]] == Mark::grown) grew[near.root(int(i))] = 1;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (grew[near.root(int(i))]) {
      result_.left_outgrown += marked_[marked[i]] == Mark::seed;
      marked_[marked[i]] = Mark::none;
    }
  pair_ = join(template_, target_);
  marked_.resize(pair_.mesh.positions.size());
  restart_region();
  first_inside_ = inside_area();
}

Remesher::Cut Remesher::grow(const Progress& progress) {
  Stopwatch watch;
  for (const char seed : spread_seeds(pair_, scores_, options_.keep))
    marked_.push_back(seed ? Mark::seed : Mark::none);
  restart_region();
  first_inside_ = inside_area();
  result_.reached = int(std::count_if(
      pair_.mesh.triangles.begin(), pair_.mesh.triangles.begin() + template_.triangle_count(),
      [&](const Triangle& t) {
        return std::ranges::any_of(
            t, [&](int v) { return region_->distances()[v] <= region_->radius(); });
      }));
  for (int round = 1;; ++round) {
    progress.at(std::min(0.95, 0.1 * round), fmt::format("round {}", round));
    std::optional<Cut> cut;
    if (template_stays()) cut = attempt();
    if (!cut || round >= most_rounds) {
      replace(std::vector<char>(replaced_.size(), 1));
      cut = attempt();
    }
    if (cut->failed.empty()) cut->failed = uncovered(*cut);
    result_.rounds = round;
    if (cut->failed.empty() || round >= most_rounds) {
      note("grow", watch);
      return *cut;
    }
    if (!mark(with_neighbours(cut->failed), Mark::grown)) replace(groups_of(cut->failed));
    if (options_.outgrown == RemeshOptions::Outgrown::left)
      leave_outgrown();
    else
      replace_outgrown();
  }
}

}  // namespace mq

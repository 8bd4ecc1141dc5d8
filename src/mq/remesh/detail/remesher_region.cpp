// The region in which the template is replaced: it grows where the cut fails, and a component of
// which it takes too much goes as a whole.

#include "mq/remesh/detail/remesher.h"

#include <fmt/format.h>

#include <algorithm>

#include "mq/mesh/geometry.h"

namespace mq {
namespace {

constexpr int most_rounds = 60;
constexpr double grown_farther = 0.5;  // in radii: what grows, grows by less

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

/// Replaces groups that grew too much; whether there were any.
bool Remesher::replace_outgrown() {
  const std::vector<double> inside = inside_area();
  std::vector<char> outgrown(replaced_.size(), 0);
  bool any = false;
  for (std::size_t g = 0; g < outgrown.size(); ++g) {
    outgrown[g] = !replaced_[g] && inside[g] > first_inside_[g] + options_.growth * group_area_[g];
    any |= outgrown[g] != 0;
  }
  if (any) replace(outgrown);
  return any;
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
    replace_outgrown();
  }
}

}  // namespace mq

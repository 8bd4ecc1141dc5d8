#include "mq/track/recognised_points.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "mq/track/detail/shares.h"
#include "mq/track/path_lengths.h"

namespace mq {
namespace {

constexpr double unreached = std::numeric_limits<double>::infinity();

/// Points that mean lengths are taken to.
constexpr int mean_samples = 48;
/// By which part of the largest mean length an extremity stands out, at least.
constexpr double least_persistence = 0.05;
/// Lengths between extremities that are the same differ by no more than this part; so do means.
constexpr double most_difference = 0.25;
/// What the moves of extremities count, against their pairs.
constexpr double weight_of_moves = 0.5;

/// Per vertex the mean length of paths to all others, by area; 0 at vertices without triangles.
std::vector<double> mean_lengths(const Mesh& mesh, const PathLengths& paths) {
  const std::size_t n = mesh.positions.size();
  const std::vector<double> shares = area_shares(mesh);
  std::vector<double> nearest(n, unreached);
  std::vector<int> owner(n, -1);
  std::vector<std::vector<double>> lengths;
  const auto farthest = [&] {
    int at = -1;
    for (std::size_t v = 0; v < n; ++v)
      if (shares[v] > 0 && (at < 0 || nearest[v] > nearest[at])) at = int(v);
    return at;
  };
  for (int i = 0; i < mean_samples; ++i) {
    const int from = farthest();
    if (from < 0 || nearest[from] == 0) break;
    lengths.push_back(paths(from));
    for (std::size_t v = 0; v < n; ++v)
      if (lengths.back()[v] < nearest[v]) nearest[v] = lengths.back()[v], owner[v] = i;
  }
  std::vector<double> areas(lengths.size(), 0);
  for (std::size_t v = 0; v < n; ++v)
    if (owner[v] >= 0) areas[owner[v]] += shares[v];
  std::vector<double> means(n, 0);
  for (std::size_t v = 0; v < n; ++v) {
    double sum = 0, area = 0;
    for (std::size_t i = 0; i < lengths.size(); ++i)
      if (lengths[i][v] < unreached) sum += areas[i] * lengths[i][v], area += areas[i];
    if (area > 0) means[v] = sum / area;
  }
  return means;
}

struct Peak {
  int vertex;
  double persistence;
};

/// Local maxima and how far one has to go down from each before one can go up to a larger one, most first.
std::vector<Peak> peaks(const Mesh& mesh, const PathLengths& paths, const std::vector<double>& values) {
  std::vector<int> order(values.size()), parent(values.size());
  std::iota(order.begin(), order.end(), 0);
  std::iota(parent.begin(), parent.end(), 0);
  std::ranges::sort(order, [&](int a, int b) { return values[a] != values[b] ? values[a] > values[b] : a < b; });
  const auto root = [&](int v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  std::vector<char> seen(values.size(), 0);
  std::vector<Peak> found;
  for (const int v : order) {
    seen[v] = 1;
    for (const int t : paths.around(v))
      for (const int other : mesh.triangles[t]) {
        if (!seen[other] || root(other) == root(v)) continue;
        int high = root(v), low = root(other);  // roots are the highest of theirs
        if (values[low] > values[high] || (values[low] == values[high] && low < high)) std::swap(low, high);
        found.push_back({low, values[low] - values[v]});
        parent[low] = high;
      }
  }
  for (const int v : order)
    if (root(v) == v && values[v] > 0) found.push_back({v, values[v]});
  std::ranges::sort(found, [](const Peak& a, const Peak& b) {
    return a.persistence != b.persistence ? a.persistence > b.persistence : a.vertex < b.vertex;
  });
  return found;
}

/// How alike two lengths are, from 1 to 0; less: they are not the same.
double likeness(double a, double b) {
  if (a == unreached && b == unreached) return 0;
  if (a == unreached || b == unreached) return -1;
  const double part = (a - b) / (most_difference * (a + b) / 2);
  return 1 - part * part;
}

/// Goes through all that can be matched, and keeps the best.
class ExtremityMatcher {
 public:
  ExtremityMatcher(const Extremities& first, const Extremities& second,
                   const std::vector<std::vector<double>>& moves, int most)
      : first_(first), second_(second), moves_(moves), most_(most), used_(second.vertices.size(), 0) {}

  std::vector<MatchedExtremities> operator()() {
    match(0);
    return std::move(best_);
  }

 private:
  double between(const Extremities& of, int a, int b) const { return of.lengths[a][of.vertices[b]]; }

  /// What one more pair adds, or less than nothing where it cannot be.
  double gain(int a, int b) const {
    const double alone = likeness(first_.means[a], second_.means[b]);
    if (alone < 0) return -1;
    double sum = alone - weight_of_moves * moves_[a][b];
    for (const auto& [c, d] : now_.pairs) {
      const double alike = likeness(between(first_, a, c), between(second_, b, d));
      if (alike < 0) return -1;
      sum += alike;
    }
    return std::max(sum, 0.0);
  }

  void match(int a) {
    const int left = int(first_.vertices.size()) - a, matched = int(now_.pairs.size());
    // Each that is left can add 1 by itself, and 1 with each that is matched then.
    const double bound = now_.score + left * (1 + matched) + left * (left - 1) / 2.0;
    if (int(best_.size()) == most_ && !(bound > best_.back().score)) return;
    if (left == 0) {
      if (matched < 2) return;
      const auto at = std::ranges::find_if(best_, [&](const auto& m) { return m.score < now_.score; });
      best_.insert(at, now_);
      if (int(best_.size()) > most_) best_.pop_back();
      return;
    }
    for (int b = 0; b < int(second_.vertices.size()); ++b) {
      if (used_[b]) continue;
      const double more = gain(a, b);
      if (more < 0) continue;
      const double before = now_.score;
      now_.pairs.push_back({a, b}), now_.score += more, used_[b] = 1;
      match(a + 1);
      now_.pairs.pop_back(), now_.score = before, used_[b] = 0;
    }
    match(a + 1);
  }

  const Extremities &first_, &second_;
  const std::vector<std::vector<double>>& moves_;
  int most_;
  std::vector<char> used_;
  MatchedExtremities now_;
  std::vector<MatchedExtremities> best_;
};

}  // namespace

Extremities extremities(const Mesh& mesh, int most) {
  const PathLengths paths(mesh);
  const std::vector<double> means = mean_lengths(mesh, paths);
  const double least = least_persistence * *std::ranges::max_element(means);
  Extremities found;
  for (const Peak& p : peaks(mesh, paths, means)) {
    if (!(p.persistence > least) || std::ssize(found.vertices) == most) break;
    found.vertices.push_back(p.vertex);
    found.means.push_back(means[p.vertex]);
  }
  found.lengths = paths(found.vertices);
  return found;
}

std::vector<MatchedExtremities> matched_extremities(const Extremities& first, const Extremities& second,
                                                    const std::vector<std::vector<double>>& moves,
                                                    int most) {
  return ExtremityMatcher(first, second, moves, most)();
}

}  // namespace mq

// Nothing is cut out, so the surface stays where it is and what it is, however many triangles are
// renewed and however they lie: only ids and the triangulation change.

#include "mq/remesh/detail/retriangulate.h"

#include <algorithm>

namespace mq {
namespace {

constexpr double longest_in_rests = 2;  // edges of the mean one at rest
constexpr int most_halvings = 12;       // in a row: edges 4096 times as long

double mean_edge(const std::array<Vector3, 3>& corners) {
  double sum = 0;
  for (int k = 0; k < 3; ++k)
    sum += (corners[std::size_t((k + 1) % 3)] - corners[std::size_t(k)]).norm();
  return sum / 3;
}

class Renewer {
 public:
  Renewer(SurfacePair& pair, std::vector<char>& kept, const std::vector<char>& distorted,
          std::span<const std::array<Vector3, 3>> rest)
      : pair_(pair), kept_(kept), distorted_(distorted), rest_(rest) {}

  Retriangulation run() {
    choose();
    for (int round = 0; round < most_halvings && !rest_.empty(); ++round) {
      const std::vector<int> long_ones = too_long();
      if (long_ones.empty()) break;
      halve_longest_edges(pair_, long_ones);
      kept_.resize(pair_.mesh.triangles.size(), 1);
      result_.triangles.resize(pair_.mesh.triangles.size(), 1);
      result_.vertices.resize(pair_.mesh.positions.size(), 1);
    }
    return std::move(result_);
  }

 private:
  bool is_distorted(int t) const {
    return !distorted_.empty() && !pair_.triangle_of_target(t) &&
           distorted_[pair_.source_triangle[t]] != 0;
  }

  void choose() {
    const int count = pair_.mesh.triangle_count();
    result_.triangles.assign(std::size_t(count), 0);
    // Corners of distorted triangles around which everything is kept, and nothing ends.
    std::vector<char>& free = result_.vertices;
    free.assign(pair_.mesh.positions.size(), 0);
    for (int t = 0; t < count; ++t)
      if (kept_[t] && pair_.whole[t] && is_distorted(t)) {
        result_.triangles[t] = 1;
        for (const int v : pair_.mesh.triangles[t]) free[v] = 1;
      }
    for (int t = 0; t < count; ++t) {
      const Triangle& corners = pair_.mesh.triangles[t];
      for (int k = 0; k < 3; ++k) {
        if (!kept_[t] || !pair_.whole[t]) free[corners[k]] = 0;
        if (pair_.twins[3 * t + k] < 0) free[corners[k]] = free[corners[(k + 1) % 3]] = 0;
      }
    }
    for (int t = 0; t < count; ++t)
      if (std::ranges::any_of(pair_.mesh.triangles[t], [&](int v) { return free[v] != 0; }))
        result_.triangles[t] = 1;
  }

  /// Triangles whose longest edge is to be halved so that those of distorted ones become shorter,
  /// and is the longest of what lies across as well: from triangle to triangle across longest edges
  /// (Rivara, New longest-edge algorithms for the refinement and/or improvement of unstructured
  /// triangulations, 1997). None where that leads out of what is renewed.
  std::vector<int> too_long() const {
    std::vector<int> found;
    for (int t = 0; t < pair_.mesh.triangle_count(); ++t) {
      if (!result_.triangles[t] || !is_distorted(t)) continue;
      const double most = longest_in_rests * mean_edge(rest_[pair_.source_triangle[t]]);
      if (!(most > 0) || !(longest_edge(pair_.mesh, t) > most)) continue;
      for (int s = t;;) {
        const HalfEdge across = pair_.twins[longest_half_edge(pair_.mesh, s)];
        if (across >= 0 && !result_.triangles[across / 3]) break;
        if (across < 0 || !(longest_edge(pair_.mesh, across / 3) > longest_edge(pair_.mesh, s))) {
          found.push_back(s);
          break;
        }
        s = across / 3;
      }
    }
    return found;
  }

  SurfacePair& pair_;
  std::vector<char>& kept_;
  const std::vector<char>& distorted_;
  std::span<const std::array<Vector3, 3>> rest_;
  Retriangulation result_;
};

}  // namespace

Retriangulation retriangulate(SurfacePair& pair, std::vector<char>& kept,
                              const std::vector<char>& distorted,
                              std::span<const std::array<Vector3, 3>> rest) {
  return Renewer(pair, kept, distorted, rest).run();
}

}  // namespace mq

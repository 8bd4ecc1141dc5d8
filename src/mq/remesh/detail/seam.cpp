// Every operation is local and checks the triangles that it makes: their quality may not fall below
// that of those before, nor may they turn away from the normals of the surfaces they came from.

#include "mq/remesh/detail/seam.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "mq/mesh/geometry.h"
#include "mq/remesh/detail/flaws.h"

namespace mq {
namespace {

constexpr int passes = 3;
constexpr double shortest = 0.4;       // of the mean edge around
constexpr double flattest = 0.866;     // cosine between two triangles whose edge may be flipped
constexpr double least_facing = 0.5;   // cosine between a vertex and the target it is put onto

bool has(const Triangle& t, int v) { return t[0] == v || t[1] == v || t[2] == v; }

class SeamMesh {
 public:
  SeamMesh(const SurfacePair& pair, const Mesh& target, const ClosestPointFinder& finder,
           Seam& seam)
      : pair_(pair),
        target_(target),
        finder_(finder),
        seam_(seam),
        ring_(pair.of_target.size(), -1),
        around_(pair.of_target.size()) {
    find_rings();
    find_around();
  }

  void run() {
    move_by_offsets();
    for (int pass = 0; pass < passes; ++pass) {
      collapse_all();
      flip_all();
      slide_all();
    }
    compact();
  }

 private:
  void find_rings() {
    for (std::size_t i = 0; i < seam_.triangles.size(); ++i)
      if (seam_.from[i] < 0)
        for (const int v : seam_.triangles[i])
          if (pair_.of_target[v] || seam_.free[v]) ring_[v] = 0;
    for (int ring = 1; ring <= 2; ++ring) {
      std::vector<int> reached;
      for (const Triangle& t : seam_.triangles)
        if (pair_.of_target[t[0]] &&
            std::ranges::any_of(t, [&](int v) { return ring_[v] == ring - 1; }))
          for (const int v : t)
            if (ring_[v] < 0 && pair_.of_target[v]) reached.push_back(v);
      for (const int v : reached) ring_[v] = ring;
    }
    free_.resize(seam_.triangles.size(), 0);
    for (std::size_t i = 0; i < free_.size(); ++i) {
      const Triangle& t = seam_.triangles[i];
      const bool near =
          std::ranges::any_of(t, [&](int v) { return ring_[v] == 0 || ring_[v] == 1; });
      free_[i] = seam_.from[i] < 0 || (pair_.triangle_of_target(seam_.from[i]) && near);
    }
  }

  void find_around() {
    std::vector<char> wanted(ring_.size(), 0);
    for (std::size_t i = 0; i < free_.size(); ++i)
      if (free_[i])
        for (const int v : seam_.triangles[i]) wanted[v] = 1;
    for (std::size_t i = 0; i < free_.size(); ++i)
      for (const int v : seam_.triangles[i])
        if (wanted[v]) around_[v].push_back(int(i));
    for (std::size_t v = 0; v < ring_.size(); ++v)
      if ((ring_[v] == 0 || ring_[v] == 1) && wanted[v] && inner(int(v)))
        movable_.push_back(int(v));
  }

  /// Whether every edge at v has a triangle on both sides, and all of them are free.
  bool inner(int v) const {
    std::vector<int> heads, tails;
    for (const int i : around_[v]) {
      const Triangle& t = seam_.triangles[i];
      if (!free_[i]) return false;
      const int k = corner(t, v);
      heads.push_back(t[(k + 1) % 3]);
      tails.push_back(t[(k + 2) % 3]);
    }
    std::ranges::sort(heads);
    std::ranges::sort(tails);
    return heads == tails && std::ranges::adjacent_find(heads) == heads.end();
  }

  static int corner(const Triangle& t, int v) { return t[0] == v ? 0 : t[1] == v ? 1 : 2; }

  const Vector3& at(int v) const { return seam_.positions[v]; }

  Vector3 wanted_normal(const Triangle& t) const {
    return pair_.normals[t[0]] + pair_.normals[t[1]] + pair_.normals[t[2]];
  }

  double quality(const Triangle& t) const {
    return triangle_quality(at(t[0]), at(t[1]), at(t[2]), wanted_normal(t));
  }

  double worst_around(int v) const {
    double worst = 1;
    for (const int i : around_[v]) worst = std::min(worst, quality(seam_.triangles[i]));
    return worst;
  }

  std::ptrdiff_t count_bent(int v) const {
    return std::ranges::count_if(around_[v], [&](int i) { return bends(seam_.triangles[i]); });
  }

  double mean_edge(int v) const {
    double sum = 0;
    for (const int w : neighbours(v)) sum += (at(w) - at(v)).norm();
    return sum / double(std::max<std::size_t>(1, neighbours(v).size()));
  }

  std::vector<int> neighbours(int v) const {
    std::vector<int> found;
    for (const int i : around_[v])
      for (const int w : seam_.triangles[i])
        if (w != v) found.push_back(w);
    std::ranges::sort(found);
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
  }

  /// Puts v there if no triangle gets worse than it may be.
  bool try_move(int v, const Vector3& to, double least) {
    const Vector3 before = at(v);
    const double worst = std::min(least, worst_around(v));
    const auto bent = count_bent(v);
    seam_.positions[v] = to;
    if (worst_around(v) >= worst && worst_around(v) > 0 && count_bent(v) <= bent) return true;
    seam_.positions[v] = before;
    return false;
  }

  void move_by_offsets() {
    for (const int v : movable_) {
      const Vector3 offset = seam_.offsets[v] * (seam_.free[v] ? 1 : ring_[v] == 0 ? 0.5 : 0.25);
      if (!offset.isZero()) try_move(v, at(v) + offset, 0.2);
    }
  }

  void slide_all() {
    for (const int v : movable_) {
      const std::vector<int> ring = neighbours(v);
      if (ring.empty()) continue;
      Vector3 middle = Vector3::Zero();
      for (const int w : ring) middle += at(w);
      const Vector3 step = 0.5 * (middle / double(ring.size()) - at(v));
      const Vector3& n = pair_.normals[v];
      const Vector3 to = at(v) + step - step.dot(n) * n;
      if (!seam_.free[v])
        try_move(v, to, 0.5);
      else if (const Vector3 on = onto_target(to, n); !try_move(v, on, 0.5))
        try_move(v, (at(v) + on) / 2, 0.5);
    }
  }

  /// The nearest point of the target, if that faces alike.
  Vector3 onto_target(const Vector3& point, const Vector3& normal) {
    const ClosestPoint place = finder_(point);
    return triangle_normal(target_, place.triangle).dot(normal) > least_facing
               ? point_at(target_, place)
               : point;
  }

  void collapse_all() {
    std::vector<int> left;
    for (const int v : movable_)
      if (!try_collapse(v)) left.push_back(v);
    movable_ = std::move(left);
  }

  bool try_collapse(int v) {
    const std::vector<int> ring = neighbours(v);
    const double limit = shortest * mean_edge(v);
    std::optional<int> best;
    double length = limit;
    for (const int u : ring)
      if ((at(u) - at(v)).norm() < length && may_collapse(v, u, ring))
        best = u, length = (at(u) - at(v)).norm();
    if (best) collapse(v, *best);
    return best.has_value();
  }

  bool may_collapse(int v, int u, const std::vector<int>& ring) const {
    // The link condition: two common neighbours, and more than a tetrahedron.
    const std::vector<int> others = neighbours(u);
    std::vector<int> common;
    std::ranges::set_intersection(ring, others, std::back_inserter(common));
    if (common.size() != 2 || ring.size() < 4) return false;
    for (const int w : common)
      if (neighbours(w).size() < 4) return false;
    const double worst = std::min(0.4, worst_around(v));
    for (const int i : around_[v]) {
      Triangle t = seam_.triangles[i];
      if (has(t, u)) continue;
      t[corner(t, v)] = u;
      const double q = quality(t);
      if (q <= 0 || q < worst || bends(t)) return false;
    }
    return true;
  }

  /// Whether a triangle turns away from the surface.
  bool bends(const Triangle& t) const {
    const Vector3 normal = (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0]));
    const Vector3 wanted = wanted_normal(t);
    return !(normal.dot(wanted) > least_cosine * normal.norm() * wanted.norm());
  }

  void collapse(int v, int u) {
    for (const int i : around_[v]) {
      Triangle& t = seam_.triangles[i];
      seam_.from[i] = -1;
      if (has(t, u)) {
        for (const int w : t)
          if (w != v) std::erase(around_[w], i);
        t = {-1, -1, -1};
      } else {
        t[corner(t, v)] = u;
        around_[u].push_back(i);
      }
    }
    around_[v].clear();
  }

  void flip_all() {
    bool changed = true;
    for (int round = 0; changed && round < 5; ++round) {
      changed = false;
      for (int i = 0; i < std::ssize(free_); ++i)
        if (free_[i])
          for (int k = 0; k < 3 && seam_.triangles[i][0] >= 0; ++k) changed |= try_flip(i, k);
    }
  }

  /// The other triangle at the edge that begins at corner k; nothing where it is not free.
  std::optional<int> across(int i, int k) const {
    const int a = seam_.triangles[i][k], b = seam_.triangles[i][(k + 1) % 3];
    std::optional<int> found;
    for (const int j : around_[a]) {
      const Triangle& t = seam_.triangles[j];
      if (j == i || !has(t, b)) continue;
      if (found || !free_[j] || t[(corner(t, b) + 1) % 3] != a) return std::nullopt;
      found = j;
    }
    return found;
  }

  bool try_flip(int i, int k) {
    const std::optional<int> j = across(i, k);
    if (!j) return false;
    const Triangle s = seam_.triangles[i], t = seam_.triangles[*j];
    const int a = s[k], b = s[(k + 1) % 3], c = s[(k + 2) % 3], d = t[(corner(t, a) + 1) % 3];
    if (c == d) return false;
    const Triangle first{a, d, c}, second{d, b, c};
    const double before = std::min(quality(s), quality(t));
    const double after = std::min(quality(first), quality(second));
    if (!(after > before + 1e-3) || !flat(s, t) || bends(first) || bends(second)) return false;
    if (std::ranges::binary_search(neighbours(c), d)) return false;
    if (neighbours(a).size() < 4 || neighbours(b).size() < 4) return false;
    seam_.triangles[i] = first;
    seam_.triangles[*j] = second;
    seam_.from[i] = seam_.from[*j] = -1;
    std::erase(around_[b], i);
    std::erase(around_[a], *j);
    around_[d].push_back(i);
    around_[c].push_back(*j);
    return true;
  }

  /// Whether two triangles lie in a plane, or one is so thin that it has none.
  bool flat(const Triangle& s, const Triangle& t) const {
    const Vector3 n = (at(s[1]) - at(s[0])).cross(at(s[2]) - at(s[0]));
    const Vector3 m = (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0]));
    return n.dot(m) > flattest * n.norm() * m.norm() || std::abs(quality(s)) < thinnest ||
           std::abs(quality(t)) < thinnest;
  }

  void compact() {
    std::size_t out = 0;
    for (std::size_t i = 0; i < seam_.triangles.size(); ++i) {
      if (seam_.triangles[i][0] < 0) continue;
      seam_.triangles[out] = seam_.triangles[i];
      seam_.from[out++] = seam_.from[i];
    }
    seam_.triangles.resize(out);
    seam_.from.resize(out);
  }

  const SurfacePair& pair_;
  const Mesh& target_;
  const ClosestPointFinder& finder_;  // on the target
  Seam& seam_;
  std::vector<int> ring_;                 // per vertex its distance to a strip, −1: beyond two
  std::vector<char> free_;                // per triangle
  std::vector<std::vector<int>> around_;  // per vertex of free triangles all triangles
  std::vector<int> movable_;
};

}  // namespace

double triangle_quality(const Vector3& p, const Vector3& q, const Vector3& r,
                        const Vector3& normal) {
  const Vector3 n = (q - p).cross(r - p);
  const double sum = (q - p).squaredNorm() + (r - q).squaredNorm() + (p - r).squaredNorm();
  const double value = sum > 0 ? 2 * std::sqrt(3.0) * n.norm() / sum : 0;
  return n.dot(normal) < 0 ? -value : value;
}

void improve_seam(const SurfacePair& pair, const Mesh& target, const ClosestPointFinder& finder,
                  Seam& seam) {
  if (std::ranges::none_of(seam.from, [](int t) { return t < 0; })) return;
  SeamMesh(pair, target, finder, seam).run();
}

}  // namespace mq

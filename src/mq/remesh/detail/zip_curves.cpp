// A state (i, k) is an edge from vertex a_i of the template's curve to vertex c_k of the target's,
// walked backwards, since what is kept of the target lies on the other side. Going on along the
// template closes the triangle (a_{i+1}, a_i, c_k), along the target (c_k, c_{k+1}, a_i). The strip
// is the cheapest path from (0, 0) to (n, m).

#include "mq/remesh/detail/zip_curves.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/remesh/detail/flaws.h"

namespace mq {
namespace {

constexpr double least_corner_cosine = -0.17;  // 100 degrees
constexpr double most_states = 4e6;

/// A triangle's share of the cost; bad ones add so much that one fewer is always cheaper.
struct TriangleCost {
  double cost = 0;
  bool bad = false;
};

TriangleCost triangle_cost(const SurfacePair& pair, const Triangle& t, double across) {
  const Vector3 &p = pair.mesh.positions[t[0]], &q = pair.mesh.positions[t[1]],
                &r = pair.mesh.positions[t[2]];
  const Vector3 normal = (q - p).cross(r - p);
  const double area = normal.norm();
  const double longest =
      std::max({(p - q).squaredNorm(), (q - r).squaredNorm(), (r - p).squaredNorm()});
  const Vector3 wanted = pair.normals[t[0]] + pair.normals[t[1]] + pair.normals[t[2]];
  const double scale = area * wanted.norm();
  const double cosine = scale > 0 ? normal.dot(wanted) / scale : -1;
  double least = 1;
  for (const int v : t)
    least = std::min(least, normal.dot(pair.normals[v]) / std::max(area, 1e-300));
  return {across * (1 + 4 * (1 - cosine)),
          !(area > thinnest * longest) || cosine < least_cosine || least < least_corner_cosine};
}

class Zipper {
 public:
  Zipper(const SurfacePair& pair, std::vector<int> a, std::vector<int> c)
      : pair_(pair), a_(std::move(a)), c_(std::move(c)) {
    const double states = double(a_.size()) * double(c_.size());
    width_ = states <= most_states ? 2.0 : std::max(0.02, most_states / states);
    along_a_ = arc_length(a_), along_c_ = arc_length(c_);
  }

  Strip run() {
    const int n = int(a_.size()) - 1, m = int(c_.size()) - 1;
    std::vector<double> best((std::size_t(n) + 1) * (std::size_t(m) + 1), infinite);
    std::vector<char> from(best.size(), 0);
    const auto at = [&](int i, int k) {
      return std::size_t(i) * (std::size_t(m) + 1) + std::size_t(k);
    };
    best[0] = 0;
    for (int i = 0; i <= n; ++i)
      for (int k = 0; k <= m; ++k) {
        if (i + k == 0 || std::abs(along_a_[i] - along_c_[k]) > width_) continue;
        const double across =
            (pair_.mesh.positions[a_[i]] - pair_.mesh.positions[c_[k]]).squaredNorm();
        const auto consider = [&](double before, const Triangle& t, char how) {
          if (before == infinite) return;
          const TriangleCost share = triangle_cost(pair_, t, across);
          const double cost = before + share.cost + (share.bad ? penalty() : 0);
          if (cost < best[at(i, k)]) best[at(i, k)] = cost, from[at(i, k)] = how;
        };
        if (i > 0) consider(best[at(i - 1, k)], {a_[i], a_[i - 1], c_[k]}, 1);
        if (k > 0) consider(best[at(i, k - 1)], {c_[k - 1], c_[k], a_[i]}, 2);
      }
    Strip strip;
    int bad = 0;
    for (int i = n, k = m; i + k > 0;) {
      const char how = from[at(i, k)];
      const Triangle t =
          how == 1 ? Triangle{a_[i], a_[i - 1], c_[k]} : Triangle{c_[k - 1], c_[k], a_[i]};
      bad += triangle_cost(pair_, t, 0).bad;
      strip.triangles.push_back(t);
      (how == 1 ? i : k) -= 1;
    }
    std::ranges::reverse(strip.triangles);
    strip.cost = best.back() - bad * penalty();
    return strip;
  }

 private:
  static constexpr double infinite = std::numeric_limits<double>::infinity();

  /// More than any strip without bad triangles costs.
  double penalty() const {
    if (penalty_ > 0) return penalty_;
    double largest = 0;
    for (const int a : a_)
      largest =
          std::max(largest, (pair_.mesh.positions[a] - pair_.mesh.positions[c_[0]]).squaredNorm());
    for (const int c : c_)
      largest =
          std::max(largest, (pair_.mesh.positions[c] - pair_.mesh.positions[a_[0]]).squaredNorm());
    penalty_ = 36 * largest * double(a_.size() + c_.size());
    return penalty_;
  }

  /// From 0 to 1.
  std::vector<double> arc_length(const std::vector<int>& curve) const {
    std::vector<double> length(curve.size(), 0);
    for (std::size_t i = 1; i < curve.size(); ++i)
      length[i] = length[i - 1] +
                  (pair_.mesh.positions[curve[i]] - pair_.mesh.positions[curve[i - 1]]).norm();
    for (double& l : length) l /= std::max(length.back(), 1e-300);
    return length;
  }

  const SurfacePair& pair_;
  std::vector<int> a_, c_;
  std::vector<double> along_a_, along_c_;
  double width_ = 2;
  mutable double penalty_ = 0;
};

/// Where two closed curves are nearest to each other, normals agreeing where they do anywhere.
std::array<std::size_t, 2> nearest(const SurfacePair& pair, const std::vector<int>& a,
                                   const std::vector<int>& c) {
  std::array<std::size_t, 2> best{0, 0};
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t k = 0; k < c.size(); ++k) {
      const double d = (pair.mesh.positions[a[i]] - pair.mesh.positions[c[k]]).squaredNorm() *
                       (1.1 - pair.normals[a[i]].dot(pair.normals[c[k]]));
      if (d < least) least = d, best = {i, k};
    }
  return best;
}

/// Per vertex of a curve the curve of the other surface that it lies nearest to, −1: none near.
class CurveVotes {
 public:
  CurveVotes(const SurfacePair& pair, const std::vector<CutCurve>& curves, double reach)
      : pair_(pair), reach_(reach) {
    for (std::size_t i = 0; i < curves.size(); ++i)
      for (const int v : curves[i].vertices) cells_[cell(v)].push_back({v, int(i)});
  }

  int vote(int v) const {
    const Key middle = cell(v);
    double least = reach_ * reach_;
    int best = -1;
    for (long x = -1; x <= 1; ++x)
      for (long y = -1; y <= 1; ++y)
        for (long z = -1; z <= 1; ++z) {
          const auto found = cells_.find({middle[0] + x, middle[1] + y, middle[2] + z});
          if (found == cells_.end()) continue;
          for (const auto& [w, curve] : found->second) {
            if (pair_.of_target[w] == pair_.of_target[v]) continue;
            if (pair_.normals[w].dot(pair_.normals[v]) <= 0) continue;
            const double d = (pair_.mesh.positions[w] - pair_.mesh.positions[v]).squaredNorm();
            if (d < least || (d == least && curve < best)) least = d, best = curve;
          }
        }
    return best;
  }

 private:
  using Key = std::array<long, 3>;
  Key cell(int v) const {
    const Vector3 p =
        ((pair_.mesh.positions[v] - pair_.mesh.positions[0]) / reach_).array().floor();
    const auto whole = [](double x) { return long(std::clamp(x, -1e15, 1e15)); };
    return {whole(p.x()), whole(p.y()), whole(p.z())};
  }
  struct Entry {
    int vertex, curve;
  };
  const SurfacePair& pair_;
  double reach_;
  std::map<Key, std::vector<Entry>> cells_;
};

}  // namespace

CurvePairs pair_curves(const SurfacePair& pair, const std::vector<CutCurve>& curves, double reach) {
  const CurveVotes votes(pair, curves, reach);
  std::vector<int> partner(curves.size(), -1);
  parallel_for(
      std::ssize(curves),
      [&](std::int64_t i) {
        std::map<int, int> counts;
        for (const int v : curves[i].vertices) ++counts[votes.vote(v)];
        for (const auto& [curve, count] : counts)
          if (curve >= 0 && 10 * count > 6 * std::ssize(curves[i].vertices)) partner[i] = curve;
      },
      1);
  CurvePairs found;
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const int j = partner[i];
    const bool mutual = j >= 0 && partner[j] == int(i) && curves[i].kind == curves[j].kind;
    const bool long_enough =
        mutual && (curves[i].kind == CutCurve::Kind::open ||
                   std::min(curves[i].edge_count(), curves[j].edge_count()) >= 3);
    if (!long_enough)
      found.alone.push_back(int(i));
    else if (!pair.of_target[curves[i].vertices[0]])
      found.pairs.push_back({int(i), j});
  }
  return found;
}

bool is_bad(const SurfacePair& pair, const Triangle& triangle) {
  return triangle_cost(pair, triangle, 0).bad;
}

Strip zip(const SurfacePair& pair, const CutCurve& of_template, const CutCurve& of_target) {
  std::vector<int> a = of_template.vertices;
  std::vector<int> c(of_target.vertices.rbegin(), of_target.vertices.rend());
  if (of_template.kind == CutCurve::Kind::closed) {
    require(a.size() >= 3 && c.size() >= 3, "a closed curve to zip needs three edges or more");
    const auto [i, k] = nearest(pair, a, c);
    std::ranges::rotate(a, a.begin() + std::ptrdiff_t(i));
    std::ranges::rotate(c, c.begin() + std::ptrdiff_t(k));
    a.push_back(a.front());
    c.push_back(c.front());
  }
  return Zipper(pair, std::move(a), std::move(c)).run();
}

}  // namespace mq

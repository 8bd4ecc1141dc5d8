/// In rounds. First, for all vertices in parallel, the best neighbour to go to; then, one after
/// another from the densest place on, those whose neighbours have not gone in this round do. Their
/// triangles are then still those that were judged; only whether the topology stays (the link
/// condition of Dey, Edelsbrunner, Guha and Nekhayev, Topology preserving edge contraction, 1999)
/// must be asked again.
///
/// All of that is decided for the surface in a cube of side 1, at places rounded to 2⁻³²: in any
/// unit the same vertices go, also of regular surfaces, where many would leave equally good
/// triangles.

#include "mq/mesh/coarsen.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "mq/base/error.h"
#include "mq/base/parallel.h"

namespace mq {

namespace {

constexpr int most_neighbours = 10;     // of a vertex that goes, and of one that others go to
constexpr double least_quality = 0.25;  // 4√3·area / Σ length²; 1: equilateral
constexpr double sliver_kept = 0.5;     // of the quality of triangles that are below that before
constexpr double least_turn = 0.3;      // cosine between a new triangle and the old ones' mean
constexpr double least_straight = 0.8;  // cosine of the bend of a boundary where it loses a vertex
constexpr int most_rounds = 24;
constexpr double grid = 4294967296;  // steps along the longest side of the box

/// The triangles and neighbours around a vertex, counter-clockwise.
struct Ring {
  static constexpr int most = 32;
  std::array<HalfEdge, most>
      spokes;  ///< half-edges from the vertex to its neighbours, one a triangle
  int triangles = 0;
  bool closed = false;
  bool whole = false;  ///< false: too large, or none
};

struct Collapse {
  HalfEdge along = -1;  ///< in a triangle that goes; it begins or ends at the vertex
  double quality = 0;
};

struct Candidate {
  float size;  ///< share of the area
  int vertex;
  Collapse collapse;

  bool operator<(const Candidate& other) const {
    return size != other.size ? size < other.size : vertex < other.vertex;
  }
};

/// Positions in a cube of side 1, on the grid.
struct InCube {
  std::vector<Vector3> positions;
  double side = 1;  ///< model units

  explicit InCube(const std::vector<Vector3>& from) : positions(from.size()) {
    Eigen::AlignedBox3d box;
    for (const Vector3& p : from) box.extend(p);
    if (!from.empty()) side = box.sizes().maxCoeff();
    if (!(side > 0)) side = 1;
    parallel_for(std::ssize(from), [&](std::int64_t v) {
      positions[v] = ((from[v] - box.min()) / side * grid).array().round() / grid;
    });
  }
};

class Collapser {
 public:
  Collapser(const Surface& surface, const std::vector<Vector3>& positions)
      : positions_(positions),
        triangles_(surface.mesh.triangles),
        twins_(surface.twins),
        out_(positions_.size(), -1),
        moved_to_(positions_.size(), -1),
        dead_(triangles_.size(), 0) {
    for (int t = 0; t < int(triangles_.size()); ++t) {
      const Triangle& v = triangles_[t];
      if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) {
        dead_[t] = 1;
        continue;
      }
      for (int k = 0; k < 3; ++k) out_[v[k]] = 3 * t + k;
    }
    for (int v = 0; v < int(positions_.size()); ++v)
      if (out_[v] >= 0) alive_.push_back(v);
  }

  /// Returns how many vertices went.
  int round(double wanted_area) {
    std::vector<Candidate> all(alive_.size());
    parallel_for(std::ssize(alive_),
                 [&](std::int64_t i) { all[i] = judged(alive_[i], wanted_area); });
    std::erase_if(all, [](const Candidate& c) { return c.collapse.along < 0; });
    tbb::parallel_sort(all.begin(), all.end());
    std::vector<char> held(positions_.size(), 0);
    int gone = 0;
    for (const Candidate& c : all) {
      if (held[c.vertex]) continue;
      const Ring ring = ring_of(c.vertex);
      if (!may_go(c.vertex, c.collapse.along, ring)) continue;
      for (int k = 0; k < ring.triangles; ++k) {
        held[target(ring.spokes[k])] = 1;
        held[target(next(ring.spokes[k]))] = 1;
      }
      collapse(c.vertex, c.collapse.along, ring);
      ++gone;
    }
    std::erase_if(alive_, [&](int v) { return moved_to_[v] >= 0; });
    return gone;
  }

  int alive() const { return int(alive_.size()); }
  int dead(int t) const { return dead_[t]; }
  const std::vector<Triangle>& triangles() const { return triangles_; }

  /// The vertex that v has become.
  int survivor(int v) const {
    while (moved_to_[v] >= 0) v = moved_to_[v];
    return v;
  }

 private:
  int source(HalfEdge h) const { return triangles_[h / 3][h % 3]; }
  int target(HalfEdge h) const { return source(next(h)); }
  const Vector3& at(int v) const { return positions_[v]; }

  Ring ring_of(int v) const {
    Ring ring;
    HalfEdge first = out_[v];
    if (first < 0) return ring;
    for (int steps = 0; twins_[first] >= 0; ++steps) {  // clockwise to the boundary, or around
      first = next(twins_[first]);
      if (first == out_[v]) break;
      if (steps > Ring::most) return ring;
    }
    HalfEdge h = first;
    while (true) {
      if (ring.triangles == Ring::most) return ring;
      ring.spokes[ring.triangles++] = h;
      h = twins_[previous(h)];
      if (h == first) ring.closed = true;
      if (h < 0 || h == first) break;
    }
    ring.whole = true;
    return ring;
  }

  static int neighbours(const Ring& ring) { return ring.triangles + (ring.closed ? 0 : 1); }

  Vector3 normal(const Vector3& p, const Vector3& q, const Vector3& r) const {
    return (q - p).cross(r - p);
  }

  double quality(int a, int b, int c, double twice_area) const {
    const double lengths = (at(b) - at(a)).squaredNorm() + (at(c) - at(b)).squaredNorm() +
                           (at(a) - at(c)).squaredNorm();
    return lengths > 0 ? 2 * std::numbers::sqrt3 * twice_area / lengths : 0;
  }

  /// The worst triangle that is left when v goes to u; −1 where one flips or is no better than
  /// `least`.
  double quality_after(const Ring& ring, int u, const Vector3& mean, double least) const {
    double worst = 1;
    for (int k = 0; k < ring.triangles; ++k) {
      const int a = target(ring.spokes[k]), b = target(next(ring.spokes[k]));
      if (a == u || b == u) continue;
      const Vector3 n = normal(at(u), at(a), at(b));
      const double twice_area = n.norm();
      if (!(n.dot(mean) > least_turn * twice_area)) return -1;
      worst = std::min(worst, quality(u, a, b, twice_area));
      if (!(worst > least)) return -1;
    }
    return worst;
  }

  Candidate judged(int v, double wanted_area) const {
    Candidate candidate{0, v, {}};
    const Ring ring = ring_of(v);
    if (!ring.whole || ring.triangles < 1 || neighbours(ring) > most_neighbours) return candidate;
    Vector3 mean = Vector3::Zero();
    double area = 0, least = least_quality;
    for (int k = 0; k < ring.triangles; ++k) {
      const int a = target(ring.spokes[k]), b = target(next(ring.spokes[k]));
      const Vector3 n = normal(at(v), at(a), at(b));
      mean += n;
      area += n.norm() / 6;
      const double before = quality(v, a, b, n.norm());
      if (before < least_quality) least = std::min(least, sliver_kept * before);
    }
    if (!ring.closed) area *= 2;  // as if the surface went on
    candidate.size = float(area);
    if (!(area < wanted_area) || !(mean.norm() > 0)) return candidate;
    mean.normalize();
    candidate.collapse = best_collapse(v, ring, mean, least, [](HalfEdge) { return true; });
    if (candidate.collapse.along >= 0 && !may_go(v, candidate.collapse.along, ring))
      candidate.collapse =
          best_collapse(v, ring, mean, least, [&](HalfEdge h) { return may_go(v, h, ring); });
    return candidate;
  }

  /// The one that leaves the best triangles, of those that are allowed; none below `least`.
  template <class Allowed>
  Collapse best_collapse(int v, const Ring& ring, const Vector3& mean, double least,
                         const Allowed& allowed) const {
    Collapse best{-1, least};
    const auto offer = [&](HalfEdge h, int u) {
      const double quality = quality_after(ring, u, mean, best.quality);
      if (quality > best.quality && allowed(h)) best = {h, quality};
    };
    if (ring.closed) {
      for (int k = 0; k < ring.triangles; ++k) offer(ring.spokes[k], target(ring.spokes[k]));
      return best;
    }
    const HalfEdge first = ring.spokes[0], last = previous(ring.spokes[ring.triangles - 1]);
    const int a = target(first), b = source(last);
    const Vector3 ahead = at(a) - at(v), behind = at(v) - at(b);
    if (ahead.dot(behind) > least_straight * ahead.norm() * behind.norm()) {
      offer(first, a);
      offer(last, b);
    }
    return best;
  }

  /// Whether the surface stays what it is when v goes along h: both ends have no common neighbours
  /// but those across, which have others left.
  bool may_go(int v, HalfEdge h, const Ring& ring) const {
    const int u = source(h) == v ? target(h) : source(h);
    const Ring other = ring_of(u);
    if (!ring.whole || !other.whole) return false;
    const bool inner = twins_[h] >= 0;
    if (neighbours(ring) + neighbours(other) - (inner ? 4 : 3) > most_neighbours) return false;
    int common = 0;
    const auto count = [&](int a) {
      for (int j = 0; j < other.triangles; ++j) common += target(other.spokes[j]) == a;
      if (!other.closed) common += source(previous(other.spokes[other.triangles - 1])) == a;
    };
    for (int k = 0; k < ring.triangles; ++k) count(target(ring.spokes[k]));
    if (!ring.closed) count(source(previous(ring.spokes[ring.triangles - 1])));
    if (common != (inner ? 2 : 1)) return false;
    const auto stays = [&](HalfEdge side) {  // the corner across
      const Ring across = ring_of(target(next(side)));
      return across.whole && neighbours(across) > (across.closed ? 3 : 2);
    };
    return stays(h) && (!inner || stays(twins_[h]));
  }

  /// Takes the triangle of h out and joins what lies beside it.
  void remove_triangle(HalfEdge h) {
    const HalfEdge a = twins_[next(h)], b = twins_[previous(h)];
    if (a >= 0) twins_[a] = b;
    if (b >= 0) twins_[b] = a;
    dead_[h / 3] = 1;
  }

  void collapse(int v, HalfEdge h, const Ring& ring) {
    const int u = source(h) == v ? target(h) : source(h);
    const HalfEdge twin = twins_[h];
    std::array<int, 4> touched{u, target(next(h)), -1, -1};
    if (twin >= 0) touched[2] = target(next(twin));
    // A half-edge out of each of these that stays.
    std::array<HalfEdge, 4> fresh{-1, -1, -1, -1};
    for (int i = 0; i < 3; ++i) {
      if (touched[i] < 0) continue;
      const Ring around = ring_of(touched[i]);
      for (int k = 0; k < around.triangles && fresh[i] < 0; ++k) {
        const int t = around.spokes[k] / 3;
        if (t != h / 3 && (twin < 0 || t != twin / 3)) fresh[i] = around.spokes[k];
      }
    }
    for (int k = 0; k < ring.triangles; ++k) triangles_[ring.spokes[k] / 3][ring.spokes[k] % 3] = u;
    if (fresh[0] < 0)  // all of u's triangles go: those of v are its own now
      for (int k = 0; k < ring.triangles; ++k) {
        const int t = ring.spokes[k] / 3;
        if (t != h / 3 && (twin < 0 || t != twin / 3)) fresh[0] = ring.spokes[k];
      }
    remove_triangle(h);
    if (twin >= 0) remove_triangle(twin);
    for (int i = 0; i < 3; ++i)
      if (touched[i] >= 0) out_[touched[i]] = fresh[i];
    moved_to_[v] = u;
    out_[v] = -1;
  }

  const std::vector<Vector3>& positions_;
  std::vector<Triangle> triangles_;
  std::vector<HalfEdge> twins_;
  std::vector<HalfEdge> out_;  ///< per vertex one half-edge from it; −1: gone, or never used
  std::vector<int> moved_to_;  ///< per vertex where it went, −1: it stays
  std::vector<char> dead_;
  std::vector<int> alive_;
};

/// Corners 3·triangle + k at each vertex.
struct Corners {
  std::vector<int> starts, corners;

  explicit Corners(const Mesh& mesh) : starts(mesh.vertex_count() + 1, 0) {
    for (const Triangle& t : mesh.triangles)
      for (const int v : t) ++starts[v + 1];
    for (int v = 0; v < mesh.vertex_count(); ++v) starts[v + 1] += starts[v];
    corners.resize(starts.back());
    std::vector<int> at(starts.begin(), starts.end() - 1);
    for (int t = 0; t < mesh.triangle_count(); ++t)
      for (int k = 0; k < 3; ++k) corners[at[mesh.triangles[t][k]]++] = 3 * t + k;
  }
};

ClosestPoint at_corner(int corner) {
  ClosestPoint place{{corner / 3, Vector3::Zero()}, 0};
  place.barycentric[corner % 3] = 1;
  return place;
}

/// The nearest point of the triangles around a vertex, and around the corners of the nearest of
/// them.
ClosestPoint nearest_around(const Mesh& mesh, const Corners& around, int vertex, const Vector3& p) {
  ClosestPoint best = at_corner(around.corners[around.starts[vertex]]);
  best.squared_distance = (p - mesh.positions[vertex]).squaredNorm();
  const auto try_around = [&](int v) {
    for (int c = around.starts[v]; c < around.starts[v + 1]; ++c) {
      const ClosestPoint found = closest_point(mesh, around.corners[c] / 3, p);
      if (found.squared_distance < best.squared_distance) best = found;
    }
  };
  try_around(vertex);
  const int nearest = best.triangle;
  for (const int v : mesh.triangles[nearest])
    if (v != vertex) try_around(v);
  return best;
}

}  // namespace

CoarsenedSurface coarsen(const Surface& surface, double spacing, const Progress& progress) {
  require(spacing > 0 && std::isfinite(spacing),
          fmt::format("vertices cannot be {} apart; a positive length was wanted", spacing));
  const InCube cube(surface.mesh.positions);
  const double wanted = spacing / cube.side;
  const double wanted_area = std::sqrt(3.0) / 2 * wanted * wanted * 0.75;
  Collapser collapser(surface, cube.positions);
  for (int round = 0; round < most_rounds; ++round) {
    const int before = collapser.alive();
    progress.at(0.6 * round / most_rounds);
    if (collapser.round(wanted_area) < 0.01 * before) break;
  }

  Mesh mesh;
  std::vector<int> number(surface.mesh.positions.size(), -1), fine;
  for (int t = 0; t < surface.triangle_count(); ++t) {
    if (collapser.dead(t)) continue;
    Triangle corners = collapser.triangles()[t];
    for (int& v : corners) {
      if (number[v] < 0) {
        number[v] = int(fine.size());
        fine.push_back(v);
      }
    }
    mesh.triangles.push_back(corners);
  }
  std::sort(fine.begin(), fine.end());
  for (int c = 0; c < int(fine.size()); ++c) number[fine[c]] = c;
  for (Triangle& t : mesh.triangles)
    for (int& v : t) v = number[v];
  for (const int v : fine) mesh.positions.push_back(surface.mesh.positions[v]);

  CoarsenedSurface result;
  result.surface =
      make_surface(mesh, {WeldOptions::Kind::none}, progress.step("coarse surface", 0.2));
  for (const int v : result.surface.source_from_vertex) result.source.push_back(fine[v]);
  std::vector<int> coarse(surface.mesh.positions.size(), -1);
  for (int c = 0; c < int(result.source.size()); ++c) coarse[result.source[c]] = c;
  Mesh in_cube;
  in_cube.triangles = result.surface.mesh.triangles;
  for (const int v : result.source) in_cube.positions.push_back(cube.positions[v]);
  const Corners around(in_cube);
  result.places.resize(surface.mesh.positions.size());
  parallel_for(std::ssize(result.places), [&](std::int64_t v) {
    const int c = coarse[collapser.survivor(int(v))];
    if (c < 0) return;
    ClosestPoint& place = result.places[v];
    if (result.source[c] == v) {
      place = at_corner(around.corners[around.starts[c]]);
      return;
    }
    place = nearest_around(in_cube, around, c, cube.positions[v]);
    place.squared_distance *= cube.side * cube.side;
  });
  progress.at(1);
  return result;
}

}  // namespace mq

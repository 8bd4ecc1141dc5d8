// Both surfaces cut where the region ends, strips between the curves that go together, and where
// that does not work.

#include "mq/remesh/detail/remesher.h"

#include <algorithm>
#include <cmath>

#include "mq/base/parallel.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/weld.h"
#include "mq/remesh/detail/clip_crossings.h"

namespace mq {
namespace {

constexpr double longest_in_radii = 2.5;    // edges that are left where the region ends
constexpr double gap_in_radii = 0.125;      // between where the template and the target end
constexpr std::int64_t most_cut = 2;        // times as many triangles as before
constexpr std::int64_t least_cut = 20'000;  // that may always be

}  // namespace

/// Whether an edge between the surfaces is longer than they may be apart.
bool Remesher::reaches_too_far(const Triangle& t) const {
  for (int k = 0; k < 3; ++k) {
    const int a = t[std::size_t(k)], b = t[std::size_t((k + 1) % 3)];
    if (pair_.of_target[a] != pair_.of_target[b] &&
        (pair_.mesh.positions[a] - pair_.mesh.positions[b]).norm() > reach_)
      return true;
  }
  return false;
}

/// Whether one of the surfaces passes through itself, within reach of the triangle: what joins the
/// two there does so too, however far the region grows.
bool Remesher::crosses_itself_near(const Triangle& t) {
  if (!self_crossings_) {
    Mesh& all = self_crossings_.emplace();
    for (const Surface* surface : {&template_, &target_}) {
      const Mesh& mesh = surface->mesh;
      const std::vector<char> crossing = crossed(mesh.positions, mesh.triangles, {});
      for (int i = 0; i < mesh.triangle_count(); ++i) {
        if (!crossing[i]) continue;
        const int first = all.vertex_count();
        all.triangles.push_back({first, first + 1, first + 2});
        for (int k = 0; k < 3; ++k) all.positions.push_back(mesh.position(i, k));
      }
    }
    if (!all.triangles.empty()) near_self_crossings_.emplace(all);
  }
  if (!near_self_crossings_) return false;
  const auto& p = pair_.mesh.positions;
  const std::array<Vector3, 1> center{(p[t[0]] + p[t[1]] + p[t[2]]) / 3};
  return (*near_self_crossings_)(center)[0].squared_distance < reach_ * reach_;
}

/// Strips that pass through one another or through what is kept, and triangles of the target that
/// pass through the template's where both end, unless one of the two passes through itself there.
void Remesher::refuse_crossings(Cut& cut) {
  std::vector<Triangle> kept, of_target, of_template;
  for (int t = 0; t < pair_.mesh.triangle_count(); ++t) {
    if (!cut.kept[t]) continue;
    const Triangle& triangle = pair_.mesh.triangles[t];
    kept.push_back(triangle);
    double least = 2 * region_->radius(), most = 0;
    for (const int v : triangle) {
      least = std::min(least, region_->distances()[v]);
      most = std::max(most, region_->distances()[v]);
    }
    if (pair_.triangle_of_target(t) && most > 0.25 * region_->radius())
      of_target.push_back(triangle);
    if (!pair_.triangle_of_target(t) && least < 2 * region_->radius())
      of_template.push_back(triangle);
  }
  const auto refuse = [&](const std::vector<Triangle>& asked, const std::vector<char>& bad) {
    for (std::size_t i = 0; i < bad.size(); ++i)
      if (bad[i] && !crosses_itself_near(asked[i]))
        cut.failed.insert(cut.failed.end(), asked[i].begin(), asked[i].end());
  };
  refuse(cut.strips, crossed(pair_.mesh.positions, cut.strips, kept));
  refuse(of_target, crossed_by(pair_.mesh.positions, of_target, of_template));
}

/// The region may reach parts of either surface that only lie near by, such as the other side of a
/// thin one. Where nothing is marked in them, nor in what their curves go together with, the
/// template's stay and the target's do not come. Whether there were any.
bool Remesher::leave_what_is_passed(Cut& cut, const std::vector<CutCurve>& curves,
                                    const CurvePairs& found) const {
  const int count = pair_.mesh.triangle_count();
  const auto changes = [&](int t) {
    return !replaced_[group(t)] && (cut.kept[t] != 0) == pair_.triangle_of_target(t);
  };
  DisjointSets parts(std::size_t(count) + curves.size());
  std::vector<int> curve_of(pair_.mesh.positions.size(), -1);
  for (std::size_t i = 0; i < curves.size(); ++i)
    for (const int v : curves[i].vertices) curve_of[v] = int(i);
  for (const auto& [i, j] : found.pairs) parts.join(count + i, count + j);
  for (HalfEdge h = 0; h < std::ssize(pair_.twins); ++h) {
    if (!changes(h / 3)) continue;
    const HalfEdge across = pair_.twins[h];
    if (across >= 0 && changes(across / 3)) parts.join(h / 3, across / 3);
    if (across < 0 || changes(across / 3)) continue;
    for (const int k : {h % 3, (h + 1) % 3})
      if (const int curve = curve_of[pair_.mesh.triangles[h / 3][k]]; curve >= 0)
        parts.join(h / 3, count + curve);
  }
  std::vector<char> marked(std::size_t(count) + curves.size(), 0);
  for (int t = 0; t < count; ++t)
    if (changes(t))
      for (const int v : pair_.mesh.triangles[t])
        if (v < std::ssize(marked_) && marked_[v] != Mark::none) marked[parts.root(t)] = 1;
  std::vector<int> left;
  for (int t = 0; t < count; ++t)
    if (changes(t) && !marked[parts.root(t)]) left.push_back(t);
  for (const int t : left) cut.kept[t] = !cut.kept[t];
  return !left.empty();
}

/// Cuts and stitches with the region as it is; nothing where nothing of the template would stay, or
/// the triangles are so much larger than the region that cutting them makes far too many.
std::optional<Remesher::Cut> Remesher::attempt() {
  const double radius = region_->radius();
  const std::int64_t count = template_.triangle_count() + target_.triangle_count();
  const auto ends_in = [&](const SurfacePair& pair, int t) {
    const auto inside = [&](int v) {
      return v < std::ssize(marked_) && marked_[std::size_t(v)] != Mark::none;
    };
    if (replaced_[group(t)] || std::ranges::all_of(pair.mesh.triangles[t], inside)) return false;
    const Vector3 center =
        (pair.mesh.position(t, 0) + pair.mesh.position(t, 1) + pair.mesh.position(t, 2)) / 3;
    double around = 0;
    for (int k = 0; k < 3; ++k)
      around = std::max(around, (pair.mesh.position(t, k) - center).norm());
    const double distance = (*region_)(center);
    return distance < radius + around && distance > radius - around;
  };
  Cut cut;
  if (!cut_long_triangles(pair_, longest_in_radii * radius, std::max(most_cut * count, least_cut),
                          ends_in))
    return std::nullopt;
  region_->follow(pair_);
  cut.kept.resize(pair_.mesh.triangles.size());
  for (int t = 0; t < pair_.mesh.triangle_count(); ++t) {
    const bool of_target = pair_.triangle_of_target(t);
    bool kept = true;
    for (const int v : pair_.mesh.triangles[t]) {
      const double d = region_->distances()[v];
      kept &= of_target ? d < radius * (1 - gap_in_radii) : d > radius;
    }
    cut.kept[t] = replaced_[group(t)] ? of_target : kept;
  }
  clean_cut(pair_, cut.kept);
  std::vector<CutCurve> curves = cut_curves(pair_, cut.kept);
  CurvePairs found = pair_curves(pair_, curves, reach_);
  if (leave_what_is_passed(cut, curves, found)) {
    curves = cut_curves(pair_, cut.kept);
    found = pair_curves(pair_, curves, reach_);
  }
  for (const int i : found.alone)
    cut.failed.insert(cut.failed.end(), curves[i].vertices.begin(), curves[i].vertices.end());
  std::vector<Strip> strips(found.pairs.size());
  parallel_for(
      std::ssize(strips),
      [&](std::int64_t i) {
        strips[i] = zip(pair_, curves[found.pairs[i][0]], curves[found.pairs[i][1]]);
      },
      1);
  for (const Strip& strip : strips) {
    for (const Triangle& t : strip.triangles)
      if (is_bad(pair_, t) || reaches_too_far(t))
        cut.failed.insert(cut.failed.end(), t.begin(), t.end());
    cut.strips.insert(cut.strips.end(), strip.triangles.begin(), strip.triangles.end());
  }
  if (cut.failed.empty()) refuse_crossings(cut);
  return cut;
}

/// Vertices of the target that the result would show worse than the template did.
std::vector<int> Remesher::uncovered(const Cut& cut) const {
  Mesh mesh;
  mesh.positions = pair_.mesh.positions;
  std::vector<char> there(mesh.positions.size(), 0);
  for (int t = 0; t < pair_.mesh.triangle_count(); ++t)
    if (cut.kept[t]) {
      mesh.triangles.push_back(pair_.mesh.triangles[t]);
      for (const int v : mesh.triangles.back()) there[v] = 1;
    }
  mesh.triangles.insert(mesh.triangles.end(), cut.strips.begin(), cut.strips.end());
  std::vector<int> asked, found;
  std::vector<Vector3> points;
  for (int v = 0; v < std::ssize(pair_.of_target); ++v)
    if (pair_.of_target[v] && !there[v] && pair_.source_vertex[v] >= 0) {
      asked.push_back(v);
      points.push_back(mesh.positions[v]);
    }
  if (mesh.triangles.empty()) return asked;
  const std::vector<ClosestPoint> now = ClosestPointFinder(mesh)(points);
  for (std::size_t i = 0; i < asked.size(); ++i) {
    const double before = on_template_[pair_.source_vertex[asked[i]]].squared_distance;
    if (std::sqrt(now[i].squared_distance) > std::sqrt(before) + result_.tolerance)
      found.push_back(asked[i]);
  }
  return found;
}

}  // namespace mq

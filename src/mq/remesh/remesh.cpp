// What the thesis cuts along the sides of voxels is here cut along the level of a distance, and
// what it merges vertex by vertex is here joined by strips: whole triangles on both sides of a gap
// about one edge wide. Nothing has to be intersected, the template's triangles next to the seam
// stay as they are, and a strip between two closed curves is an annulus whatever their shapes, so
// that the result is manifold by construction.

#include "mq/remesh/remesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/base/stopwatch.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/soundness.h"
#include "mq/mesh/unfold.h"
#include "mq/mesh/weld.h"
#include "mq/remesh/detail/clip_crossings.h"
#include "mq/remesh/detail/measure.h"
#include "mq/remesh/detail/region.h"
#include "mq/remesh/detail/retriangulate.h"
#include "mq/remesh/detail/score.h"
#include "mq/remesh/detail/seam.h"
#include "mq/remesh/detail/zip_curves.h"

namespace mq {
namespace {

constexpr int most_rounds = 60;
constexpr double longest_in_radii = 2.5;        // edges that are left where the region ends
constexpr double gap_in_radii = 0.125;          // between where the template and the target end
constexpr double grown_farther = 0.5;           // in radii: what grows, grows by less
constexpr double shown_in_tolerances = 0.2;     // or in farthest: nearer than that, renewed
constexpr double thinnest = 1e-3;               // height over longest edge
constexpr double least_area_of_squares = 1e-9;  // of a part's sides, below which it has no area
constexpr std::int64_t most_cut = 2;            // times as many triangles as before
constexpr std::int64_t least_cut = 20'000;      // that may always be

void require_area(const Surface& of_template) {
  require(of_template.area > 0, "the template has no triangle with area, so nothing to keep");
}

void check(const Surface& of_template, const Surface& target, const RemeshOptions& options) {
  require_area(of_template);
  require(target.area > 0, "the target has no triangle with area, so nothing to show");
  require(options.tolerance >= 0 && std::isfinite(options.tolerance),
          fmt::format("the tolerance must be a distance, found {}", options.tolerance));
  require(
      options.accuracy >= 0 && std::isfinite(options.accuracy) && options.farthest >= 0,
      fmt::format("the accuracy and the farthest of remeshing must be distances, found {} and {}",
                  options.accuracy, options.farthest));
  require(options.keep >= 0 && options.keep <= 1,
          fmt::format("the score to keep must be from 0 to 1, found {}", options.keep));
  require(options.retriangulated.empty() ||
              std::ssize(options.retriangulated) == of_template.triangle_count(),
          "what is renewed needs an entry per triangle of the template");
  require(options.growth >= 0,
          fmt::format("growth must not be negative, found {}", options.growth));
}

/// How a vertex came into the region.
enum class Mark : char { none, seed, grown };

/// What goes and comes, and how the gap is closed.
struct Cut {
  std::vector<char> kept;  ///< per triangle of the pair
  std::vector<Triangle> strips;
  std::vector<int> failed;  ///< vertices where it does not work
};

class Remesher {
 public:
  Remesher(const SearchedSurface& of_template, const SearchedSurface& target,
           const RemeshOptions& options)
      : template_(of_template.surface),
        target_(target.surface),
        options_(options),
        template_finder_(of_template.closest),
        target_finder_(target.closest) {}

  Remeshed run(const Progress& progress) {
    find_seeds(progress.step("find seeds", 0.5));
    Cut cut = grow(progress.step("grow", 0.3));
    Stopwatch watch;
    finish(cut, progress.step("stitch", 0.2));
    return std::move(result_);
  }

 private:
  void find_seeds(const Progress& progress);
  void refuse_inside_out() const;
  void group_components();
  Cut grow(const Progress& progress);
  std::optional<Cut> attempt();
  bool leave_what_is_passed(Cut& cut, const std::vector<CutCurve>& curves,
                            const CurvePairs& found) const;
  bool reaches_too_far(const Triangle& t) const;
  void refuse_crossings(Cut& cut);
  bool crosses_itself_near(const Triangle& t);
  bool mark(const std::vector<int>& vertices, Mark how);
  std::vector<int> with_neighbours(const std::vector<int>& vertices) const;
  std::vector<char> groups_of(const std::vector<int>& vertices) const;
  void restart_region();
  std::vector<int> uncovered(const Cut& cut) const;
  bool template_stays() const;
  bool replace_outgrown();
  void replace(const std::vector<char>& groups);
  std::vector<double> inside_area() const;
  std::vector<Vector3> offsets() const;
  std::int64_t count_crossings(const Seam& seam) const;
  void unfold_added();
  void finish(Cut& cut, const Progress& progress);
  std::vector<VertexOrigin> find_origins(const std::vector<Vector3>& positions) const;
  void put(const Seam& seam);

  int group(int t) const {
    const int source = pair_.source_triangle[t];
    return pair_.triangle_of_target(t) ? target_group_[source] : template_group_[source];
  }
  void note(const std::string& step, const Stopwatch& watch) {
    result_.seconds.emplace_back(step, watch.seconds());
  }

  const Surface &template_, &target_;
  const RemeshOptions& options_;
  const ClosestPointFinder &template_finder_, &target_finder_;
  Remeshed result_;
  SurfacePair pair_;
  std::vector<ClosestPoint> on_target_, on_template_;  // of template's and target's vertices
  std::vector<double> scores_;
  std::vector<char> distorted_;  // per triangle of the template, or none at all
  std::vector<Mark> marked_;     // per vertex of the pair
  std::optional<MarkedRegion> region_;
  std::vector<int> template_group_, target_group_;  // per triangle
  std::vector<char> replaced_;                      // per group: as a whole
  std::vector<double> group_area_, first_inside_;   // per group
  std::optional<Mesh> self_crossings_;              // triangles of both surfaces, once asked for
  std::optional<ClosestPointFinder> near_self_crossings_;
  double reach_ = 0;  // between curves that go together
};

void Remesher::find_seeds(const Progress& progress) {
  Stopwatch watch;
  const double h = mean_edge_length(template_), g = mean_edge_length(target_);
  const double tolerance = options_.tolerance > 0 ? options_.tolerance : 2 * std::min(h, g);
  reach_ = 2 * tolerance + 2 * (h + g);
  const double accuracy = options_.accuracy > 0 ? options_.accuracy : tolerance;
  const MismatchOptions how{accuracy, options_.occlusion, options_.curvature, options_.keep,
                            options_.farthest};
  Mismatch of_template = mismatch(template_, target_finder_, how, progress.step("template", 0.5));
  Mismatch of_target = mismatch(target_, template_finder_, how, progress.step("target", 0.5));
  distorted_.assign(options_.retriangulated.begin(), options_.retriangulated.end());
  if (!options_.rest.empty()) {
    const std::vector<char> distorted = distorted_triangles(template_.mesh, options_.rest);
    distorted_.resize(distorted.size(), 0);
    for (std::size_t t = 0; t < distorted.size(); ++t) distorted_[t] |= distorted[t];
  }
  result_.distorted = int(std::ranges::count(distorted_, char(1)));
  const double near = shown_in_tolerances *
                      std::min(tolerance, options_.farthest > 0 ? options_.farthest : tolerance);
  for (std::size_t t = 0; t < distorted_.size(); ++t) {
    const Triangle& corners = template_.mesh.triangles[t];
    if (distorted_[t] && std::ranges::any_of(corners, [&](int v) {
          return of_template.places[v].squared_distance > near * near;
        }))
      for (const int v : corners) of_template.scores[v] = std::max(of_template.scores[v], 2.0);
  }
  const auto above = [](const std::vector<double>& scores) {
    return int(std::ranges::count_if(scores, [](double s) { return s > 1; }));
  };
  result_.tolerance = tolerance;
  result_.template_seeds = above(of_template.scores);
  result_.target_seeds = above(of_target.scores);
  on_target_ = std::move(of_template.places);
  on_template_ = std::move(of_target.places);
  scores_ = std::move(of_template.scores);
  scores_.insert(scores_.end(), of_target.scores.begin(), of_target.scores.end());
  pair_ = join(template_, target_);
  refuse_inside_out();
  group_components();
  note("find seeds", watch);
}

void Remesher::refuse_inside_out() const {
  const std::vector<Vector3> normals = triangle_normals(target_.mesh);
  std::int64_t near = 0, against = 0;
  for (int v = 0; v < template_.mesh.vertex_count(); ++v) {
    if (scores_[v] > 1) continue;
    ++near;
    against += normals[on_target_[v].triangle].dot(pair_.normals[v]) < 0;
  }
  require(
      2 * near < std::ssize(on_target_) || 10 * against <= 9 * near,
      fmt::format("where the template lies at its target, {} of {} of its vertices have normals "
                  "that point the other way: one of the two is turned inside out; turn it over",
                  against, near));
}

/// Components of both surfaces that show one another are one group.
void Remesher::group_components() {
  const std::vector<int> of_template = triangle_components(template_);
  const std::vector<int> of_target = triangle_components(target_);
  const int count = template_.triangle_count();
  DisjointSets sets(std::size_t(count) + of_target.size());
  const auto join_near = [&](const Surface& surface, const std::vector<ClosestPoint>& places,
                             int first_score, auto&& join) {
    for (int t = 0; t < surface.triangle_count(); ++t)
      for (const int v : surface.mesh.triangles[t])
        if (scores_[first_score + v] <= 1) join(t, places[v].triangle);
  };
  join_near(template_, on_target_, 0,
            [&](int t, int s) { sets.join(of_template[t], count + of_target[s]); });
  join_near(target_, on_template_, template_.mesh.vertex_count(),
            [&](int s, int t) { sets.join(of_template[t], count + of_target[s]); });
  for (int t = 0; t < count; ++t) template_group_.push_back(sets.root(of_template[t]));
  for (const int c : of_target) target_group_.push_back(sets.root(count + c));
  replaced_.assign(std::size_t(count) + of_target.size(), 0);
  group_area_.assign(replaced_.size(), 0);
  for (int t = 0; t < pair_.mesh.triangle_count(); ++t)
    group_area_[group(t)] += triangle_area(pair_.mesh, t);
}

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
std::optional<Cut> Remesher::attempt() {
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

Cut Remesher::grow(const Progress& progress) {
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

/// Where the vertices of the pair, now at these positions, lie on their surfaces.
std::vector<VertexOrigin> Remesher::find_origins(const std::vector<Vector3>& positions) const {
  std::vector<VertexOrigin> origins(positions.size());
  for (int t = 0; t < pair_.mesh.triangle_count(); ++t)
    for (int k = 0; k < 3; ++k) {
      const int v = pair_.mesh.triangles[t][k], source = pair_.source_triangle[t];
      VertexOrigin& origin = origins[v];
      if (origin.triangle >= 0) continue;
      const Mesh& mesh = pair_.of_target[v] ? target_.mesh : template_.mesh;
      origin = {{source, Vector3::Zero()}, pair_.of_target[v]};
      const auto& corners = mesh.triangles[source];
      const auto at = std::ranges::find(corners, pair_.source_vertex[v]);
      if (at != corners.end())
        origin.barycentric[at - corners.begin()] = 1;
      else
        origin.barycentric = closest_point(mesh, source, positions[v]).barycentric;
    }
  for (const char of_target : {0, 1}) {
    std::vector<int> moved;
    std::vector<Vector3> points;
    for (std::size_t v = 0; v < positions.size(); ++v)
      if (pair_.of_target[v] == of_target && positions[v] != pair_.mesh.positions[v]) {
        moved.push_back(int(v));
        points.push_back(positions[v]);
      }
    if (moved.empty()) continue;
    const auto places = (of_target ? target_finder_ : template_finder_)(points);
    for (std::size_t i = 0; i < moved.size(); ++i)
      origins[moved[i]] = {places[i], of_target};
  }
  return origins;
}

void Remesher::put(const Seam& seam) {
  std::vector<int> place(seam.positions.size(), -1);
  const std::vector<VertexOrigin> origins = find_origins(seam.positions);
  for (const Triangle& t : seam.triangles)
    for (const int v : t) place[v] = 0;
  // Vertices of the template first, each surface in its order.
  for (const char of_target : {0, 1})
    for (std::size_t v = 0; v < place.size(); ++v) {
      if (place[v] < 0 || pair_.of_target[v] != of_target) continue;
      place[v] = result_.mesh.vertex_count();
      const int source = pair_.source_vertex[v];
      result_.mesh.positions.push_back(seam.positions[v]);
      result_.origins.push_back(origins[v]);
      result_.template_vertices.push_back(of_target || seam.free[v] ? -1 : source);
      result_.target_vertices.push_back(of_target ? source : -1);
    }
  for (std::size_t i = 0; i < seam.triangles.size(); ++i) {
    const auto& [a, b, c] = seam.triangles[i];
    result_.mesh.triangles.push_back({place[a], place[b], place[c]});
    const int t = seam.from[i];
    const bool whole = t >= 0 && pair_.whole[t];
    const bool of_target = t >= 0 && pair_.triangle_of_target(t);
    result_.template_triangles.push_back(whole && !of_target ? pair_.source_triangle[t] : -1);
    result_.target_triangles.push_back(whole && of_target ? pair_.source_triangle[t] : -1);
  }
}

/// From vertices of the target that the template shows to where it shows them.
std::vector<Vector3> Remesher::offsets() const {
  std::vector<Vector3> offsets(pair_.mesh.positions.size(), Vector3::Zero());
  for (std::size_t v = 0; v < offsets.size(); ++v) {
    const int source = pair_.source_vertex[v];
    if (!pair_.of_target[v] || source < 0) continue;
    const int first = template_.mesh.vertex_count();
    const ClosestPoint& place = on_template_[source];
    if (scores_[first + source] > 1) continue;
    Vector3 there = Vector3::Zero(), normal = Vector3::Zero();
    for (int k = 0; k < 3; ++k) {
      const int w = template_.mesh.triangles[place.triangle][k];
      there += place.barycentric[k] * template_.mesh.positions[w];
      normal += place.barycentric[k] * pair_.normals[w];
    }
    if (normal.dot(pair_.normals[v]) > 0.5) offsets[v] = there - pair_.mesh.positions[v];
  }
  return offsets;
}

/// Triangles that are not as they were in the pair, and cross others.
std::int64_t Remesher::count_crossings(const Seam& seam) const {
  std::vector<Triangle> changed, others;
  for (std::size_t i = 0; i < seam.triangles.size(); ++i) {
    const Triangle& t = seam.triangles[i];
    const bool moved =
        std::ranges::any_of(t, [&](int v) { return seam.positions[v] != pair_.mesh.positions[v]; });
    (seam.from[i] < 0 || moved ? changed : others).push_back(t);
  }
  return std::ranges::count(crossed(seam.positions, changed, others), char(1));
}

/// Takes out pieces that are edge to edge with nothing else and enclose no area, such as two
/// opposite triangles: nothing can be integrated over them.
void drop_parts_without_area(Seam& seam) {
  Mesh mesh;
  mesh.positions = seam.positions;
  mesh.triangles = seam.triangles;
  const Surface surface = make_surface(mesh, {.kind = WeldOptions::Kind::none});
  const std::vector<int> part = triangle_components(surface);
  std::vector<double> area(part.size(), 0), squares(part.size(), 0);
  for (std::size_t t = 0; t < part.size(); ++t) {
    area[part[t]] += triangle_area(mesh, int(t));
    for (int k = 0; k < 3; ++k)
      squares[part[t]] +=
          (mesh.position(int(t), (k + 1) % 3) - mesh.position(int(t), k)).squaredNorm();
  }
  std::size_t kept = 0;
  for (std::size_t t = 0; t < part.size(); ++t)
    if (area[part[t]] > least_area_of_squares * squares[part[t]]) {
      seam.triangles[kept] = seam.triangles[t];
      seam.from[kept++] = seam.from[t];
    }
  seam.triangles.resize(kept);
  seam.from.resize(kept);
}

/// Vertices of the template stay, as what is kept does bit for bit.
void Remesher::unfold_added() {
  std::vector<char> fixed;
  for (const int v : result_.template_vertices) fixed.push_back(v >= 0);
  result_.mesh.positions = unfolded(result_.mesh, fixed);
}

void Remesher::finish(Cut& cut, const Progress& progress) {
  Stopwatch watch;
  const Retriangulation retriangulated = retriangulate(pair_, cut.kept, distorted_, options_.rest);
  std::vector<Triangle> triangles;
  std::vector<int> from;
  const auto take = [&](bool retriangulation, auto&& wanted) {
    for (int t = 0; t < pair_.mesh.triangle_count(); ++t)
      if (cut.kept[t] && (retriangulated.triangles[t] != 0) == retriangulation && wanted(t)) {
        triangles.push_back(pair_.mesh.triangles[t]);
        from.push_back(retriangulation ? -1 : t);
      }
  };
  take(false, [&](int t) { return pair_.whole[t] && !pair_.triangle_of_target(t); });
  take(false, [&](int t) { return !pair_.whole[t] && !pair_.triangle_of_target(t); });
  take(false, [&](int t) { return pair_.triangle_of_target(t); });
  take(true, [](int) { return true; });
  triangles.insert(triangles.end(), cut.strips.begin(), cut.strips.end());
  from.resize(triangles.size(), -1);
  Seam seam{std::move(triangles), std::move(from), pair_.mesh.positions, offsets(),
            retriangulated.vertices};
  Seam better = seam;
  improve_seam(pair_, target_.mesh, target_finder_, better);
  if (count_crossings(better) <= count_crossings(seam)) seam = std::move(better);
  drop_parts_without_area(seam);
  put(seam);
  unfold_added();
  note("stitch", watch);
  progress.at(0.5);
  Stopwatch measuring;
  measure(result_, template_, target_, on_target_, on_template_);
  note("measure", measuring);
  progress.at(1);
}

}  // namespace

std::vector<std::array<Vector3, 3>> corner_positions(const Mesh& mesh) {
  std::vector<std::array<Vector3, 3>> corners;
  corners.reserve(mesh.triangles.size());
  for (int t = 0; t < mesh.triangle_count(); ++t)
    corners.push_back({mesh.position(t, 0), mesh.position(t, 1), mesh.position(t, 2)});
  return corners;
}

Remeshed remesh(const Surface& of_template, const Surface& target, const RemeshOptions& options,
                const Progress& progress) {
  check(of_template, target, options);
  const ClosestPointFinder on_template(of_template.mesh), on_target(target.mesh);
  return Remesher({of_template, on_template}, {target, on_target}, options).run(progress);
}

Remeshed remesh(const SearchedSurface& of_template, const SearchedSurface& target,
                const RemeshOptions& options, const Progress& progress) {
  check(of_template.surface, target.surface, options);
  return Remesher(of_template, target, options).run(progress);
}

Remeshed tidied(const Surface& surface, const Progress& progress) {
  require_area(surface);
  const ClosestPointFinder closest(surface.mesh);
  return tidied(SearchedSurface{surface, closest}, progress);
}

Remeshed tidied(const SearchedSurface& searched, const Progress& progress) {
  const Surface& surface = searched.surface;
  std::vector<char> flawed(surface.mesh.triangles.size(), 0);
  for (const int t : folded_triangles(surface)) flawed[t] = 1;
  for (int t = 0; t < surface.triangle_count(); ++t) {
    const double longest = longest_edge(surface.mesh, t);
    if (!(2 * triangle_area(surface.mesh, t) > thinnest * longest * longest)) flawed[t] = 1;
  }
  return remesh(searched, searched, {.retriangulated = flawed}, progress);
}

}  // namespace mq

// Per frame: the nodes' motion of the last frame is continued if that is nearer than none; closest
// points both ways, weighted after Welsch, pull the graph onto the target while its stiffness and
// the width of the weights fall; colours move the correspondences along the surface; and a screened
// Poisson equation brings each vertex the rest of the way,
//
//     (M·W + α·S)·u = M·W·d,   d = n nᵀ(y − x),   W the weights of the closest points y,
//
// to which the target's vertices that are nearest to a corner x add theirs, d = y − x without n nᵀ.
// A part of the rest shape is kept in every frame, so that what slides along the surface, where
// no data hold it, comes back. What is folded over in the end is unfolded.

#include "mq/track/tracking.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/base/stopwatch.h"
#include "mq/fem/vertex_space.h"
#include "mq/flow/surface_registration.h"
#include "mq/mesh/closest_point.h"
#include "mq/track/deformation_graph.h"
#include "mq/track/detail/alone.h"
#include "mq/track/detail/shares.h"
#include "mq/track/recognised_positions.h"

namespace mq {
namespace {

/// Of a pull along the surface towards the closest point, against that along the normal: enough to
/// hold what nothing else does.
constexpr double tangential_share = 1e-2;
/// Vertices looked at to choose between two beginnings.
constexpr int prediction_samples = 1000;
/// Of what is within this, in diagonals, no other way is tried; of two, the less distorted one is taken.
constexpr double found_distance = 2e-3;
/// Distance times distortion, in that of a frame that is lost: what is no better than this is chance.
constexpr double most_cost_again = 0.5;
/// Nodes that move less than this part of their spacing have arrived.
constexpr double arrived = 2e-3;
/// Of a pair of points that do not find each other: how far apart both ways may end, in reaches
/// and in the distance itself.
constexpr double mutual_reaches = 2, mutual_part = 0.5;

Vector3 normal_at(const Mesh& mesh, const std::vector<Vector3>& normals, const SurfacePoint& p) {
  return value_at(mesh, normals, p).normalized();
}

/// A point of the template and one of the target that may be the same.
struct Match {
  int vertex = -1;                   ///< of the template; −1: none
  Vector3 move = Vector3::Zero();    ///< to the target
  Vector3 normal = Vector3::Zero();  ///< of the target there
  double mass = 0;                   ///< share of the area it stands for
  double weight = 0;
};

/// How the template follows colours.
struct ColourPull {
  int cycles = 1;   ///< of registration
  int steps = 1;    ///< of Gauss and Newton in each
  double part = 1;  ///< of the way that the flow says
};

/// Beside a motion that is known, and has followed colours itself: what has slid since the first frame grows slowly, and
/// errors of the flow, which differ from frame to frame, are halved with it.
constexpr ColourPull pull_of_known{.cycles = 1, .steps = 1, .part = 0.5};

}  // namespace

struct SurfaceTracker::State {
  State(const Mesh& rest_mesh, const Signal& colours_, const TrackOptions& options_)
      : options(options_),
        rest(make_surface(rest_mesh, {.kind = WeldOptions::Kind::none})),
        colours(colours_),
        now(rest),
        shares(area_shares(rest.mesh)),
        space(rest),
        spacing(options.node_spacing * std::sqrt(rest.area)),
        edge(mean_edge_length(rest)),
        reach(std::max(edge, spacing / 2)),
        graph(rest, spacing) {
    require(colours.size() == 0 || colours.rows() == rest.mesh.vertex_count(),
            fmt::format("{} rows of colours were given for {} vertices", colours.rows(),
                        rest.mesh.vertex_count()));
  }

  void find_nearest(const TrackTarget& target);
  std::vector<Match> matches(const TrackTarget& target);
  void weigh(std::vector<Match>& found, double widths) const;
  std::vector<NodeMotion> beginning(std::span<const Vector3> current,
                                    std::span<const Vector3> previous, const TrackTarget& target,
                                    bool& predicted) const;
  void deform_graph(std::span<const Vector3> current, const TrackTarget& target,
                    TrackedFrame& frame, std::vector<NodeMotion>& motions,
                    const Progress& progress);
  bool sees_colours(const TrackTarget& target) const;
  void follow_colours(std::span<const Vector3> current, const TrackTarget& target, const ColourPull& pull,
                      TrackedFrame& frame, std::vector<NodeMotion>& motions, const Progress& progress);
  void keep_rest(std::span<const Vector3> current, const std::vector<NodeMotion>& motions,
                 const std::vector<NodeMotion>& turned);
  void snap(const TrackTarget& target, TrackedFrame& frame, const Progress& progress);
  void lie_on(std::span<const Vector3> current, const TrackTarget& target, TrackedFrame& frame,
              std::vector<NodeMotion> motions, const Progress& progress);
  void settle(const TrackTarget& target, TrackedFrame& frame, const Progress& progress);
  void find_again(std::span<const Vector3> current, const std::vector<NodeMotion>& begin,
                  const TrackTarget& target, TrackedFrame& frame, const Progress& progress);
  void add_pulls_of_target(const TrackTarget& target, const std::vector<Vector3>& normals,
                           const std::vector<char>& left_out, double width,
                           std::vector<double>& weights, Signal& moves) const;
  Signal screened(const std::vector<double>& weights, const Signal& moves, double alpha);

  TrackOptions options;
  Surface rest;
  Signal colours;
  Surface now;  ///< the template where it is at the moment
  std::vector<double> shares;
  VertexSpace space;
  double spacing, edge;
  /// How far a surface may be off that a node cannot follow any better: half the way to the next,
  /// or an edge, as points between vertices are not known.
  double reach;
  DeformationGraph graph;
  std::unique_ptr<DirectSolver> snap_solver;
  SparseMatrix stiffness;
  /// Closest points of the template's vertices on the last target, and of that one's on the template.
  std::vector<ClosestPoint> there, back;
};

/// Those of before are where the search begins: between two steps little moves.
void SurfaceTracker::State::find_nearest(const TrackTarget& target) {
  there = target.closest()(now.mesh.positions, there);
  back = ClosestPointFinder(now.mesh)(target.surface().mesh.positions, back);
}

/// Closest points from the template's vertices to the target, and from the target's to the template
/// (which pull at the nearest corner). Both must face alike; the first are left out where the way
/// back leads elsewhere.
std::vector<Match> SurfaceTracker::State::matches(const TrackTarget& target) {
  const Mesh &mesh = now.mesh, &other = target.surface().mesh;
  const std::vector<Vector3> normals = vertex_normals(mesh);
  const double least_cosine = std::cos(options.most_angle * std::numbers::pi / 180);
  find_nearest(target);
  const std::vector<double> target_shares = area_shares(other);
  const std::vector<char> mine_alone = alone(mesh, there, other, back, reach);
  const std::vector<char> target_alone = alone(other, back, mesh, there, reach);
  std::vector<Match> all(there.size() + back.size());
  parallel_for(std::ssize(there), [&](std::int64_t v) {
    const ClosestPoint& p = there[v];
    const Vector3 normal = normal_at(other, target.normals(), p);
    if (!(normals[v].dot(normal) > least_cosine)) return;
    const int corner = nearest_corner(other, p);
    if (mine_alone[v] || target_alone[corner]) return;
    const Vector3 returned = point_at(mesh, back[corner]);
    const double distance = std::sqrt(p.squared_distance);
    if ((returned - mesh.positions[v]).norm() > mutual_reaches * reach + mutual_part * distance)
      return;
    all[v] = {int(v), point_at(other, p) - mesh.positions[v], normal, shares[v]};
  });
  parallel_for(std::ssize(back), [&](std::int64_t u) {
    const ClosestPoint& p = back[u];
    const Vector3 normal = normal_at(mesh, normals, p);
    if (!(normal.dot(target.normals()[u]) > least_cosine)) return;
    if (target_alone[u]) return;
    all[std::ssize(there) + u] = {nearest_corner(mesh, p), other.positions[u] - point_at(mesh, p),
                                  target.normals()[u], target_shares[u]};
  });
  return all;
}

/// Welsch's weights exp(−d²/2ν²), ν so many medians of d but no less than the reach.
void SurfaceTracker::State::weigh(std::vector<Match>& found, double widths) const {
  std::vector<double> distances;
  for (const Match& m : found)
    if (m.vertex >= 0) distances.push_back(m.move.norm());
  const double width = std::max(widths * median(distances), reach);
  for (Match& m : found) m.weight = std::exp(-m.move.squaredNorm() / (2 * width * width));
}

/// A node that turned by R and moved by d goes on by R·d: on a circle, if it went on one.
std::vector<NodeMotion> SurfaceTracker::State::beginning(std::span<const Vector3> current,
                                                         std::span<const Vector3> previous,
                                                         const TrackTarget& target,
                                                         bool& predicted) const {
  std::vector<NodeMotion> still(std::size_t(graph.node_count()));
  predicted = false;
  if (previous.empty() || options.prediction == TrackOptions::Prediction::none) return still;
  std::vector<NodeMotion> moving = graph.fitted(previous, current);
  for (NodeMotion& m : moving) m.translation = m.rotation * m.translation;
  const std::vector<Vector3> ahead = graph.deformed(current, moving);
  const std::size_t stride = std::max<std::size_t>(1, current.size() / prediction_samples);
  std::vector<Vector3> samples[2];
  for (std::size_t v = 0; v < current.size(); v += stride) {
    samples[0].push_back(current[v]);
    samples[1].push_back(ahead[v]);
  }
  double cost[2];
  for (const int which : {0, 1}) {
    std::vector<double> distances;
    for (const ClosestPoint& p : target.closest()(samples[which]))
      distances.push_back(std::sqrt(p.squared_distance));
    cost[which] = 0;
    for (const double d : distances) cost[which] += std::min(d, 4 * edge);
  }
  predicted = cost[1] < cost[0];
  return predicted ? moving : still;
}

void SurfaceTracker::State::deform_graph(std::span<const Vector3> current,
                                         const TrackTarget& target, TrackedFrame& frame,
                                         std::vector<NodeMotion>& motions,
                                         const Progress& progress) {
  const std::vector<NodeMotion> turned = graph.fitted(rest.mesh.positions, current);
  std::vector<PointConstraint> constraints(current.size());
  for (int level = 0; level < options.levels; ++level) {
    const double part = options.levels > 1 ? double(level) / (options.levels - 1) : 1;
    const double stiffness_now =
        options.first_stiffness * std::pow(options.last_stiffness / options.first_stiffness, part);
    const double widths = std::pow(4.0, 1 - part);
    for (int i = 0; i < options.iterations; ++i) {
      progress.at((level + double(i) / options.iterations) / options.levels);
      const Stopwatch corresponding;
      now.mesh.positions = graph.deformed(current, motions);
      std::vector<Match> found = matches(target);
      weigh(found, widths);
      frame.seconds.correspond += corresponding.seconds();
      const Stopwatch solving;
      std::ranges::fill(constraints, PointConstraint{});
      for (const Match& m : found)
        if (m.vertex >= 0)
          constraints[m.vertex].add(m.mass * m.weight *
                                        (m.normal * m.normal.transpose() +
                                         tangential_share * Eigen::Matrix3d::Identity()),
                                    m.move);
      const double moved =
          graph.gauss_newton_step(current, constraints, rest.mesh.positions, turned,
                                  {stiffness_now, options.elasticity}, motions);
      frame.seconds.solve += solving.seconds();
      if (moved < arrived * spacing) break;
    }
  }
  now.mesh.positions = graph.deformed(current, motions);
}

bool SurfaceTracker::State::sees_colours(const TrackTarget& target) const {
  return options.colour_cycles > 0 && colours.size() > 0 && target.colours().cols() == colours.cols();
}

/// Steps 2 to 5 of the thesis' 4.8.2, as often as asked for.
void SurfaceTracker::State::follow_colours(std::span<const Vector3> current, const TrackTarget& target,
                                           const ColourPull& pull, TrackedFrame& frame,
                                           std::vector<NodeMotion>& motions, const Progress& progress) {
  const std::vector<NodeMotion> turned = graph.fitted(rest.mesh.positions, current);
  const Mesh& other = target.surface().mesh;
  MeshFlowOptions flow;
  flow.detail = {0, Length::Unit::model};
  flow.largest = options.colour_largest;
  flow.smallest = options.colour_smallest;
  std::vector<PointConstraint> constraints(current.size());
  const Stopwatch preparing;
  const ColourRegistrar registrar(target.surface(), target.colours(), flow,
                                  progress.step("colours' meshes", 0.2));
  frame.seconds.colour += preparing.seconds();
  for (int cycle = 0; cycle < pull.cycles; ++cycle) {
    const Stopwatch colouring;
    const ColourRegistration registered =
        registrar(now, colours, progress.step("colours", 0.8 / pull.cycles));
    frame.seconds.colour += colouring.seconds();
    for (int i = 0; i < pull.steps; ++i) {
      const Stopwatch corresponding;
      std::vector<Match> found = matches(target);
      weigh(found, 1);
      frame.seconds.correspond += corresponding.seconds();
      const Stopwatch solving;
      std::ranges::fill(constraints, PointConstraint{});
      for (const Match& m : found)
        if (m.vertex >= 0)
          constraints[m.vertex].add(m.mass * m.weight * m.normal * m.normal.transpose(), m.move);
      for (std::size_t v = 0; v < current.size(); ++v) {
        const SurfacePoint& p = registered.points[v];
        const Vector3 n = normal_at(other, target.normals(), p);
        if (!n.allFinite()) continue;
        constraints[v].add(options.colour_weight * shares[v] * registered.confidences[v] *
                               (Eigen::Matrix3d::Identity() - n * n.transpose()),
                           pull.part * (point_at(other, p) - now.mesh.positions[v]));
      }
      graph.gauss_newton_step(current, constraints, rest.mesh.positions, turned,
                              {options.colour_stiffness, options.elasticity}, motions);
      now.mesh.positions = graph.deformed(current, motions);
      frame.seconds.solve += solving.seconds();
    }
  }
}

/// Where the nodes would take the rest shape, as much of it as elasticity says.
void SurfaceTracker::State::keep_rest(std::span<const Vector3> current,
                                      const std::vector<NodeMotion>& motions,
                                      const std::vector<NodeMotion>& turned) {
  if (!(options.elasticity > 0)) return;
  std::vector<NodeMotion> from_rest(motions.size());
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const int v = graph.vertex_of(int(i));
    from_rest[i].rotation = motions[i].rotation * turned[i].rotation;
    from_rest[i].translation = current[v] + motions[i].translation - rest.mesh.positions[v];
  }
  const std::vector<Vector3> kept = graph.deformed(rest.mesh.positions, from_rest);
  for (std::size_t v = 0; v < current.size(); ++v)
    now.mesh.positions[v] += options.elasticity * (kept[v] - now.mesh.positions[v]);
}

Signal SurfaceTracker::State::screened(const std::vector<double>& weights, const Signal& moves,
                                       double alpha) {
  // On the surface scaled to area 1 masses are shares of it, and stiffness is what it was.
  SparseMatrix A = alpha * stiffness;
  Signal right(moves.rows(), 3);
  for (Eigen::Index v = 0; v < moves.rows(); ++v) {
    // Slivers have rows of large numbers whose sum is rounding: the last term is more than that.
    double& diagonal = A.coeffRef(int(v), int(v));
    diagonal += shares[v] * (weights[v] + 1e-6) + 1e-14 + 1e-12 * diagonal;
    right.row(v) = shares[v] * weights[v] * moves.row(v);
  }
  if (snap_solver)
    snap_solver->refactor(A);
  else
    snap_solver = std::make_unique<DirectSolver>(A);
  return snap_solver->solve(right);
}

/// Points of the target pull at the corner they are nearest to as well, which brings vertices onto
/// its sharp edges. Weights grow by theirs, times their area over that of the vertex.
void SurfaceTracker::State::add_pulls_of_target(const TrackTarget& target,
                                                const std::vector<Vector3>& normals,
                                                const std::vector<char>& left_out, double width,
                                                std::vector<double>& weights,
                                                Signal& moves) const {
  const Mesh &mesh = now.mesh, &other = target.surface().mesh;
  const double least_cosine = std::cos(options.most_angle * std::numbers::pi / 180);
  const std::vector<double> target_shares = area_shares(other);
  for (std::size_t v = 0; v < weights.size(); ++v) moves.row(Eigen::Index(v)) *= weights[v];
  for (std::size_t u = 0; u < back.size(); ++u) {
    const ClosestPoint& p = back[u];
    const Vector3 normal = normal_at(mesh, normals, p);
    if (!(normal.dot(target.normals()[u]) > least_cosine)) continue;
    const int v = nearest_corner(mesh, p);
    if (!(shares[v] > 0) || left_out[u]) continue;
    const double weight =
        std::exp(-p.squared_distance / (2 * width * width)) * target_shares[u] / shares[v];
    weights[v] += weight;
    moves.row(v) += weight * (other.positions[u] - point_at(mesh, p)).transpose();
  }
  for (std::size_t v = 0; v < weights.size(); ++v)
    if (weights[v] > 0) moves.row(Eigen::Index(v)) /= weights[v];
}

void SurfaceTracker::State::snap(const TrackTarget& target, TrackedFrame& frame,
                                 const Progress& progress) {
  const Stopwatch watch;
  if (stiffness.rows() == 0) stiffness = space.stiffness();
  const int n = now.mesh.vertex_count();
  const Mesh& other = target.surface().mesh;
  const double least_cosine = std::cos(options.most_angle * std::numbers::pi / 180);
  for (std::size_t pass = 0; pass < options.snaps.size(); ++pass) {
    progress.at(double(pass) / double(options.snaps.size()));
    const std::vector<Vector3> normals = vertex_normals(now.mesh);
    find_nearest(target);
    const std::vector<char> mine_alone = alone(now.mesh, there, other, back, reach);
    const std::vector<char> target_alone = alone(other, back, now.mesh, there, reach);
    std::vector<double> distances;
    for (const ClosestPoint& p : there) distances.push_back(std::sqrt(p.squared_distance));
    const double width = std::max(4 * median(distances), edge);
    std::vector<double> weights(std::size_t(n), 0);
    Signal moves = Signal::Zero(n, 3);
    parallel_for(n, [&](std::int64_t v) {
      const Vector3 normal = normal_at(other, target.normals(), there[v]);
      if (!(normals[v].dot(normal) > least_cosine)) return;
      if (mine_alone[v] || target_alone[nearest_corner(other, there[v])]) return;
      weights[v] = std::exp(-there[v].squared_distance / (2 * width * width));
      const Vector3 move = point_at(other, there[v]) - now.mesh.positions[v];
      moves.row(v) = (normal * normal.dot(move)).transpose();
    });
    frame.matched = 0;
    for (int v = 0; v < n; ++v) frame.matched += shares[v] * weights[v];
    add_pulls_of_target(target, normals, target_alone, width, weights, moves);
    const Signal u = screened(weights, moves, options.snaps[pass]);
    for (int v = 0; v < n; ++v) now.mesh.positions[v] += u.row(v).transpose();
  }
  frame.seconds.snap += watch.seconds();
}

/// The template where these motions and what is nearest to them lead, and how well it lies there.
void SurfaceTracker::State::lie_on(std::span<const Vector3> current, const TrackTarget& target,
                                   TrackedFrame& frame, std::vector<NodeMotion> motions,
                                   const Progress& progress) {
  const bool by_colour = sees_colours(target);
  deform_graph(current, target, frame, motions, progress.step("deform", by_colour ? 0.3 : 0.8));
  if (by_colour)
    follow_colours(current, target, {.cycles = options.colour_cycles, .steps = 2}, frame, motions,
                   progress.step("colours", 0.5));
  keep_rest(current, motions, graph.fitted(rest.mesh.positions, current));
  settle(target, frame, progress.step("snap", 0.2));
}

/// The template where it is now brought onto the target, and how well it lies there.
void SurfaceTracker::State::settle(const TrackTarget& target, TrackedFrame& frame, const Progress& progress) {
  snap(target, frame, progress);
  now.mesh.positions = unfolded_onto(target, now.mesh);
  const Stopwatch measuring;
  find_nearest(target);
  frame.distance = surface_distance(there, back, target);
  frame.distortion = distortion(rest.mesh.triangles, rest.mesh.positions, now.mesh.positions);
  frame.seconds.measure += measuring.seconds();
  frame.positions = now.mesh.positions;
}

/// The same from where points are recognised, if it lies much nearer then. The shape that it has there is
/// what stiffness keeps, as that of before would bend limbs back.
void SurfaceTracker::State::find_again(std::span<const Vector3> current, const std::vector<NodeMotion>& begin,
                                       const TrackTarget& target, TrackedFrame& frame, const Progress& progress) {
  const Stopwatch recognising;
  const std::vector<std::vector<Vector3>> begins =
      recognised_positions(graph, rest.mesh, current, graph.deformed(current, begin), target,
                           {spacing, options.elasticity}, progress.step("recognise", 0.5));
  frame.seconds.correspond += recognising.seconds();
  const auto cost = [](const TrackedFrame& of) {
    return std::max(of.distance.p95, found_distance) * of.distortion.mean;
  };
  double least = most_cost_again * cost(frame);
  const std::vector<NodeMotion> still(std::size_t(graph.node_count()));
  for (const std::vector<Vector3>& at : begins) {
    TrackedFrame other = frame;
    lie_on(at, target, other, still, progress.step("follow again", 0.5 / double(begins.size())));
    frame.seconds = other.seconds;
    if (!(cost(other) < least)) continue;
    least = cost(other);
    frame = std::move(other);
    frame.recognised = true;
    if (frame.distance.p95 < found_distance) break;
  }
}

SurfaceTracker::SurfaceTracker(const Mesh& rest, const Signal& colours, const TrackOptions& options)
    : state_(std::make_unique<State>(rest, colours, options)) {}
SurfaceTracker::~SurfaceTracker() = default;

int SurfaceTracker::node_count() const { return state_->graph.node_count(); }

TrackedFrame SurfaceTracker::follow(std::span<const Vector3> current, std::span<const Vector3> previous,
                                    const TrackTarget& target, const Progress& progress) {
  State& s = *state_;
  const std::size_t n = s.rest.mesh.positions.size();
  require(current.size() == n && (previous.empty() || previous.size() == n),
          fmt::format("{} and {} positions were given for a template of {} vertices",
                      current.size(), previous.size(), n));
  const Stopwatch watch;
  TrackedFrame frame;
  const std::vector<NodeMotion> motions = s.beginning(current, previous, target, frame.predicted);
  s.lie_on(current, target, frame, motions, progress);
  if (frame.distance.p95 > lost_distance && mutual_distance(s.there, s.back, target).p95 > lost_distance / 2)
    s.find_again(current, motions, target, frame, progress.step("find again", 0));
  frame.seconds.total = watch.seconds();
  return frame;
}

TrackedFrame SurfaceTracker::follow_known(std::span<const Vector3> current, std::vector<Vector3> moved,
                                          const TrackTarget& target, const Progress& progress) {
  State& s = *state_;
  const std::size_t n = s.rest.mesh.positions.size();
  require(current.size() == n && moved.size() == n,
          fmt::format("{} and {} positions were given for a template of {} vertices", current.size(), moved.size(), n));
  const Stopwatch watch;
  TrackedFrame frame;
  frame.known = true;
  s.now.mesh.positions = moved;
  const bool by_colour = s.sees_colours(target);
  if (by_colour) {
    std::vector<NodeMotion> slid(std::size_t(s.graph.node_count()));
    s.follow_colours(moved, target, pull_of_known, frame, slid, progress.step("colours", 0.8));
  }
  s.keep_rest(current, s.graph.fitted(current, s.now.mesh.positions), s.graph.fitted(s.rest.mesh.positions, current));
  s.settle(target, frame, progress.step("snap", by_colour ? 0.2 : 1));
  frame.seconds.total = watch.seconds();
  return frame;
}

}  // namespace mq

// Unknowns of a step: per node a small turn ω and a move τ, R ← exp(ω)·R, t ← t + τ. With a the
// lever R_i (x_v − g_i), vertex v moves by Σ_i w_i (ω_i × a + τ_i) = Σ_i w_i J_i (ω_i, τ_i), J_i =
// [−[a]×, I]. A block of the normal matrix sums the vertices that both its nodes carry, in a fixed
// order.

#include "mq/track/deformation_graph.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <queue>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/linear/dense.h"

namespace mq {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Jacobian = Eigen::Matrix<double, 3, 6>;

/// Holds turns and moves of nodes that nothing else holds, relative to the largest entry.
constexpr double damping = 1e-5;

Eigen::Matrix3d cross_matrix(const Vector3& a) {
  Eigen::Matrix3d A;
  A << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return A;
}

Jacobian jacobian(const Vector3& lever) {
  Jacobian J;
  J << -cross_matrix(lever), Eigen::Matrix3d::Identity();
  return J;
}

/// Σ += JᵀW J' of the levers a and a', W symmetric: with C(a) = [a]× it is [C(a)·Q, C(a)·W; Q, W], Q = (C(a')·W)ᵀ.
void add_product(const Vector3& a, const Eigen::Matrix3d& W, const Vector3& other, Matrix6& sum) {
  Eigen::Matrix3d Q;
  for (int c = 0; c < 3; ++c) Q.row(c) = other.cross(W.col(c));
  for (int c = 0; c < 3; ++c) {
    sum.block<3, 1>(0, c) += a.cross(Q.col(c));
    sum.block<3, 1>(0, 3 + c) += a.cross(W.col(c));
  }
  sum.block<3, 3>(3, 0) += Q;
  sum.block<3, 3>(3, 3) += W;
}

Eigen::Matrix3d rotation_of(const Vector3& turn) {
  const double angle = turn.norm();
  if (angle == 0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
}

/// Neighbours along edges, and how far.
struct Neighbours {
  std::vector<int> begin;
  std::vector<std::pair<int, double>> all;

  explicit Neighbours(const Mesh& mesh) : begin(mesh.positions.size() + 1, 0) {
    for (const Triangle& t : mesh.triangles)
      for (const int v : t) begin[v + 1] += 2;
    for (std::size_t v = 1; v < begin.size(); ++v) begin[v] += begin[v - 1];
    all.resize(std::size_t(begin.back()));
    std::vector<int> at(begin.begin(), begin.end() - 1);
    for (const Triangle& t : mesh.triangles)
      for (int k = 0; k < 3; ++k)
        for (const int other : {t[(k + 1) % 3], t[(k + 2) % 3]})
          all[at[t[k]]++] = {other, (mesh.positions[t[k]] - mesh.positions[other]).norm()};
  }
};

struct Reached {
  double distance;
  int vertex;
  bool operator>(const Reached& other) const {
    return distance != other.distance ? distance > other.distance : vertex > other.vertex;
  }
};

/// Dijkstra's distances from one vertex to those within a radius; `distance` is infinite elsewhere
/// and is given back so.
std::vector<Reached> within(const Neighbours& neighbours, int from, double radius,
                            std::vector<double>& distance) {
  std::vector<Reached> done;
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> front;
  std::vector<int> touched{from};
  distance[from] = 0;
  front.push({0, from});
  while (!front.empty()) {
    const Reached next = front.top();
    front.pop();
    if (next.distance > distance[next.vertex]) continue;
    done.push_back(next);
    for (int i = neighbours.begin[next.vertex]; i < neighbours.begin[next.vertex + 1]; ++i) {
      const auto [other, length] = neighbours.all[i];
      const double d = next.distance + length;
      if (d > radius || !(d < distance[other])) continue;
      if (std::isinf(distance[other])) touched.push_back(other);
      distance[other] = d;
      front.push({d, other});
    }
  }
  for (const int v : touched) distance[v] = std::numeric_limits<double>::infinity();
  return done;
}

}  // namespace

DeformationGraph::DeformationGraph(const Surface& surface, double spacing) {
  require(spacing > 0 && std::isfinite(spacing), "the spacing of nodes must be positive");
  place_nodes(surface, spacing);
  join_nodes();
}

void DeformationGraph::place_nodes(const Surface& surface, double spacing) {
  const Neighbours neighbours(surface.mesh);
  const int n = surface.mesh.vertex_count();
  std::vector<double> distance(std::size_t(n), std::numeric_limits<double>::infinity());
  std::vector<char> covered(std::size_t(n), 0);
  struct Near {
    double distance;
    int node;
  };
  std::vector<std::vector<Near>> near(static_cast<std::size_t>(n));
  for (int v = 0; v < n; ++v) {
    if (covered[v]) continue;
    const int node = node_count();
    nodes_.push_back(v);
    for (const Reached& r : within(neighbours, v, 2 * spacing, distance)) {
      near[r.vertex].push_back({r.distance, node});
      if (r.distance < spacing) covered[r.vertex] = 1;
    }
  }
  influences_.resize(std::size_t(n));
  members_.resize(nodes_.size());
  for (int v = 0; v < n; ++v) {
    std::ranges::sort(near[v], [](const Near& a, const Near& b) {
      return a.distance != b.distance ? a.distance < b.distance : a.node < b.node;
    });
    const int used = std::min<int>(most_influences, int(near[v].size()));
    double reach =
        int(near[v].size()) > most_influences ? near[v][most_influences].distance : 2 * spacing;
    if (!(reach > near[v][0].distance)) reach = 2 * spacing;
    double sum = 0;
    Influence& influence = influences_[v];
    for (int k = 0; k < used; ++k) {
      const double share = std::max(0.0, 1 - near[v][k].distance / reach);
      influence.nodes[k] = near[v][k].node;
      influence.weights[k] = share * share;
      sum += influence.weights[k];
    }
    for (int k = 0; k < used; ++k) {
      influence.weights[k] /= sum;
      if (influence.weights[k] > 0)
        members_[influence.nodes[k]].push_back({v, influence.weights[k]});
    }
  }
}

void DeformationGraph::join_nodes() {
  struct Pair {
    int i, j, vertex;
    double product;
  };
  std::vector<Pair> pairs;
  for (int v = 0; v < int(influences_.size()); ++v)
    for (int a = 0; a < most_influences; ++a)
      for (int b = 0; b < most_influences; ++b) {
        const Influence& f = influences_[v];
        if (f.nodes[a] < f.nodes[b] && f.weights[a] > 0 && f.weights[b] > 0)
          pairs.push_back({f.nodes[a], f.nodes[b], v, f.weights[a] * f.weights[b]});
      }
  std::ranges::stable_sort(
      pairs, [](const Pair& a, const Pair& b) { return a.i != b.i ? a.i < b.i : a.j < b.j; });
  for (const Pair& pair : pairs) {
    if (edges_.empty() || edges_.back() != std::array{pair.i, pair.j}) {
      edges_.push_back({pair.i, pair.j});
      shared_.emplace_back();
    }
    shared_.back().push_back({pair.vertex, pair.product});
  }
}

std::vector<Vector3> DeformationGraph::deformed(std::span<const Vector3> from,
                                                std::span<const NodeMotion> motions) const {
  std::vector<Vector3> result(from.size());
  parallel_for(std::ssize(from), [&](std::int64_t v) {
    const Influence& f = influences_[v];
    Vector3 sum = Vector3::Zero();
    for (int k = 0; k < most_influences; ++k) {
      if (!(f.weights[k] > 0)) continue;
      const NodeMotion& m = motions[f.nodes[k]];
      const Vector3& g = from[nodes_[f.nodes[k]]];
      sum += f.weights[k] * (m.rotation * (from[v] - g) + g + m.translation);
    }
    result[v] = sum;
  });
  return result;
}

std::vector<NodeMotion> DeformationGraph::fitted(std::span<const Vector3> from,
                                                 std::span<const Vector3> to) const {
  std::vector<NodeMotion> motions(nodes_.size());
  parallel_for(
      std::ssize(nodes_),
      [&](std::int64_t i) {
        double mass = 0;
        Vector3 a = Vector3::Zero(), b = Vector3::Zero();
        for (const Member& m : members_[i]) {
          mass += m.weight;
          a += m.weight * from[m.vertex];
          b += m.weight * to[m.vertex];
        }
        a /= mass, b /= mass;
        Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
        for (const Member& m : members_[i])
          covariance += m.weight * (to[m.vertex] - b) * (from[m.vertex] - a).transpose();
        NodeMotion& motion = motions[i];
        const SingularValues<3> svd = singular_values(covariance);
        // Fewer than two directions leave a turn open: none is taken then.
        if (svd.values[1] > 1e-9 * svd.values[0]) {
          // `nearest_rotation` assigned in place: what a function returns is summed in another order,
          // and sequences followed before would not be followed to the same bits.
          Vector3 signs = Vector3::Ones();
          if ((svd.U * svd.V.transpose()).determinant() < 0) signs[2] = -1;
          motion.rotation = svd.U * signs.asDiagonal() * svd.V.transpose();
        }
        const Vector3& g = from[nodes_[i]];
        motion.translation = b + motion.rotation * (g - a) - g;
      },
      16);
  return motions;
}

/// The normal equations of a step, in blocks of six.
struct DeformationGraph::NormalEquations {
  std::vector<Matrix6> diagonal;  // per node
  std::vector<Vector6> right;     // per node
  std::vector<Matrix6> off;       // per edge, of its first node's rows and its second's columns

  NormalEquations(std::size_t nodes, std::size_t edges)
      : diagonal(nodes, Matrix6::Zero()),
        right(nodes, Vector6::Zero()),
        off(edges, Matrix6::Zero()) {}

  /// Whether anything is held; what nothing holds then stays where it is.
  bool hold_loose_parts();
};

bool DeformationGraph::NormalEquations::hold_loose_parts() {
  double largest_turn = 0, largest_move = 0;
  for (const Matrix6& D : diagonal) {
    largest_turn = std::max(largest_turn, D.diagonal().head<3>().maxCoeff());
    largest_move = std::max(largest_move, D.diagonal().tail<3>().maxCoeff());
  }
  if (!(largest_move > 0)) return false;
  for (Matrix6& D : diagonal) {
    D.diagonal().head<3>().array() += damping * std::max(largest_turn, 1e-300);
    D.diagonal().tail<3>().array() += damping * largest_move;
  }
  return true;
}

void DeformationGraph::add_constraints(std::span<const Vector3> from,
                                       std::span<const PointConstraint> constraints,
                                       std::span<const NodeMotion> motions,
                                       NormalEquations& equations) const {
  std::vector<Matrix6>&diagonal = equations.diagonal, &off = equations.off;
  std::vector<Vector6>& right = equations.right;
  const auto lever = [&](int node, int vertex) -> Vector3 {
    return motions[node].rotation * (from[vertex] - from[nodes_[node]]);
  };
  parallel_for(
      std::ssize(nodes_),
      [&](std::int64_t i) {
        for (const Member& m : members_[i]) {
          const PointConstraint& constraint = constraints[m.vertex];
          if (constraint.weight.isZero(0)) continue;
          const Vector3 a = lever(int(i), m.vertex), force = m.weight * constraint.force;
          add_product(a, m.weight * m.weight * constraint.weight, a, diagonal[i]);
          right[i].head<3>() += a.cross(force);
          right[i].tail<3>() += force;
        }
      },
      4);
  parallel_for(
      std::ssize(edges_),
      [&](std::int64_t e) {
        for (const Member& m : shared_[e]) {
          const PointConstraint& constraint = constraints[m.vertex];
          if (constraint.weight.isZero(0)) continue;
          add_product(lever(edges_[e][0], m.vertex), m.weight * constraint.weight, lever(edges_[e][1], m.vertex), off[e]);
        }
      },
      16);
}

void DeformationGraph::add_stiffness(std::span<const Vector3> from, std::span<const Vector3> rest,
                                     std::span<const NodeMotion> since_rest,
                                     const Stiffness& stiffness,
                                     std::span<const NodeMotion> motions,
                                     NormalEquations& equations) const {
  std::vector<Matrix6>&diagonal = equations.diagonal, &off = equations.off;
  std::vector<Vector6>& right = equations.right;
  const double weight = edges_.empty() ? 0 : stiffness.weight / double(edges_.size());
  for (std::size_t e = 0; e < edges_.size(); ++e)
    for (const int side : {0, 1}) {
      const int i = edges_[e][side], j = edges_[e][1 - side];
      const Vector3 &gi = from[nodes_[i]], &gj = from[nodes_[j]];
      const Vector3 start = since_rest[i].rotation * (rest[nodes_[j]] - rest[nodes_[i]]);
      const Vector3 edge = motions[i].rotation *
                           ((1 - stiffness.elasticity) * (gj - gi) + stiffness.elasticity * start);
      // residual = edge + gi + ti − gj − tj + J(ω_i, τ_i) − τ_j
      const Vector3 residual = edge + gi + motions[i].translation - gj - motions[j].translation;
      const Jacobian J = jacobian(edge);
      diagonal[i] += weight * J.transpose() * J;
      right[i] -= weight * J.transpose() * residual;
      diagonal[j].bottomRightCorner<3, 3>() += weight * Eigen::Matrix3d::Identity();
      right[j].tail<3>() += weight * residual;
      if (side == 0)
        off[e].rightCols<3>() -= weight * J.transpose();
      else
        off[e].bottomRows<3>() -= weight * J;
    }
}

/// Rows of blocks, in each those to the nodes before, its own, those to the nodes after; edges are in that order too.
SparseMatrix DeformationGraph::pattern() const {
  const int n = node_count();
  std::vector<std::vector<int>> columns(static_cast<std::size_t>(n));
  for (const auto& [i, j] : edges_) columns[std::size_t(j)].push_back(i);
  for (int i = 0; i < n; ++i) columns[std::size_t(i)].push_back(i);
  for (const auto& [i, j] : edges_) columns[std::size_t(i)].push_back(j);
  SparseMatrix A(6 * n, 6 * n);
  A.resizeNonZeros(std::ptrdiff_t(36 * (std::size_t(n) + 2 * edges_.size())));
  std::ptrdiff_t at = 0;
  for (int i = 0; i < n; ++i)
    for (int a = 0; a < 6; ++a) {
      A.outerIndexPtr()[6 * i + a] = int(at);
      for (const int j : columns[std::size_t(i)])
        for (int b = 0; b < 6; ++b) A.innerIndexPtr()[at++] = 6 * j + b;
    }
  A.outerIndexPtr()[6 * n] = int(at);
  return A;
}

/// Writes the blocks of each row in the order of `pattern`.
void DeformationGraph::assemble(const NormalEquations& equations) {
  if (matrix_.rows() == 0) matrix_ = pattern();
  std::vector<int> next(nodes_.size(), 0);  // per row of blocks, how many are written
  double* const values = matrix_.valuePtr();
  const auto put = [&](int i, const Matrix6& block) {
    for (int a = 0; a < 6; ++a)
      Eigen::Map<Eigen::Matrix<double, 1, 6>>(values + matrix_.outerIndexPtr()[6 * i + a] + 6 * next[i]) = block.row(a);
    ++next[i];
  };
  for (std::size_t e = 0; e < edges_.size(); ++e) put(edges_[e][1], equations.off[e].transpose());
  for (int i = 0; i < node_count(); ++i) put(i, equations.diagonal[i]);
  for (std::size_t e = 0; e < edges_.size(); ++e) put(edges_[e][0], equations.off[e]);
}

double DeformationGraph::gauss_newton_step(std::span<const Vector3> from,
                                           std::span<const PointConstraint> constraints,
                                           std::span<const Vector3> rest,
                                           std::span<const NodeMotion> since_rest,
                                           const Stiffness& stiffness,
                                           std::vector<NodeMotion>& motions) {
  const int n = node_count();
  NormalEquations equations(nodes_.size(), edges_.size());
  add_constraints(from, constraints, motions, equations);
  add_stiffness(from, rest, since_rest, stiffness, motions, equations);
  if (!equations.hold_loose_parts()) return 0;
  assemble(equations);
  Signal B(6 * n, 1);
  for (int i = 0; i < n; ++i) B.block<6, 1>(6 * i, 0) = equations.right[i];
  if (solver_)
    solver_->refactor(matrix_);
  else
    solver_ = std::make_unique<DirectSolver>(matrix_);
  const Signal X = solver_->solve(B);
  double sum = 0;
  for (int i = 0; i < n; ++i) {
    const Vector3 turn = X.block<3, 1>(6 * i, 0), move = X.block<3, 1>(6 * i + 3, 0);
    motions[i].rotation = rotation_of(turn) * motions[i].rotation;
    motions[i].translation += move;
    sum += move.squaredNorm();
  }
  return std::sqrt(sum / n);
}

}  // namespace mq

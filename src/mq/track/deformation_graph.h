#pragma once
/// A coarse graph of rigid motions that carries a surface: embedded deformation (Sumner, Schmid,
/// Pauly [sumner2007embedded]), with as-rigid-as-possible edges; fitted as in [li2008global].
///
/// Node i at g_i turns by R_i and moves by t_i; a vertex follows the nodes around it:
///
///     x'_v = Σ_i w_iv (R_i (x_v − g_i) + g_i + t_i),   Σ_i w_iv = 1.

#include <Eigen/Geometry>

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "mq/linear/direct.h"
#include "mq/mesh/surface.h"

namespace mq {

/// The rigid motion of a node.
struct NodeMotion {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Vector3 translation = Vector3::Zero();
};

/// What pulls at a vertex, δᵀ·weight·δ − 2·δᵀ·force for its further move δ: a spring to where it
/// would move by d has force = weight·d. A weight n·nᵀ pulls along n alone.
struct PointConstraint {
  Eigen::Matrix3d weight = Eigen::Matrix3d::Zero();
  Vector3 force = Vector3::Zero();

  /// One more spring.
  void add(const Eigen::Matrix3d& spring, const Vector3& move) {
    weight += spring;
    force += spring * move;
  }
};

class DeformationGraph {
 public:
  static constexpr int most_influences = 4;

  /// Nodes are vertices, no two nearer than `spacing` along the edges and every vertex within that
  /// of one. A vertex follows at most its four nearest nodes, weighted (1 − d/d₅)², d₅ the distance
  /// of the fifth, or 2·spacing. Nodes that share a vertex are joined by an edge.
  DeformationGraph(const Surface& surface, double spacing);

  int node_count() const { return int(nodes_.size()); }
  int edge_count() const { return int(edges_.size()); }
  int vertex_of(int node) const { return nodes_[node]; }

  /// The nodes a vertex follows, and how much; unused ones have the weight 0.
  struct Influence {
    std::array<int, most_influences> nodes{};
    std::array<double, most_influences> weights{};
  };
  const Influence& influence(int vertex) const { return influences_[vertex]; }

  /// Vertices at `from` as the nodes carry them; `from` is where they were without any motion.
  std::vector<Vector3> deformed(std::span<const Vector3> from,
                                std::span<const NodeMotion> motions) const;

  /// The motions that carry `from` nearest to `to`: per node the best rigid motion of the vertices
  /// that follow it, weighted as they do (Horn, Closed-form solution of absolute orientation using
  /// orthonormal matrices, 1988).
  std::vector<NodeMotion> fitted(std::span<const Vector3> from, std::span<const Vector3> to) const;

  /// One step of Gauss and Newton for
  ///
  ///     Σ_v (pulls) + stiffness/edges · Σ_(ij) |R_i e_ij − (g_j + t_j − g_i − t_i)|²,
  ///
  /// both directions of each edge, e_ij = (1 − elasticity)·(g_j − g_i) + elasticity·Q_i·ē_ij: ē_ij
  /// the edge at rest and Q_i how node i has turned since. Returns how far the nodes moved, root
  /// mean square. Parts that nothing holds stay where they are.
  struct Stiffness {
    double weight = 1;
    double elasticity = 0;
  };
  double gauss_newton_step(std::span<const Vector3> from,
                           std::span<const PointConstraint> constraints,
                           std::span<const Vector3> rest, std::span<const NodeMotion> since_rest,
                           const Stiffness& stiffness, std::vector<NodeMotion>& motions);

 private:
  void place_nodes(const Surface& surface, double spacing);
  void join_nodes();

  struct NormalEquations;
  void add_constraints(std::span<const Vector3> from, std::span<const PointConstraint> constraints,
                       std::span<const NodeMotion> motions, NormalEquations& equations) const;
  void add_stiffness(std::span<const Vector3> from, std::span<const Vector3> rest,
                     std::span<const NodeMotion> since_rest, const Stiffness& stiffness,
                     std::span<const NodeMotion> motions, NormalEquations& equations) const;
  SparseMatrix pattern() const;
  void assemble(const NormalEquations& equations);

  struct Member {
    int vertex;
    double weight;
  };

  std::vector<int> nodes_;  // their vertices
  std::vector<Influence> influences_;
  std::vector<std::vector<Member>> members_;  // per node its vertices
  std::vector<std::array<int, 2>> edges_;     // i < j
  std::vector<std::vector<Member>> shared_;   // per edge its vertices and w_i·w_j
  SparseMatrix matrix_;                       // of the last step
  std::unique_ptr<DirectSolver> solver_;      // keeps the order of elimination
};

}  // namespace mq

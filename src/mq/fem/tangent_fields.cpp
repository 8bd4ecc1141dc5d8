// A closed 1-form that is not exact: ω is ±1 on the edges that a loop of triangles crosses, + where
// the edge leads from the right of the loop to its left. Each triangle of the loop is entered and
// left, so d₁ω = 0. With S·φ = d₀ᵀ⋆₁ω, ω − d₀φ has no divergence either: the harmonic form of its
// class.
//
// Loops: in the graph of triangles (and one place outside, behind all boundaries of a component)
// take a spanning tree that crosses no edge of a spanning tree of the vertices. Every edge left
// over closes one loop, and these are as many as the surface has classes.

#include "mq/fem/tangent_fields.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/fem/edges.h"
#include "mq/fem/exterior.h"
#include "mq/fem/vector_basis.h"
#include "mq/linear/connected_components.h"
#include "mq/linear/direct.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

/// Sets of numbers that are joined one by one.
class Joined {
 public:
  explicit Joined(int count) : parent_(std::size_t(count)) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int find(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  /// False where they were joined already.
  bool join(int i, int j) {
    i = find(i), j = find(j);
    if (i == j) return false;
    parent_[std::max(i, j)] = std::min(i, j);
    return true;
  }

 private:
  std::vector<int> parent_;
};

/// The triangles, and a place outside per component with a boundary, joined across edges.
class DualGraph {
 public:
  struct Crossing {
    int edge;
    int node[2];  ///< on the left of the edge, and on its right
  };

  DualGraph(const Surface& surface, const Edges& edges) : triangles_(surface.triangle_count()) {
    std::vector<int> left(edges.count(), -1), right(edges.count(), -1);
    for (std::size_t h = 0; h < edges.from_half_edge.size(); ++h) {
      const int e = edges.from_half_edge[h];
      if (e >= 0) (edges.sign[h] > 0 ? left : right)[e] = int(h) / 3;
    }
    Joined components(triangles_);
    for (int e = 0; e < edges.count(); ++e)
      if (left[e] >= 0 && right[e] >= 0) components.join(left[e], right[e]);
    const auto outside = [&](int triangle) { return triangles_ + components.find(triangle); };
    for (int e = 0; e < edges.count(); ++e) {
      const int l = left[e] >= 0 ? left[e] : outside(right[e]);
      const int r = right[e] >= 0 ? right[e] : outside(left[e]);
      crossings.push_back({e, {l, r}});
    }
  }

  int nodes() const { return 2 * triangles_; }

  std::vector<Crossing> crossings;  ///< one per edge

 private:
  int triangles_;
};

/// A spanning forest of the dual graph, hung from roots: per node the edge to its parent.
struct Forest {
  std::vector<int> up_edge;  ///< −1 at roots
  std::vector<int> up_node;
  std::vector<int> depth;
};

Forest hang(const DualGraph& graph, const std::vector<char>& in_tree) {
  std::vector<std::vector<int>> at(std::size_t(graph.nodes()));
  for (const DualGraph::Crossing& c : graph.crossings)
    if (in_tree[c.edge])
      for (const int node : c.node) at[node].push_back(c.edge);
  Forest forest{std::vector<int>(graph.nodes(), -1), std::vector<int>(graph.nodes(), -1),
                std::vector<int>(graph.nodes(), -1)};
  std::vector<int> queue;
  for (int root = 0; root < graph.nodes(); ++root) {
    if (forest.depth[root] >= 0) continue;
    forest.depth[root] = 0;
    queue.assign(1, root);
    for (std::size_t k = 0; k < queue.size(); ++k)
      for (const int e : at[queue[k]]) {
        const int* node = graph.crossings[e].node;
        const int other = node[0] == queue[k] ? node[1] : node[0];
        if (forest.depth[other] >= 0) continue;
        forest.depth[other] = forest.depth[queue[k]] + 1;
        forest.up_edge[other] = e;
        forest.up_node[other] = queue[k];
        queue.push_back(other);
      }
  }
  return forest;
}

/// ω of the loop across `edge` from its right to its left and back through the forest.
void add_loop(const DualGraph& graph, const Forest& forest, int edge, Eigen::Ref<Vector> omega) {
  const auto cross = [&](int e, int from) {  // + from right to left
    omega[e] += graph.crossings[e].node[1] == from ? 1 : -1;
  };
  int ahead = graph.crossings[edge].node[0], behind = graph.crossings[edge].node[1];
  cross(edge, behind);
  while (ahead != behind) {
    if (forest.depth[ahead] >= forest.depth[behind]) {
      cross(forest.up_edge[ahead], ahead);
      ahead = forest.up_node[ahead];
    } else {
      cross(forest.up_edge[behind], forest.up_node[behind]);
      behind = forest.up_node[behind];
    }
  }
}

/// Edges across which loops close, one for each class of closed forms.
std::vector<int> closing_edges(const Surface& surface, const Edges& edges, const DualGraph& graph,
                               std::vector<char>& in_tree) {
  Joined vertices(surface.mesh.vertex_count()), nodes(graph.nodes());
  std::vector<char> primal(std::size_t(edges.count()), 0);
  for (int e = 0; e < edges.count(); ++e)
    primal[e] = vertices.join(edges.vertices[e][0], edges.vertices[e][1]);
  std::vector<int> closing;
  for (int e = 0; e < edges.count(); ++e) {
    if (primal[e]) continue;
    in_tree[e] = nodes.join(graph.crossings[e].node[0], graph.crossings[e].node[1]);
    if (!in_tree[e]) closing.push_back(e);
  }
  return closing;
}

/// Takes off each column what is a gradient: ω − d₀φ with S·φ = d₀ᵀ⋆₁ω, one vertex of each
/// component held.
void take_off_gradients(const Edges& edges, const Vector& star_one, int vertex_count,
                        Eigen::MatrixXd& omega) {
  const SparseMatrix d = d0(edges, vertex_count);
  SparseMatrix S = d.transpose() * star_one.asDiagonal() * d;
  S.makeCompressed();
  const std::vector<int> component = connected_components(S);
  std::vector<char> held(component.size(), 0);
  Entries pins;
  for (int v = 0; v < vertex_count; ++v)
    if (!held[component[v]]) {
      held[component[v]] = 1;
      pins.emplace_back(v, v, 1.0);
    }
  S += sparse_matrix(vertex_count, vertex_count, pins);
  const Eigen::MatrixXd right = d.transpose() * (star_one.asDiagonal() * omega);
  omega -= d * Eigen::MatrixXd(DirectSolver(S).solve(Signal(right)));
}

double inner(const Surface& surface, const TangentField& x, const TangentField& y) {
  double sum = 0;
  for (int t = 0; t < surface.triangle_count(); ++t)
    sum += triangle_area(surface.mesh, t) * x[t].dot(y[t]);
  return sum;
}

/// Gram and Schmidt, twice.
void make_orthonormal(const Surface& surface, std::vector<TangentField>& fields) {
  for (std::size_t k = 0; k < fields.size(); ++k) {
    for (int pass = 0; pass < 2; ++pass)
      for (std::size_t j = 0; j < k; ++j) {
        const double share = inner(surface, fields[j], fields[k]);
        for (std::size_t t = 0; t < fields[k].size(); ++t) fields[k][t] -= share * fields[j][t];
      }
    const double norm = std::sqrt(inner(surface, fields[k], fields[k]));
    for (Vector3& v : fields[k]) v /= norm;
  }
}

Vector3 tangent_part(const Surface& surface, int t, const Vector3& v) {
  const Vector3 n = triangle_normal(surface.mesh, t);
  return n.isZero() ? Vector3::Zero() : Vector3(v - n.dot(v) * n);
}

}  // namespace

TangentField curvature_field(const Surface& surface, Principal which, int rings,
                             const Progress& progress) {
  const auto curvatures =
      triangle_curvatures(surface, vertex_curvatures(surface, {.rings = rings}, progress));
  TangentField field(curvatures.size());
  for (std::size_t t = 0; t < field.size(); ++t) {
    const PrincipalCurvatures& k = curvatures[t];
    field[t] = (k.max - k.min) * (which == Principal::max ? k.max_direction : k.min_direction);
  }
  return field;
}

TangentField gradient_field(const Surface& surface, const Vector& psi) {
  const VertexSpace space(surface);
  return field_in_space(surface, space.gradient(psi));
}

TangentField field_from_vertices(const Surface& surface, const std::vector<Vector3>& vertices) {
  require(vertices.size() == surface.mesh.positions.size(), "one vector per vertex is needed");
  TangentField field(surface.mesh.triangles.size());
  parallel_for(std::ssize(field), [&](std::int64_t t) {
    const Triangle& v = surface.mesh.triangles[t];
    field[t] =
        tangent_part(surface, int(t), (vertices[v[0]] + vertices[v[1]] + vertices[v[2]]) / 3);
  });
  return field;
}

std::vector<TangentField> harmonic_fields(const Surface& surface, const Progress& progress) {
  const std::vector<FlatTriangle> shapes = flat_triangles(surface);
  const Edges edges = make_edges(surface, shapes);
  const DualGraph graph(surface, edges);
  std::vector<char> in_tree(std::size_t(edges.count()), 0);
  const std::vector<int> closing = closing_edges(surface, edges, graph, in_tree);
  if (closing.empty()) return {};
  const Forest forest = hang(graph, in_tree);
  Eigen::MatrixXd omega = Eigen::MatrixXd::Zero(edges.count(), std::ssize(closing));
  for (std::size_t k = 0; k < closing.size(); ++k)
    add_loop(graph, forest, closing[k], omega.col(Eigen::Index(k)));
  progress.at(0.2);
  const int vertices = surface.mesh.vertex_count();
  const HodgeStars stars = hodge_stars(edges, surface.mesh.triangles, shapes, vertices);
  take_off_gradients(edges, stars.one, vertices, omega);
  progress.at(0.8);
  const SparseMatrix P = whitney_prolongation(edges, shapes);
  std::vector<TangentField> fields;
  for (std::size_t k = 0; k < closing.size(); ++k)
    fields.push_back(field_in_space(surface, P * omega.col(Eigen::Index(k))));
  make_orthonormal(surface, fields);
  progress.at(1);
  return fields;
}

double strength_of(const Surface& surface, const TangentField& field, double quantile) {
  std::vector<std::pair<double, double>> lengths;  // with areas
  double area = 0, none = 0;
  for (std::size_t t = 0; t < field.size(); ++t) {
    lengths.emplace_back(field[t].norm(), triangle_area(surface.mesh, int(t)));
    area += lengths.back().second;
    if (!(lengths.back().first > 0)) none += lengths.back().second;
  }
  std::sort(lengths.begin(), lengths.end());
  const double wanted =
      none < quantile * area ? quantile * area : none + quantile * (area - none);
  double below = 0, one = 0;
  for (const auto& [length, share] : lengths) {
    one = length;
    below += share;
    if (below >= wanted && one > 0) break;
  }
  return one;
}

TangentField scaled_to_one(const Surface& surface, TangentField field, double quantile) {
  const double one = strength_of(surface, field, quantile);
  if (!(one > 0)) return field;
  for (Vector3& v : field) v /= std::max(one, v.norm());
  return field;
}

TangentField normalised(const Surface& surface, TangentField field) {
  double sum = 0, area = 0;
  for (std::size_t t = 0; t < field.size(); ++t) {
    const double share = triangle_area(surface.mesh, int(t));
    sum += share * field[t].norm();
    area += share;
  }
  const double least = area > 0 ? 1e-6 * sum / area : 0;
  for (Vector3& v : field) v = v.norm() > least ? v.normalized() : Vector3::Zero();
  return field;
}

}  // namespace mq

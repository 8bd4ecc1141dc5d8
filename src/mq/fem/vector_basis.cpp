/// The Whitney mass from Gram matrices: with W_ij = λ_i∇λ_j − λ_j∇λ_i, I_ab = ∫ λ_a λ_b dA and
/// G_ab = ⟨∇λ_a, ∇λ_b⟩,
///
///     ∫ ⟨W_ij, W_kl⟩ dA = I_ik·G_jl − I_il·G_jk − I_jk·G_il + I_jl·G_ik.

#include "mq/fem/vector_basis.h"

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/fem/exterior.h"

namespace mq {

namespace {

/// ∫ ⟨W_k, W_l⟩ of the edges k → k + 1 and l → l + 1 of a triangle.
Eigen::Matrix3d whitney_block(const FlatTriangle& shape) {
  Eigen::Matrix<double, 2, 3> gradients;
  for (int k = 0; k < 3; ++k) gradients.col(k) = shape.gradient(k);
  const Eigen::Matrix3d G = gradients.transpose() * gradients;
  const Eigen::Matrix3d I =
      shape.area() / 12 * (Eigen::Matrix3d::Ones() + Eigen::Matrix3d::Identity());
  Eigen::Matrix3d block;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      const int j = (i + 1) % 3, l = (k + 1) % 3;
      block(i, k) = I(i, k) * G(j, l) - I(i, l) * G(j, k) - I(j, k) * G(i, l) + I(j, l) * G(i, k);
    }
  return block;
}

/// W_k at a point.
Vector2 whitney_form(const FlatTriangle& shape, int k, const Vector3& barycentric) {
  const int j = (k + 1) % 3;
  return barycentric[k] * shape.gradient(j) - barycentric[j] * shape.gradient(k);
}

void append_block(Entries& entries, const SparseMatrix& A, int row, int column) {
  for (int i = 0; i < A.rows(); ++i)
    for (SparseMatrix::InnerIterator entry(A, i); entry; ++entry)
      entries.emplace_back(row + i, column + int(entry.col()), entry.value());
}

}  // namespace

SparseMatrix triangle_mass(const std::vector<FlatTriangle>& shapes) {
  Vector areas(2 * shapes.size());
  for (std::size_t t = 0; t < shapes.size(); ++t)
    areas.segment<2>(2 * t).setConstant(shapes[t].area());
  return diagonal_matrix(areas);
}

SparseMatrix gradient_prolongation(const VertexSpace& space) {
  const SparseMatrix G = space.gradient_matrix();
  Entries entries;
  append_block(entries, G, 0, 0);
  for (int row = 0; row < G.rows(); ++row)
    for (SparseMatrix::InnerIterator entry(G, row); entry; ++entry)
      // J(x, y) = (−y, x): x goes to the second component, y to the first with a minus.
      entries.emplace_back(row ^ 1, space.size() + int(entry.col()),
                           row % 2 == 0 ? entry.value() : -entry.value());
  return sparse_matrix(int(G.rows()), 2 * space.size(), entries);
}

SparseMatrix gradient_mass(const VertexSpace& space) {
  const SparseMatrix P = gradient_prolongation(space);
  const SparseMatrix weighted = triangle_mass(space.shapes()) * P;
  return P.transpose() * weighted;
}

SparseMatrix curl_and_div(const VertexSpace& space, const Vector& star_zero) {
  require(star_zero.size() == space.size() && star_zero.minCoeff() > 0,
          "curl and divergence in the gradient basis need a positive area at every vertex");
  const SparseMatrix S = space.stiffness();
  const SparseMatrix weighted = star_zero.cwiseInverse().asDiagonal() * S;
  const SparseMatrix bilaplacian = S.transpose() * weighted;
  Entries entries;
  append_block(entries, bilaplacian, 0, 0);
  append_block(entries, bilaplacian, space.size(), space.size());
  return sparse_matrix(2 * space.size(), 2 * space.size(), entries);
}

SparseMatrix whitney_prolongation(const Edges& edges, const std::vector<FlatTriangle>& shapes) {
  const Vector3 barycentre = Vector3::Constant(1.0 / 3);
  Entries entries;
  for (int t = 0; t < int(shapes.size()); ++t)
    for (int k = 0; k < 3 && !shapes[t].empty(); ++k) {
      const Vector2 value = edges.sign[3 * t + k] * whitney_form(shapes[t], k, barycentre);
      entries.emplace_back(2 * t, edges.from_half_edge[3 * t + k], value.x());
      entries.emplace_back(2 * t + 1, edges.from_half_edge[3 * t + k], value.y());
    }
  return sparse_matrix(2 * int(shapes.size()), edges.count(), entries);
}

SparseMatrix whitney_mass(const Edges& edges, const std::vector<FlatTriangle>& shapes, WhitneyMass how) {
  if (how == WhitneyMass::one_point) {
    const SparseMatrix P = whitney_prolongation(edges, shapes);
    const SparseMatrix weighted = triangle_mass(shapes) * P;
    return P.transpose() * weighted;
  }
  Entries entries;
  for (int t = 0; t < int(shapes.size()); ++t) {
    if (shapes[t].empty()) continue;
    const Eigen::Matrix3d block = whitney_block(shapes[t]);
    for (int k = 0; k < 3; ++k)
      for (int l = 0; l < 3; ++l)
        entries.emplace_back(edges.from_half_edge[3 * t + k], edges.from_half_edge[3 * t + l],
                             edges.sign[3 * t + k] * edges.sign[3 * t + l] * block(k, l));
  }
  return sparse_matrix(edges.count(), edges.count(), entries);
}

int massless_rotations(const Edges& edges, const std::vector<FlatTriangle>& shapes) {
  std::vector<std::vector<HalfEdge>> sides(std::size_t(edges.count()));
  for (HalfEdge h = 0; h < HalfEdge(edges.from_half_edge.size()); ++h)
    if (edges.from_half_edge[h] >= 0) sides[edges.from_half_edge[h]].push_back(h);
  std::vector<signed char> turns(shapes.size(), 0);  // which way, 0: not known yet
  int count = 0;
  for (int first = 0; first < int(shapes.size()); ++first) {
    if (shapes[first].empty() || turns[first] != 0) continue;
    std::vector<int> reached{first};
    turns[first] = 1;
    bool agree = true;
    for (std::size_t n = 0; n < reached.size(); ++n)
      for (HalfEdge h = 3 * reached[n]; h < 3 * reached[n] + 3; ++h)
        for (const HalfEdge other : sides[edges.from_half_edge[h]]) {
          if (other / 3 == reached[n]) continue;
          const auto turn = static_cast<signed char>(turns[reached[n]] * edges.sign[h] * edges.sign[other]);
          if (turns[other / 3] == 0) reached.push_back(other / 3), turns[other / 3] = turn;
          agree = agree && turns[other / 3] == turn;
        }
    count += agree;
  }
  return count;
}

Vector2 whitney_value(const Edges& edges, const FlatTriangle& shape, int triangle,
                      const Vector3& barycentric, const Vector& omega) {
  Vector2 value = Vector2::Zero();
  for (int k = 0; k < 3 && !shape.empty(); ++k) {
    const HalfEdge h = 3 * triangle + k;
    value += edges.sign[h] * omega[edges.from_half_edge[h]] * whitney_form(shape, k, barycentric);
  }
  return value;
}

}  // namespace mq

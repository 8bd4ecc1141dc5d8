#include "mq/evolving/detail/extended_chart.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "mq/linear/solver.h"
#include "mq/linear/dense.h"
#include "mq/linear/direct.h"

namespace mq {
namespace {

constexpr int rigid_iterations = 30;
constexpr double most_distorted = 2;
constexpr double thinnest_rest = 1e-4;  // height to length

/// A triangle's gradients of its hats, in a plane of its own, and its area.
struct PatchHats {
  Eigen::Matrix<double, 3, 2> gradients;
  double area = 0;
};

PatchHats hats_of(const HolePatch& patch, const Triangle& t) {
  const Vector3 e = patch.positions[t[1]] - patch.positions[t[0]], f = patch.positions[t[2]] - patch.positions[t[0]];
  const double length = std::max(e.norm(), 1e-300), foot = e.dot(f) / length;
  const double height = std::max(e.cross(f).norm() / length, thinnest_rest * std::max(length, f.norm()));
  PatchHats flat;
  flat.area = length * height / 2;
  flat.gradients.row(1) = Eigen::RowVector2d(1 / length, -foot / (length * height));
  flat.gradients.row(2) = Eigen::RowVector2d(0, 1 / height);
  flat.gradients.row(0) = -flat.gradients.row(1) - flat.gradients.row(2);
  return flat;
}

class Extension {
 public:
  explicit Extension(const HolePatch& patch) : patch_(patch), x_(patch.places), row_of_(patch.positions.size(), -1) {
    for (const Triangle& t : patch.triangles) flat_.push_back(hats_of(patch, t));
    for (std::size_t v = 0; v < row_of_.size(); ++v)
      if (!patch.fixed[v]) row_of_[v] = rows_++;
  }

  /// ½ Σ A |J|² − Σ A det J is least.
  void lie_conformally() {
    if (rows_ == 0) return;
    Entries entries;
    Signal right = Signal::Zero(2 * rows_, 1);
    for (std::size_t t = 0; t < flat_.size(); ++t)
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          const auto& G = flat_[t].gradients;
          const double dot = flat_[t].area * G.row(i).dot(G.row(j));
          const double turn = flat_[t].area * (G(i, 0) * G(j, 1) - G(i, 1) * G(j, 0));
          const Eigen::Matrix2d block{{dot, -turn}, {turn, dot}};
          const int v = patch_.triangles[t][i], w = patch_.triangles[t][j];
          if (row_of_[v] < 0) continue;
          if (row_of_[w] < 0) {
            right.block(2 * row_of_[v], 0, 2, 1) -= block * x_[w];
            continue;
          }
          for (int a = 0; a < 2; ++a)
            for (int b = 0; b < 2; ++b) entries.emplace_back(2 * row_of_[v] + a, 2 * row_of_[w] + b, block(a, b));
        }
    const Signal found = DirectSolver(sparse_matrix(2 * rows_, 2 * rows_, entries)).solve(right);
    for (std::size_t v = 0; v < x_.size(); ++v)
      if (row_of_[v] >= 0) x_[v] = found.block(2 * row_of_[v], 0, 2, 1);
  }

  /// Σ A |J − R|² is lowered over places and rotations in turn.
  void become_rigid(int iterations) {
    if (rows_ == 0) return;
    Entries entries;
    for (std::size_t t = 0; t < flat_.size(); ++t)
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          if (row_of_[patch_.triangles[t][i]] >= 0 && row_of_[patch_.triangles[t][j]] >= 0)
            entries.emplace_back(row_of_[patch_.triangles[t][i]], row_of_[patch_.triangles[t][j]], stiffness(t, i, j));
    const DirectSolver solver(sparse_matrix(rows_, rows_, entries));
    for (int iteration = 0; iteration < iterations; ++iteration) {
      Signal right = Signal::Zero(rows_, 2);
      for (std::size_t t = 0; t < flat_.size(); ++t) {
        const Eigen::Matrix2d J = jacobian(t);
        const double e = J(0, 0) + J(1, 1), h = J(1, 0) - J(0, 1), q = std::hypot(e, h);
        Eigen::Matrix2d R = Eigen::Matrix2d::Identity();
        if (q > 0) R << e / q, -h / q, h / q, e / q;
        for (int i = 0; i < 3; ++i) {
          const int row = row_of_[patch_.triangles[t][i]];
          if (row < 0) continue;
          right.row(row) += flat_[t].area * (R * flat_[t].gradients.row(i).transpose()).transpose();
          for (int j = 0; j < 3; ++j)
            if (const int w = patch_.triangles[t][j]; row_of_[w] < 0) right.row(row) -= stiffness(t, i, j) * x_[w].transpose();
        }
      }
      const Signal found = solver.solve(right);
      for (std::size_t v = 0; v < x_.size(); ++v)
        if (row_of_[v] >= 0) x_[v] = found.row(row_of_[v]).transpose();
    }
  }

  std::vector<char> sound() const {
    std::vector<char> result;
    for (std::size_t t = 0; t < flat_.size(); ++t) {
      const Eigen::Matrix2d J = jacobian(t);
      const Eigen::Vector2d sigma = singular_values(J).values;
      result.push_back(J.determinant() > 0 && sigma[0] < most_distorted && sigma[1] > 1 / most_distorted);
    }
    return result;
  }

  const std::vector<Vector2>& places() const { return x_; }

 private:
  double stiffness(std::size_t t, int i, int j) const {
    return flat_[t].area * flat_[t].gradients.row(i).dot(flat_[t].gradients.row(j));
  }

  Eigen::Matrix2d jacobian(std::size_t t) const {
    Eigen::Matrix2d J = Eigen::Matrix2d::Zero();
    for (int k = 0; k < 3; ++k) J += x_[patch_.triangles[t][k]] * flat_[t].gradients.row(k);
    return J;
  }

  const HolePatch& patch_;
  std::vector<Vector2> x_;
  std::vector<int> row_of_;
  int rows_ = 0;
  std::vector<PatchHats> flat_;
};

}  // namespace

std::optional<ExtendedChart> extended_chart(const HolePatch& patch) {
  if (std::ranges::count(patch.fixed, 1) < 2) return {};
  Extension extension(patch);
  try {
    extension.lie_conformally();
    extension.become_rigid(rigid_iterations);
  } catch (const NotPositiveDefinite&) {
    return {};  // triangles without area, up to rounding
  }
  return ExtendedChart{extension.places(), extension.sound()};
}

}  // namespace mq

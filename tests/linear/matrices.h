#pragma once
/// Small matrices with known answers.

#include <random>
#include <vector>

#include "mq/linear/matrix.h"

namespace mq::test {

/// The 5-point Laplacian of an n × n grid with free borders (constants are its null space), plus
/// `shift` on the diagonal.
inline SparseMatrix grid_laplacian(int n, double shift) {
  std::vector<Eigen::Triplet<double>> entries;
  const auto couple = [&](int i, int j) {
    entries.insert(entries.end(), {{i, i, 1}, {j, j, 1}, {i, j, -1}, {j, i, -1}});
  };
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const int i = y * n + x;
      entries.emplace_back(i, i, shift);
      if (x + 1 < n) couple(i, i + 1);
      if (y + 1 < n) couple(i, i + n);
    }
  SparseMatrix A(n * n, n * n);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

inline SparseMatrix diagonal(const std::vector<double>& values) {
  SparseMatrix A(int(values.size()), int(values.size()));
  for (int i = 0; i < int(values.size()); ++i) A.insert(i, i) = values[i];
  A.makeCompressed();
  return A;
}

/// Uniform in [-1, 1], the same on every machine.
inline Signal random_signal(int rows, int channels, unsigned seed = 1) {
  std::mt19937 generator(seed);
  Signal X(rows, channels);
  for (Eigen::Index i = 0; i < X.size(); ++i)
    X.data()[i] = 2.0 * generator() / double(std::mt19937::max()) - 1;
  return X;
}

}  // namespace mq::test

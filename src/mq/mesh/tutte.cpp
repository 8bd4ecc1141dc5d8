#include "mq/mesh/tutte.h"

#include <cmath>
#include <numbers>
#include <utility>

namespace mq {

std::vector<Vector2> tutte_embedding(int vertex_count, const std::vector<Triangle>& triangles,
                                     const std::vector<int>& loop, double area,
                                     Factorisation kind) {
  const double radius = std::sqrt(area / std::numbers::pi);
  std::vector<Vector2> x(vertex_count, Vector2::Zero());
  std::vector<char> fixed(vertex_count);
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const double angle = 2 * std::numbers::pi * double(i) / double(loop.size());
    x[loop[i]] = radius * Vector2(std::cos(angle), std::sin(angle));
    fixed[loop[i]] = 1;
  }
  if (int(loop.size()) == vertex_count) return x;
  std::vector<int> row(vertex_count, -1);
  int rows = 0;
  for (int v = 0; v < vertex_count; ++v)
    if (!fixed[v]) row[v] = rows++;
  Entries entries;
  Signal right = Signal::Zero(rows, 2);
  for (const Triangle& t : triangles)
    for (int k = 0; k < 3; ++k)
      for (const auto& [a, b] : {std::pair{t[k], t[(k + 1) % 3]}, {t[(k + 1) % 3], t[k]}}) {
        if (row[a] < 0) continue;
        entries.emplace_back(row[a], row[a], 1);
        if (row[b] >= 0)
          entries.emplace_back(row[a], row[b], -1);
        else
          right.row(row[a]) += x[b].transpose();
      }
  const Signal solution = DirectSolver(sparse_matrix(rows, rows, entries), kind).solve(right);
  for (int v = 0; v < vertex_count; ++v)
    if (row[v] >= 0) x[v] = solution.row(row[v]).transpose();
  return x;
}

}  // namespace mq

#include "mq/track/path_lengths.h"

#include <cmath>
#include <limits>
#include <queue>

#include "mq/base/parallel.h"

namespace mq {
namespace {

/// Lengths that get shorter by less than this part are left as they are.
constexpr double least_gain = 1e-9;

struct PathEnd {
  double length;
  int vertex;
  bool operator>(const PathEnd& other) const {
    return length != other.length ? length > other.length : vertex > other.vertex;
  }
};

/// The length at c of a path that has come as far as `at_a` and `at_b`; infinite where it does not
/// cross the edge between them.
double unfolded_length(const Vector3& a, const Vector3& b, const Vector3& c, double at_a,
                       double at_b) {
  constexpr double none = std::numeric_limits<double>::infinity();
  const Vector3 along = b - a;
  const double edge = along.norm();
  if (!(edge > 0)) return none;
  const double from_x = (at_a * at_a - at_b * at_b + edge * edge) / (2 * edge);
  const double squared = at_a * at_a - from_x * from_x;
  if (!(squared > 0)) return none;
  const double from_y = -std::sqrt(squared);
  const double x = (c - a).dot(along) / edge;
  const double y = std::sqrt(std::max(0.0, (c - a).squaredNorm() - x * x));
  const double crossing = from_x + (x - from_x) * -from_y / (y - from_y);
  if (!(crossing >= 0 && crossing <= edge)) return none;
  return std::hypot(x - from_x, y - from_y);
}

}  // namespace

PathLengths::PathLengths(const Mesh& mesh) : mesh_(mesh), begin_(mesh.positions.size() + 1, 0) {
  for (const Triangle& t : mesh.triangles)
    for (const int v : t) ++begin_[v + 1];
  for (std::size_t v = 1; v < begin_.size(); ++v) begin_[v] += begin_[v - 1];
  around_.resize(std::size_t(begin_.back()));
  std::vector<int> at(begin_.begin(), begin_.end() - 1);
  for (int t = 0; t < mesh.triangle_count(); ++t)
    for (const int v : mesh.triangles[t]) around_[at[v]++] = t;
}

std::vector<double> PathLengths::operator()(int from) const {
  std::vector<double> lengths(mesh_.positions.size(), std::numeric_limits<double>::infinity());
  std::priority_queue<PathEnd, std::vector<PathEnd>, std::greater<>> front;
  const auto reach = [&](int vertex, double length) {
    if (!(length < (1 - least_gain) * lengths[vertex])) return;
    lengths[vertex] = length;
    front.push({length, vertex});
  };
  lengths[from] = 0;
  front.push({0, from});
  const std::vector<Vector3>& x = mesh_.positions;
  while (!front.empty()) {
    const auto [length, v] = front.top();
    front.pop();
    if (length > lengths[v]) continue;
    for (const int t : around(v)) {
      const Triangle& corners = mesh_.triangles[t];
      const int k = corners[0] == v ? 0 : corners[1] == v ? 1 : 2;
      const int a = corners[(k + 1) % 3], b = corners[(k + 2) % 3];
      reach(a, length + (x[a] - x[v]).norm());
      reach(b, length + (x[b] - x[v]).norm());
      // What is longer than this may still get shorter; it is looked at again then.
      if (lengths[a] <= length) reach(b, unfolded_length(x[v], x[a], x[b], length, lengths[a]));
      if (lengths[b] <= length) reach(a, unfolded_length(x[v], x[b], x[a], length, lengths[b]));
    }
  }
  return lengths;
}

std::vector<std::vector<double>> PathLengths::operator()(const std::vector<int>& from) const {
  std::vector<std::vector<double>> all(from.size());
  parallel_for(
      std::ssize(from), [&](std::int64_t i) { all[i] = (*this)(from[i]); }, 1);
  return all;
}

}  // namespace mq

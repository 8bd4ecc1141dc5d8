#pragma once
/// Lengths of shortest paths along a surface, coarse and fast: Dijkstra's order, with triangles
/// unfolded into the plane (Novotni, Klein [novotni2002geodesic]).

#include <vector>

#include "mq/mesh/surface.h"

namespace mq {

/// Finds lengths from vertices of one mesh, which must outlive it.
///
/// What a path has come to at two corners of a triangle says where it began, in the plane of the
/// triangle; if the line from there to the third corner crosses the edge between the two, its length
/// is that of the path. So lengths are exact in flat places, and within four
/// percent on a ball of 3,000 triangles; they hardly depend on how the surface is cut into triangles.
class PathLengths {
 public:
  explicit PathLengths(const Mesh& mesh);

  /// Per vertex; infinite where no path leads.
  std::vector<double> operator()(int from) const;
  /// The same from each of several, at the same time.
  std::vector<std::vector<double>> operator()(const std::vector<int>& from) const;

  /// Triangles around a vertex.
  struct Around {
    const int* first;
    const int* last;
    const int* begin() const { return first; }
    const int* end() const { return last; }
  };
  Around around(int vertex) const {
    return {around_.data() + begin_[vertex], around_.data() + begin_[vertex + 1]};
  }

 private:
  const Mesh& mesh_;
  std::vector<int> begin_, around_;  // per vertex its triangles
};

}  // namespace mq

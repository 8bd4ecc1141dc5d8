#include "mq/fem/detail/returning_fields.h"

namespace mq {

ReturningFields::ReturningFields(const Surface& surface, const std::vector<FlatTriangle>& shapes,
                                 const IntrinsicTriangulation& delaunay)
    : surface_(surface),
      delaunay_(delaunay),
      frames_(vertex_frames(delaunay.surface, delaunay.shapes)),
      own_(vertex_frames(surface, shapes)),
      turn_(surface.mesh.positions.size(), 0.0),
      prolongation_(vertex_prolongation(surface, shapes, own_)) {
  for (HalfEdge h = 0; h < HalfEdge(delaunay.directions.size()); ++h)
    if (!delaunay.shapes[h / 3].empty()) turn_[source(h)] = delaunay.directions[h] - frames_.at_source[h];
}

Vector ReturningFields::from_vertices(Vector z) const {
  for (std::size_t v = 0; v < turn_.size(); ++v) {
    const auto i = 2 * Eigen::Index(v);
    z.segment<2>(i) = turned_by(turn_[v], z.segment<2>(i));
  }
  return prolongation_ * z;
}

Vector ReturningFields::from_triangles(const Vector& x) const {
  Vector z = Vector::Zero(2 * Eigen::Index(turn_.size()));
  std::vector<double> area(turn_.size(), 0.0);
  for (HalfEdge h = 0; h < HalfEdge(delaunay_.directions.size()); ++h) {
    const double share = delaunay_.shapes[h / 3].area();
    if (!(share > 0)) continue;
    z.segment<2>(2 * source(h)) += share * turned_by(-frames_.into_triangle[h], x.segment<2>(2 * (h / 3)));
    area[source(h)] += share;
  }
  for (std::size_t v = 0; v < area.size(); ++v)
    if (area[v] > 0) z.segment<2>(2 * Eigen::Index(v)) /= area[v];
  return from_vertices(std::move(z));
}

Vector2 ReturningFields::at_vertex(int corner, const Vector2& v) const {
  const int vertex = surface_.mesh.triangles[corner / 3][corner % 3];
  return turned_by(-turn_[vertex] - own_.into_triangle[corner], v);
}

}  // namespace mq

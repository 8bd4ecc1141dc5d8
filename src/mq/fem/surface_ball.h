#pragma once
/// The texels or vertices around a place as far as a brush reaches: along the surface, and not
/// through the air.

#include <span>
#include <vector>

#include "mq/fem/texel_space.h"
#include "mq/fem/vertex_space.h"
#include "mq/linear/row_set.h"

namespace mq {

/// Texels of a ball that one reaches from its middle over neighbours within it, two texels being
/// neighbours where the stiffness couples them: beside each other in a chart, or across a seam. The
/// other side of an ear is in the ball, and not among them, unless the ball holds the way around
/// its rim.
class SurfaceBall {
 public:
  /// The space must outlive the object. Costs its matrix for a moment, and then a byte and two bits a texel and
  /// what the texels at seams take.
  explicit SurfaceBall(const TexelSpace& space);

  /// The texels nearer than `radius` to `centre`, in space, that are reached from the texels at a
  /// point of a triangle (which must have a chart); increasing. Costs what is found, a few instructions a
  /// texel, as texels side by side are taken together. One call at a time.
  std::vector<int> reach(int triangle, const Vector3& barycentric, const Vector3& centre,
                         double radius);

 private:
  using Span = RowSet::Segment;
  struct Ball {
    Vector3 centre;
    double squared_radius;
  };

  bool has_grid_neighbours(int texel) const;
  bool are_neighbours_in_row(int left) const;
  bool takes(int texel, const Ball& ball);
  void take(int texel, const Ball& ball);
  void take_beside(const Span& span, const Ball& ball);
  void take_in_row(const Span& span, int row, const Ball& ball);
  int at(int row, int x) const;

  const TexelSpace& space_;
  std::vector<int> rows_;       ///< first texel of each row of each texture, and one more
  std::vector<int> first_row_;  ///< of each texture
  std::vector<int> widths_, heights_;
  std::vector<int> seam_texels_, seam_first_,
      seam_neighbours_;         ///< of texels beside others than the grid's
  std::vector<char> on_grid_;   ///< per texel: its neighbours are those of the grid
  RowSet seen_, found_;         ///< empty between calls
  std::vector<Span> ahead_;     ///< found, and nothing beside them looked at yet; empty between calls
};

/// The same of vertices, which are neighbours along edges; those of the point's triangle begin.
/// Nothing is reached where the triangle has no area.
class VertexBall {
 public:
  /// Space and positions must outlive the object.
  VertexBall(const VertexSpace& space, std::span<const Vector3> positions)
      : space_(space), positions_(positions), seen_(positions.size(), 0) {}

  std::vector<int> reach(int triangle, const Vector3& centre, double radius);

 private:
  const VertexSpace& space_;
  std::span<const Vector3> positions_;
  std::vector<int> seen_;  ///< per vertex in which call
  int call_ = 0;
};

}  // namespace mq

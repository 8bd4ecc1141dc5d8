#pragma once
/// Shapes by formula. UVs are in model units unless said otherwise (packing follows).

#include <vector>

#include "mq/mesh/mesh.h"

namespace mq {

struct Shape {
  Mesh mesh;
  std::vector<int> charts;  ///< per triangle
};

/// The cube [-1, 1]³ with n × n cells per face, unfolded to a cross: one chart, isometric.
Shape cube_cross(int n);

/// The unit sphere as a cube blown up: six charts, each the square of two equal angles.
Shape cube_sphere(int n);

/// The torus of radii 1 and r around the y-axis, n × m cells: one chart, the rectangle of both
/// angles. `conformal`: the chart's second coordinate is ∫ r / (1 + r cos v) dv, so that angles are
/// kept; `arc_length`: it is r·v.
enum class TorusMap { arc_length, conformal };
Shape torus(int n, int m, double r, TorusMap map);

/// A torus without curvature, exactly: two regular n-gons one above the other, joined by two belts
/// of triangles, the outer with half an edge of twist and the inner with `twist` edges more. All
/// triangles of a belt are congruent, so three of its angles at each vertex sum to π, both belts to
/// 2π (Brehm 1978; Arnoux, Lelièvre, Málaga, Diplotori, 2021). One chart, isometric. Each triangle
/// is cut into m².
Shape flat_torus(int n, int m, int twist, double height);

/// An open cylinder of radius 1 as a prism of n sides, m cells high: one chart with one seam,
/// isometric.
Shape cylinder(int n, int m, double height);

/// The cap of the unit sphere up to `angle` from its top, n rings of triangles.
/// UVs are the stereographic projection, which keeps angles, scaled to the unit disc.
Shape spherical_cap(int n, double angle);

}  // namespace mq

#pragma once
/// The normals a surface is shaded with.

#include <vector>

#include "mq/mesh/mesh.h"

namespace mq {

/// Unit normals, three per triangle: smooth ones of the vertices, except at corners that turn away
/// from their triangle by more than 40 degrees, which have the triangle's: there creases stay.
std::vector<Eigen::Vector3f> corner_normals(const Mesh& mesh);

}  // namespace mq

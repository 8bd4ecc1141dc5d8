#pragma once
/// The axes in which normal maps in tangent space are written: at the corners of triangles, and
/// between them.
///
/// A texel (x, y, z) of such a map stands for the unit vector
///
///     n = (x T + y B + z N) / |...|,      B = w (N × T),
///
/// where N and T are the shading normal and the tangent of the corners, interpolated linearly over
/// the triangle and not normalised. T points where u grows; w is 1, or −1 where the triangle's
/// texture coordinates are seen from behind; so B points where v grows. That is how MikkTSpace
/// [mikkelsen2008wrinkled] and glTF 2.0 define it, and what bakers and renderers share.

#include <vector>

#include "mq/mesh/surface_point.h"

namespace mq {

/// Three per triangle. N has unit length; T too, at right angles to N, and its fourth number is w.
struct CornerFrames {
  std::vector<Eigen::Vector3f> normals;
  std::vector<Eigen::Vector4f> tangents;
};

/// Frames at all corners. What `given` holds is kept: three per triangle, or none; a vector that is 0
/// or not finite is not known. Given tangents are put at right angles to N and made unit.
///
/// Normals that are not known are those of vertices, as the mesh itself joins corners: Σ angle ·
/// normal (`vertex_normals`), or the triangle's own where they cancel.
///
/// Tangents that are not known are MikkTSpace's: corners of equal position, normal and texture
/// coordinate, in triangles of equal w that are joined by edges of such corners, have one tangent:
///
///     T = Σ angle · P(∂p/∂u) / |P(∂p/∂u)|, normalised,     P: projection to the plane of N;
///
/// angles are those of the projected edges. A corner of a triangle without area in the texture has
/// the tangent of another corner of equal position, normal and texture coordinate, or, if there is none,
/// any at right angles to N; so has one where the sum vanishes.
///
/// O(n log n). Throws `InvalidInput` where the sizes of what is given do not fit.
CornerFrames tangent_frames(const Mesh& mesh, CornerFrames given = {});

/// The normals alone, as there.
std::vector<Eigen::Vector3f> frame_normals(const Mesh& mesh,
                                            std::vector<Eigen::Vector3f> given = {});

/// T, B and N somewhere. Linearly independent, but neither unit nor at right angles.
struct TangentFrame {
  Vector3 tangent, bitangent, normal;

  /// From the map to the model's axes, and back; both unit. The zero vector stands for the undisturbed
  /// normal, (0, 0, 1) or N.
  Vector3 to_model(const Vector3& mapped) const;
  Vector3 to_map(const Vector3& normal_vector) const;
};

/// The frame at a point of a triangle, or a little outside it (weights below 0). Where what is
/// interpolated has no volume, T is replaced by any tangent at right angles to N, and an N that vanishes
/// by that of the nearest corner.
TangentFrame frame_at(const CornerFrames& frames, const SurfacePoint& point);

}  // namespace mq

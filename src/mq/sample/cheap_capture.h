#pragma once
/// What a cheap capture does to a body: its surface is off here and there, has holes, and handles
/// that the body does not have, others in every frame.

#include <cstdint>
#include <vector>

#include "mq/mesh/mesh.h"
#include "mq/sample/implicit.h"

namespace mq {

struct CheapCapture {
  /// Standard deviation of how far vertices are off along their normals, in mean edges: alike within
  /// about four edges, as in depth maps. A quarter as much, of each vertex by itself, in every direction.
  double off = 0;
  int holes = 0;    ///< in every frame, about five edges wide
  int handles = 0;  ///< in every frame at most, rings of six edges half inside of the body

  bool is_clean() const { return off == 0 && holes == 0 && handles == 0; }
};

/// Frames that a hole or a handle is there. In every frame about half of them are new.
inline constexpr int flicker_frames = 2;

/// Moves vertices as `off` says, independently of other frames.
void displace(double off, int frame, std::uint64_t seed, Mesh& mesh);

/// Vertices at which something flickers in a frame, none twice: the nearest ones to `count` places
/// of the material, each of which stays for `flicker_frames`. `material` says where vertices are at
/// rest.
std::vector<int> flickering_vertices(const std::vector<Vector3>& material, int count, int frame,
                                     std::uint64_t seed);

/// Per triangle 1 where it is left by holes of this radius: none of its corners lies in one, and it
/// is not one of several fans at a vertex.
std::vector<char> left_by_holes(const Mesh& mesh, const std::vector<Vector3>& places, double radius);

/// The solid with a ring of this radius at each place, half inside of it, in a plane with the normal.
Solid with_handles(Solid solid, const std::vector<Vector3>& places,
                   const std::vector<Vector3>& normals, double radius);

}  // namespace mq

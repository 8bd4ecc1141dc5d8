#pragma once
/// Meshes compressed by Draco (KHR_draco_mesh_compression, draco 1.5).

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "mq/io/detail/gltf_file.h"

namespace mq {

/// What a stream of Draco holds. Points are the vertices of a primitive.
struct DracoMesh {
  std::vector<double> corners;                     ///< of triangles: points, three each
  std::map<std::uint32_t, GltfValues> attributes;  ///< as stored, by Draco's unique ids
  std::size_t points = 0;
  double step = 0;  ///< of the grid that positions were rounded to; 0: they were not
};

/// Decodes the attributes with these ids. Sizes are compared with the stream before memory is taken.
/// Throws `IoError` naming `place` where it is damaged or has no such attribute, and `Unsupported` for
/// versions before 2.
DracoMesh decode_draco(ByteView stream, const std::set<std::uint32_t>& ids, const std::string& place);

}  // namespace mq

#pragma once
/// Geometry of glTF files compressed on request.

#include <string>
#include <vector>

#include "mq/io/detail/gltf_packer.h"
#include "mq/io/model.h"

namespace mq {

/// Compresses what `primitives` of the file read: their attributes and indices. What is compressed
/// already stays as it is, and so does what the compression cannot hold; the notes say so.
///
/// meshopt (EXT_meshopt_compression): without loss, morph targets too; corners of a triangle may change their turn.
/// Draco (KHR_draco_mesh_compression): vertices and triangles in an order of its own. Positions are
/// rounded to 1/65535 of the largest side of the box around all, texture coordinates to at most
/// 1/65536, normals to 12 bits, tangents to 1/32768; integers are kept, and floats where some are not
/// finite or span more than 16 textures. Vertices that no triangle uses are left out. Meshes with morph
/// targets or with positions as integers stay.
std::vector<std::string> compress_gltf(const GltfFile& file, GltfPacker& packer, Compression compression);

/// A GLB of our own with its geometry compressed. `name` is for messages.
Bytes compressed_glb(Bytes glb, const std::string& name, Compression compression);

}  // namespace mq

#pragma once
/// What a glTF scene says as a mesh, and where in the file each part of it comes from.

#include <Eigen/Core>

#include <vector>

#include "mq/io/detail/gltf.h"
#include "mq/io/detail/gltf_file.h"
#include "mq/mesh/tangent_frames.h"

namespace mq {

/// Vertices of the mesh that come from one pair of accessors through one node.
struct GltfBlock {
  int begin = 0;
  int count = 0;
  std::int64_t positions = 0;                            ///< accessor
  std::int64_t colors = -1;                              ///< accessor; −1: white was filled in
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();  ///< world from accessor
};

/// Triangles of the mesh that come from one primitive through one node.
struct GltfTriangles {
  std::size_t begin = 0;  ///< to the next one's
  int vertices = 0;       ///< the first of its block, and how many there are
  int vertex_count = 0;
  std::int64_t normals = -1, tangents = -1;              ///< accessors; −1: none
  std::int64_t material = -1;                            ///< −1: none
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();  ///< world from accessor
};

struct GltfScene {
  MeshFile file;
  std::vector<GltfBlock> blocks;
  std::vector<GltfTriangles> triangles;
  std::vector<std::int64_t> images;  ///< per texture, unless none has a picture
  std::vector<std::int64_t> other_images;  ///< per picture of the other slots
};

/// A node's transform, from its axes to its parent's. Throws `IoError` beginning with `place`.
Eigen::Matrix4d gltf_node_matrix(const Json& node, const std::string& place);

/// Whether it says that nothing of it and of what lies in it is seen (KHR_node_visibility).
bool gltf_node_is_hidden(const Json& node);

GltfScene read_gltf_scene(const GltfFile& file, const ReadChoice& choice);

/// One mesh alone, seen through a matrix.
GltfScene read_gltf_mesh(const GltfFile& file, std::int64_t mesh, const Eigen::Matrix4d& matrix);

/// Normals and tangents at the corners of the scene's triangles, three per triangle, in the model's
/// axes. Without NORMAL a primitive is shaded flat and its TANGENT does not count, as glTF 2.0 says.
/// Tangents of which nothing is known are 0: there is no TANGENT, or they are skipped.
enum class GltfTangents { skip, read };
CornerFrames gltf_frames(const GltfFile& file, const GltfScene& scene, GltfTangents tangents);

/// The document's files with the differences to the model spliced in; no files where these are too
/// large for that (`write_gltf` then makes them anew).
GltfOutput splice_gltf(const Model& model, const Document& document,
                       const std::vector<GltfPicture>& pictures, const std::string& stem);

}  // namespace mq

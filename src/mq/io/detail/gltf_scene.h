#pragma once
/// What a glTF scene says as a mesh, and where in the file each part of it comes from.

#include <Eigen/Core>

#include <vector>

#include "mq/io/detail/gltf.h"
#include "mq/io/detail/gltf_file.h"

namespace mq {

/// Vertices of the mesh that come from one pair of accessors through one node.
struct GltfBlock {
  int begin = 0;
  int count = 0;
  std::int64_t positions = 0;                            ///< accessor
  std::int64_t colors = -1;                              ///< accessor; −1: white was filled in
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();  ///< world from accessor
};

struct GltfScene {
  MeshFile file;
  std::vector<GltfBlock> blocks;
  std::vector<std::int64_t> images;  ///< per texture, unless none has a picture
  std::vector<std::int64_t> other_images;  ///< per picture of the other slots
};

GltfScene read_gltf_scene(const GltfFile& file, const ReadChoice& choice);

/// The document's files with the differences to the model spliced in; no files where these are too
/// large for that (`write_gltf` then makes them anew).
GltfOutput splice_gltf(const Model& model, const Document& document,
                       const std::vector<GltfPicture>& pictures, const std::string& stem);

}  // namespace mq

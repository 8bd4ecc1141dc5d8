#pragma once
/// glTF 2.0, as JSON with buffers beside it (.gltf) or all in one (.glb).
///
/// Read: every triangle primitive of the default scene, node transforms applied, all sets of texture
/// coordinates (v turned up here), of the pictures of one slot those that their materials name,
/// COLOR_0, accessors normalised or sparse, KHR_texture_transform, KHR_mesh_quantization, meshes
/// compressed by Draco (KHR_draco_mesh_compression) and meshopt (EXT_meshopt_compression). Skins are
/// read in bind pose and morph targets left out, which the notes say.

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "mq/io/document.h"

namespace mq {

/// Names of the files a glTF document's buffers are in.
std::vector<std::string> gltf_parts(const Document& document);

/// What a glTF or GLB document says. A texture is an image, in the order of first use; embedded
/// ones go by their name in the file, or "texture_N". Vertices are those of the file's accessors,
/// once for every node that uses them. `Document::choice` chooses slot and set. Throws `IoError` with
/// the place in the JSON (also where a compressed stream is damaged), `InvalidInput` for a slot or a set
/// that is not there, and `Unsupported` for streams of versions that cannot be read.
MeshFile read_gltf(const Document& document);

/// Whether the document is glTF and requires or uses Draco's or meshopt's compression.
bool is_compressed_gltf(const Document& document);

/// A picture to be written with a model.
struct GltfPicture {
  std::string name;  ///< from the mesh file's folder
  std::string type = "image/png";
  bool changed = false;         ///< against the document's
  std::function<Bytes()> file;  ///< its file, encoded when asked for; empty where it is not known
};

struct GltfOutput {
  std::vector<OutputFile> files;  ///< the mesh file first, then its buffers
  std::vector<bool> embedded;     ///< per picture: it is in the files, or none of them names it
  bool made_anew = false;
  std::vector<std::string> notes = {};
  std::map<std::int64_t, std::size_t> images = {};  ///< of a spliced file: which picture each is
};

/// The files that say `model` as GLB, or glTF with a buffer beside it. `pictures` are those of its
/// textures, then those of its `others`. Where `model.document` is glTF of the same connectivity,
/// its bytes are kept and only positions, colours, embedded pictures and names of others that differ
/// are replaced; positions are floats. In the other of the two containers its JSON is kept, buffers
/// become one, and pictures go into a GLB or beside a glTF. Made anew, a GLB
/// holds its pictures and a glTF names them; triangles are grouped by texture, vertices split where
/// corners differ; all sets of texture coordinates are in it, and of other slots what `material_pictures`
/// says. Throws `Unsupported` where that of the textures is none of glTF's own.
GltfOutput write_gltf(const Model& model, Document::Format format,
                      const std::vector<GltfPicture>& pictures, const std::string& stem);

}  // namespace mq

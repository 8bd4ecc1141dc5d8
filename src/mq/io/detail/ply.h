#pragma once
/// PLY, the Stanford polygon format: a header that declares elements and their properties, then
/// their values as text or binary in either byte order.
///
/// Read: of `vertex` x, y, z, colours (red, green, blue, alpha of any size) and texture coordinates
/// (s t, u v, texture_u texture_v, ...); of `face` vertex_indices (or vertex_index), texcoord (further
/// sets texcoord1, ...) and texnumber; `comment TextureFile`, which names base colours. Other elements and properties are passed over and kept.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mq/io/document.h"

namespace mq {

enum class PlyType : char { i8, u8, i16, u16, i32, u32, f32, f64 };

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::f32;
  std::optional<PlyType> count_type;  ///< of a list; none: a single value
};

struct PlyElement {
  std::string name;
  std::int64_t count = 0;
  std::vector<PlyProperty> properties;
  std::size_t header_end = 0;  ///< after the line of its last property
};

struct PlyHeader {
  enum class Encoding { text, little_endian, big_endian } encoding = Encoding::text;
  std::vector<PlyElement> elements;
  std::vector<TextureSlot> textures;  ///< of the comments TextureFile
  std::string line_end = "\n";
  std::size_t last_line = 0;  ///< where "end_header" begins
  std::size_t body = 0;       ///< where the values begin
};

/// Reads the header; `name` is for messages. Throws `IoError` with the line where it is not PLY,
/// declares what is not known, or more elements than the bytes behind it can hold.
PlyHeader parse_ply_header(ByteView bytes, const std::string& name);

/// A PLY file as a mesh, and its faces' corners in the order of the file.
struct PlyFile {
  MeshFile file;
  std::vector<int> corner_uvs;  ///< per corner of each face its entry of the mesh's uvs, or −1
  std::vector<Vector3> normals = {};  ///< of vertices, where they are asked for and there
};

/// Whether normals are read.
enum class PlyNormals { skip, read };
PlyFile parse_ply(const Document& document, PlyNormals normals = PlyNormals::skip);

/// What a PLY document says. Where it has several sets of texture coordinates (those of corners come
/// before those of vertices), `Document::choice` chooses. Throws `IoError` as above, with the element where a value is none, an
/// index is out of range, a coordinate is not finite, the file ends too early, or triangles come
/// as strips.
MeshFile read_ply(const Document& document);

/// The file that says `model` as PLY, with `pictures` named in comments. Where `model.document` is
/// a PLY file of the same connectivity, its bytes are kept and only positions, texture coordinates,
/// colours and names of pictures that differ are replaced, in the types the file has; colours are
/// added where it has none. Made anew, it is binary, with texture coordinates per corner, those of the
/// textures first and the other sets after them; coordinates that floats cannot hold are doubles.
/// Throws `Unsupported` for pictures of another slot than the base colour, of which PLY has no word.
OutputFile write_ply(const Model& model, const std::vector<std::string>& pictures,
                     const std::string& stem);

}  // namespace mq

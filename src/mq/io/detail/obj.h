#pragma once
/// Wavefront OBJ: polygons with texture coordinates and materials per face, as lines of text.
///
/// Read: `v` (with colours), `vt`, `f` (any polygon, `v//n`, negative indices), `usemtl`, `mtllib`;
/// continued lines; normals where asked. Kept where it is, but not used: groups, lines, points, everything
/// else.

#include <string>
#include <vector>

#include "mq/io/document.h"

namespace mq {

/// The lines of an OBJ file, before its materials are looked up.
struct ObjFile {
  /// A line `mtllib`: what it names, which may be one name with blanks or several without.
  struct Library {
    std::string names;
    Place place;
  };

  Mesh mesh;            ///< its `textures` count `materials`; −1: before any usemtl
  VertexSignal colors;  ///< 3 or 4 channels where every `v` has them
  std::vector<std::string> materials;  ///< in the order of their first triangle
  std::vector<Library> libraries;
  std::vector<std::size_t> vertices;  ///< where the numbers of each `v` begin
  std::vector<std::size_t> uvs;       ///< and of each `vt`
  std::vector<Vector3> normals;          ///< of each `vn`; where they are asked for
  std::vector<Triangle> corner_normals;  ///< per triangle; −1: none, or one that is not there
  std::vector<std::string> notes;
  Defects defects;  ///< "maybe_cut_short": a last line without an end, or vertices whose faces lack
};

/// Whether normals are read.
enum class ObjNormals { skip, read };

/// Reads the lines of an OBJ file; `name` is for messages. Throws `IoError` with the line where it
/// is not OBJ, a number or an index is none or out of range, a coordinate is not finite, a polygon
/// has more than `max_polygon` corners.
ObjFile parse_obj(ByteView bytes, const std::string& name, ObjNormals normals = ObjNormals::skip);

/// The lines `mtllib` alone, as `parse_obj` has them, in a small part of its time.
std::vector<ObjFile::Library> obj_libraries(ByteView bytes);

/// What an OBJ document says, its libraries being among its parts: a picture that several materials
/// name for the slot that is read (`chosen_slot`) is one texture, in the order of first use; a material
/// without one is texture −1, unless none has one: then each material is a texture without a name.
/// Options -s and -o of the slot's keyword are applied to the texture coordinates. Throws
/// `InvalidInput` where the slot is not there.
MeshFile read_obj(const Document& document);

struct ObjOutput {
  std::vector<OutputFile> files;
  bool made_anew = false;
};

/// The files that say `model` as OBJ: the mesh file first, then material libraries. `pictures` are the
/// names of its textures, then of its `others`, from the mesh file's folder; `stem` names the mesh file
/// and what is new.
/// Where `model.document` is an OBJ file of the same connectivity, its bytes are kept and only
/// positions, texture coordinates, colours and names of pictures that differ are replaced; a
/// library that changes is given the name STEM.mtl. Made anew, it names the textures alone. Throws
/// `Unsupported` where it would be and MTL has no keyword for their slot.
ObjOutput write_obj(const Model& model, const std::vector<std::string>& pictures,
                    const std::string& stem);

}  // namespace mq

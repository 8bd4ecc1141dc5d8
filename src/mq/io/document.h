#pragma once
/// What a mesh file says, before its pictures are looked for, and the bytes that said it.
///
/// A document keeps the bytes of the mesh file and of those it is made of (material libraries,
/// buffers). What it says is read from them again when a model is to be written: comparing tells
/// what was changed, and only that is spliced into the bytes.

#include <optional>
#include <string>
#include <vector>

#include "mq/image/wrap.h"
#include "mq/io/bytes.h"
#include "mq/io/model.h"

namespace mq {

/// A file that a mesh file is made of, by the name that finds it from the mesh file's folder.
struct Part {
  std::string name;
  Bytes bytes;
};

/// What of a document is read as its textures.
struct ReadChoice {
  std::string slot = {};  ///< as `slot_from_text` gives it; empty: the base colour, or the only one
  int uv_set = -1;        ///< −1: that of the material
};

/// The mesh file and its parts.
class Document {
 public:
  enum class Format { obj, ply, gltf, glb };

  Format format = Format::obj;
  std::string name;  ///< of the mesh file, for messages
  Bytes bytes;
  std::vector<Part> parts;  ///< those that were found
  std::vector<std::filesystem::path> files;  ///< the mesh file's and, in their order, the parts'
  ReadChoice choice = {};

  /// In either container.
  bool is_gltf() const { return format == Format::gltf || format == Format::glb; }
};

/// Where a document says the name of a texture: bytes of a part, or of the mesh file (part −1).
struct Place {
  int part = -1;
  std::size_t begin = 0;
  std::size_t end = 0;
  std::string before;  ///< to be written before a name where there was none
};

/// A texture that triangles of a document use.
struct TextureSlot {
  std::string name;  ///< from the mesh file's folder, with '/'; empty: no picture is named
  Wrap wrap = Wrap::unspecified;
  std::vector<Place> places;  ///< of its name
  Bytes picture;              ///< the picture's file, where it is embedded
};

/// What a document says.
struct MeshFile {
  Mesh mesh;
  VertexSignal colors;
  std::vector<TextureSlot> textures;  ///< what `mesh.textures` counts
  std::vector<std::string> notes;
  Defects defects = {};  ///< signs that the file was cut short
  std::vector<MaterialSlot> slots = {};
  std::string slot = {};                 ///< that `textures` are of
  std::vector<TextureSlot> others = {};  ///< pictures of the other slots that no texture shares
  std::vector<UvSet> uv_sets = {};       ///< all, where there are several
};

/// What a document says; the reader of its format is chosen here.
MeshFile read_document(const Document& document);

/// A file to be written, by its name from the mesh file's folder.
using OutputFile = Part;

/// `name` as this machine spells it: '/' between folders, no "./" in front.
std::string portable_name(std::string_view name);

/// Whether a name stays in the folder it is joined to: relative, without "..".
bool stays_below(const std::string& name);

/// Whether two meshes differ in nothing but positions and texture coordinates' values.
bool same_connectivity(const Mesh& a, const Mesh& b);

/// The name each slot of a document gets for `pictures` (a name per texture of the model, then names
/// of `others`, which are not looked at) to be the model's textures; a slot without a picture keeps an
/// empty name, one of tiles gets a pattern. Nothing where the model's triangles have other textures
/// than the document can name without being made anew.
std::optional<std::vector<std::string>> slot_names(const MeshFile& document, const Model& model,
                                                   const std::vector<std::string>& pictures);

/// Throws `InvalidInput` where a file has no set of texture coordinates of that number.
void require_uv_set(int set, int count, const std::string& file);

/// Which of the model's sets of texture coordinates the mesh has; −1: none of them as it is, since
/// pictures use several.
int own_uv_set(const Model& model);

/// The sets that a file made anew has beside the mesh's own, in their order. None where the mesh has
/// other triangles by now.
std::vector<const UvSet*> other_uv_sets(const Model& model);

/// A colour of an integer type as stored, from its value: rounded, kept in range.
unsigned stored_color(float value, unsigned largest);

/// The colour of a vertex as red, green, blue (and alpha where `channels` is 4): grey is spread.
/// Throws `Unsupported` for other than 1, 3 or 4 channels.
int color_channels(const VertexSignal& colors);
float color(const VertexSignal& colors, int vertex, int channel);

}  // namespace mq

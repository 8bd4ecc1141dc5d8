#pragma once
/// A textured model as a file holds it: the mesh, its pictures, and what is needed to give back
/// exactly what was read where nothing was asked to change.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "mq/base/defect.h"
#include "mq/base/progress.h"
#include "mq/image/image.h"
#include "mq/image/wrap.h"
#include "mq/mesh/mesh.h"
#include "mq/mesh/tangent_frames.h"

namespace mq {

/// How a picture's values are stored in its file.
enum class Depth { u8, u16, half, f32 };

/// The layers of an OpenEXR file of several, of which a picture is one (image_file.h).
struct PictureLayers {
  std::vector<std::string> names;  ///< of all, in the file's order
  std::size_t chosen = 0;          ///< the picture's
  std::shared_ptr<const std::vector<std::byte>> file;  ///< from which the others are written again
};

/// Everything about a picture file that its pixels do not say, so that writing gives back what was
/// read: depth, channel names, colour space and resolution tags.
struct PixelFormat {
  Depth depth = Depth::u8;
  std::string file_format;           ///< "png", "jpeg", "tiff", "openexr", ...
  std::shared_ptr<const void> tags;  ///< metadata of the reader; only io looks inside
  std::shared_ptr<const PictureLayers> layers = {};  ///< null where the file has one
};

/// What a picture was when it was read: fingerprints of its pixels with their depth, and of the bytes
/// they were decoded from. A picture that still has the first is written as the second, byte for byte.
struct AsRead {
  std::uint64_t pixels = 0;  ///< 0: not read from a file
  std::uint64_t bytes = 0;
};

/// What the values of a picture are, as its slot says (slots.h).
enum class TextureMeaning {
  colours,  ///< display values or light, as the file says
  values,   ///< numbers as they are: roughness, occlusion
  normals   ///< unit vectors, coded as colours
};

struct Texture {
  std::string name;            ///< as the model calls it, for messages and output names
  std::filesystem::path path;  ///< where it was read from; empty when embedded
  Image<float> pixels;         ///< row 0 on top; integers divided by their largest value
  PixelFormat format;
  Wrap wrap = Wrap::unspecified;
  std::vector<std::string> notes;  ///< what the reader coped with, in words, for the report
  AsRead as_read = {};             ///< set by the reader
  TextureMeaning meaning = TextureMeaning::colours;
};

/// Values at vertices (colours of a PLY, or "v x y z r g b" of an OBJ), 0 to 1 when stored as
/// integers.
struct VertexSignal {
  int channels = 0;           ///< 0: the model has none
  std::vector<float> values;  ///< channels per vertex, a vertex's values adjacent
  Depth depth = Depth::u8;
  bool is_light = false;      ///< as in glTF; else display values, as in all other formats
};

/// A slot of a model's materials: what pictures are for, and those it names.
struct MaterialSlot {
  struct Use {
    std::string picture;  ///< its name in the model
    int uv_set = 0;
    bool operator==(const Use&) const = default;
  };
  static constexpr int none = -1, the_texture = -2;

  std::string name;  ///< "base-colour", "normal", ... (slots.h)
  std::vector<Use> pictures;
  /// For files made anew, per texture of the model: the one of `Model::others` that materials with that
  /// texture have here, looked up with the same texture coordinates; `the_texture`: one picture for
  /// both; `none`: they have none, or not all the same. Empty: not known.
  std::vector<int> with_texture = {};
};

/// A set of texture coordinates, as `Mesh` holds one.
struct UvSet {
  std::vector<Vector2> uvs;
  std::vector<Triangle> corner_uvs;
};

/// A texture that is one tile of a picture of the file: the square of texture coordinates from (u, v)
/// to (u + 1, v + 1).
struct TextureTile {
  int picture = 0;  ///< of the file's pictures
  int u = 0;
  int v = 0;
};

/// How a model is shaded whose file is forgotten (`forget_file`), or that is made of others.
struct ModelShading {
  CornerFrames corners;  ///< three per triangle or none; 0: not known
  bool is_said = true;   ///< by a file; false: glTF shades flat what says nothing
};

/// The file a model came from, kept so that writing changes only what was asked to change.
class Document;

/// What materials say beside pictures (materials.h).
struct ModelMaterials;

/// How geometry is compressed in a glTF file that is written.
enum class Compression {
  none,     ///< as it is in the file that was read; not at all in one made anew
  meshopt,  ///< EXT_meshopt_compression, without loss
  draco     ///< KHR_draco_mesh_compression, rounded (io/detail/gltf_compress.h)
};

struct Model {
  std::filesystem::path path;
  Mesh mesh;                      ///< n-gons cut into triangles, node transforms applied
  std::vector<Texture> textures;  ///< what `mesh.textures` counts
  VertexSignal colors;
  std::vector<std::string> notes;  ///< what the reader coped with, in words, for the report
  Defects defects;                 ///< of the file: signs that it was cut short
  std::shared_ptr<const Document> document;  ///< null for a model made in memory
  std::shared_ptr<const ModelShading> shading;  ///< where there is no document; null: not known
  std::shared_ptr<const ModelMaterials> materials;  ///< likewise (`file_materials`)

  std::vector<MaterialSlot> slots;  ///< that its materials name pictures for
  std::string slot;                 ///< which of them `textures` are; empty: it has no slots
  /// Pictures of its other slots, without pixels; then the tiles of those that are patterns. Written,
  /// they come back byte for byte; one that has got pixels is written with these.
  std::vector<Texture> others;
  std::vector<UvSet> uv_sets;      ///< all of them as in the file, where there are several
  int uv_set = -1;                 ///< which of them `mesh` has; −1: each picture its own, or set 0
  std::vector<TextureTile> tiles;  ///< per texture, where some are tiles of one picture of the file
  Compression compression = Compression::none;  ///< of the glTF file that it is written to
};

/// How many sets of texture coordinates a model has.
inline int uv_set_count(const Model& model) {
  if (!model.uv_sets.empty()) return int(model.uv_sets.size());
  return model.mesh.has_uvs() ? 1 : 0;
}

/// What becomes of values in pictures that are infinite or no numbers.
enum class NotFinite {
  refuse,  ///< the picture is refused
  keep     ///< they are given as they are: who reads them must look
};

struct ReadModelOptions {
  /// Pictures to use instead of those the model names, in the order of its textures. One picture
  /// for a model that names none (or several slots without files) paints the whole mesh. Tiles of
  /// one picture count as one, whether named by a pattern (tiles.h) or each by its file.
  std::vector<std::filesystem::path> textures;
  /// Whether pictures are read: all; those that are there, with a note on what is not, for who needs the shape
  /// alone; or none.
  enum class Pictures { read, where_there, skip } pictures = Pictures::read;
  NotFinite not_finite = NotFinite::refuse;
  /// The slot whose pictures are read (`slot_from_text`). Empty: that of the pictures given, where
  /// these are files that the model names for one slot; else the base colour, or the only slot.
  std::string slot = {};
  int uv_set = -1;  ///< for all pictures; −1: to each the set that its material names
  std::string layer = {};  ///< of all pictures, which must have it; empty: the colour layer of each
};

/// Reads OBJ (with MTL), PLY, glTF or GLB; content goes before extension. Pictures and material
/// libraries are looked for where they are named, then beside the mesh.
/// A picture whose name says tiles (tiles.h) is read as a texture for each tile that triangles use.
/// Throws `IoError` naming the file, the place and the remedy, `InvalidInput` for a slot or a set that
/// is not there and another number of pictures than of textures, `Unsupported` for what a format has and
/// cannot be read (a later version of a compression).
Model read_model(const std::filesystem::path& path, const ReadModelOptions& options = {},
                 const Progress& progress = {});

/// Writes a model in the format of `path`'s extension. In the format it was read from, everything
/// but positions, colours and pictures comes back byte for byte where the format allows it; from
/// glTF to GLB and back, all that the JSON says does.
/// Written under a temporary name and renamed. Pictures are written beside the mesh under the
/// names the model gives them (embedded ones are embedded again); those whose pixels are as they
/// were read, or were not read, are copied. A file made anew has normals where the one that was
/// read had, or where it names a normal map (`frames_to_write`). A changed picture never replaces
/// the file it was read from unless the mesh file replaces its own too: give it another
/// `Texture::name` first. Colours at vertices become what the format holds, light (glTF) or display values;
/// light of 8 bits of these has 16. Returns what a user may want to know, as `write_texture` does. Throws
/// `IoError`, and `InvalidInput` where indices of the model are out of range, or a format other than
/// glTF is to be compressed.
std::vector<std::string> write_model(const std::filesystem::path& path, const Model& model,
                                     const Progress& progress = {});

/// Reads one picture (image_file.h says what is kept), or the layer of that name of it. Throws `IoError`
/// naming the file, what was found and what to do, and `InvalidInput` where the layer is not there.
Texture read_texture(const std::filesystem::path& path, const Progress& progress = {},
                     NotFinite not_finite = NotFinite::refuse, const std::string& layer = {});

/// Writes one picture in the format of the extension, with the depth of `texture.format` where that
/// format can hold it. A picture that is as it was read is copied, byte for byte. Written under a
/// temporary name and renamed. Returns what a user may want to
/// know: a depth that could not be kept, values clamped, texels encoded with loss.
std::vector<std::string> write_texture(const std::filesystem::path& path, const Texture& texture,
                                       const Progress& progress = {});

/// Whether a picture's values are light: floating point, and integers whose file says so (a PNG
/// with a gamma of 1). Others are display values.
bool holds_light(const PixelFormat& format);

/// The same for pixels made here.
std::vector<std::string> write_image(const std::filesystem::path& path, const Image<float>& pixels,
                                     Depth depth = Depth::u8);

}  // namespace mq

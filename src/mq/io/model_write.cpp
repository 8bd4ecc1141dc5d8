// Everything is made in memory first; then pictures and parts are written, the mesh file last, so
// that what names a file is never there without it.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "mq/base/error.h"
#include "mq/io/atomic_file.h"
#include "mq/io/document.h"
#include "mq/io/detail/fingerprint.h"
#include "mq/io/detail/gltf.h"
#include "mq/io/detail/held.h"
#include "mq/io/file_names.h"
#include "mq/io/image_file.h"
#include "mq/io/materials.h"
#include "mq/io/detail/obj.h"
#include "mq/io/detail/ply.h"
#include "mq/io/slots.h"
#include "mq/io/tiles.h"
#include "mq/io/vertex_colours.h"

namespace mq {
namespace {

namespace fs = std::filesystem;

// ---- Is it a model ----

void check_corners(const std::vector<Triangle>& corners, int least, int count, const char* what) {
  for (std::size_t t = 0; t < corners.size(); ++t)
    for (const int id : corners[t])
      if (id < least || id >= count)
        throw InvalidInput(
            fmt::format("triangle {} uses {} {}, but there are {}", t, what, id, count));
}

void check(const Model& model) {
  const Mesh& mesh = model.mesh;
  check_corners(mesh.triangles, 0, mesh.vertex_count(), "vertex");
  check_corners(mesh.corner_uvs, -1, int(mesh.uvs.size()), "texture coordinate");
  require(!mesh.has_uvs() || mesh.corner_uvs.size() == mesh.triangles.size(),
          "the model has texture coordinates for another number of triangles");
  require(mesh.textures.empty() || mesh.textures.size() == mesh.triangles.size(),
          "the model has textures for another number of triangles");
  for (const int texture : mesh.textures)
    if (texture < -1 || (texture >= int(model.textures.size()) && !model.textures.empty()))
      throw InvalidInput(fmt::format("a triangle uses texture {}, but there are {}", texture,
                                     model.textures.size()));
  require(model.colors.values.size() == std::size_t(model.colors.channels) * mesh.positions.size(),
          "the model has colours for another number of vertices");
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    if (!mesh.positions[v].allFinite())
      throw InvalidInput(fmt::format("vertex {} is not finite", v));
}

// ---- Pictures ----

constexpr std::pair<const char*, const char*> picture_extensions[] = {
    {".png", "png"},   {".jpg", "jpeg"},    {".jpeg", "jpeg"}, {".tif", "tiff"},
    {".tiff", "tiff"}, {".exr", "openexr"}, {".bmp", "bmp"},   {".tga", "targa"},
    {".webp", "webp"}};

/// The picture format that the extension names; empty: none.
std::string picture_format(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? char(c + 32) : c;
  for (const auto& [known, format] : picture_extensions)
    if (extension == known) return format;
  return "";
}

std::string extension_of(const std::string& format) {
  for (const auto& [extension, known] : picture_extensions)
    if (format == known) return extension;
  return ".png";
}

bool same_file(const fs::path& a, const fs::path& b) {
  std::error_code ignored;
  return fs::equivalent(a, b, ignored) && !ignored;
}

class ModelWriter {
 public:
  ModelWriter(const fs::path& path, const Model& model, const Progress& progress)
      : path_(path), model_(model), progress_(progress), folder_(path.parent_path()) {
    check(model);
    for (const Texture& texture : model.textures) pictures_.push_back(&texture);
    for (const Texture& texture : model.others) pictures_.push_back(&texture);
    if (model.document) find_sources(read_document(*model.document));
  }

  std::vector<std::string> write() {
    for (std::size_t t = 0; t < pictures_.size(); ++t) prepare_picture(t);
    std::vector<OutputFile> files = mesh_files();
    files[0].name = path_.filename().string();
    note_what_stays_behind();
    for (std::size_t t = 0; t < pictures_.size(); ++t)
      if (!embedded_[t]) check_source(t);
    for (std::size_t t = 0; t < pictures_.size(); ++t)
      if (!embedded_[t]) write_picture(t);
    for (std::size_t i = files.size(); i-- > 0;) write_part(files[i]);
    progress_.at(1);
    return std::move(notes_);
  }

 private:
  /// What each picture's file was, where it is embedded in the document.
  void find_sources(const MeshFile& file) {
    before_.resize(pictures_.size());
    const std::size_t textures = model_.textures.size();
    if (model_.tiles.empty() && file.textures.size() == textures)
      for (std::size_t t = 0; t < textures; ++t) before_[t] = file.textures[t].picture;
    if (!model_.tiles.empty() && model_.tiles.size() == textures)
      for (std::size_t t = 0; t < textures; ++t)
        if (const auto picture = std::size_t(model_.tiles[t].picture); picture < file.textures.size())
          before_[t] = file.textures[picture].picture;
    if (file.others.size() <= model_.others.size())
      for (std::size_t i = 0; i < file.others.size(); ++i)
        before_[textures + i] = file.others[i].picture;
  }

  void note_what_stays_behind() {
    const std::vector<std::string> slots = slots_left_out(model_, path_);
    if (made_anew_ && !slots.empty())
      notes_.push_back(fmt::format("{} is made anew: not all pictures for {} are in it",
                                   path_.string(), fmt::join(slots, ", ")));
    if (!made_anew_) return;
    if (const std::string left_out = materials_left_out(file_materials(model_), path_); !left_out.empty())
      notes_.push_back(fmt::format("{} is made anew: of its materials it does not say {}", path_.string(),
                                   left_out));
  }

  /// Pictures beside a file made anew: those that its materials name.
  void leave_out_unnamed() {
    made_anew_ = true;
    embedded_.clear();
    for (const char is_named : named_pictures(model_, path_)) embedded_.push_back(!is_named);
  }

  std::vector<OutputFile> mesh_files() {
    const std::string stem = path_.stem().string();
    std::string extension = path_.extension().string();
    for (char& c : extension) c = c >= 'A' && c <= 'Z' ? char(c + 32) : c;
    if (model_.compression != Compression::none && extension != ".gltf" && extension != ".glb")
      throw InvalidInput(fmt::format("{}: only .gltf and .glb can be compressed", path_.string()));
    if (extension == ".obj") {
      ObjOutput output = write_obj(model_, names_, stem);
      if (output.made_anew) leave_out_unnamed();
      return std::move(output.files);
    }
    if (extension == ".ply") {
      leave_out_unnamed();
      return {write_ply(model_, names_, stem)};
    }
    if (extension == ".gltf") return gltf_files(Document::Format::gltf, stem);
    if (extension == ".glb") return gltf_files(Document::Format::glb, stem);
    throw IoError(fmt::format("cannot write {}: its extension is none of .obj, .ply, .gltf, .glb",
                              path_.string()));
  }

  std::vector<OutputFile> gltf_files(Document::Format format, const std::string& stem) {
    std::vector<GltfPicture> pictures;
    for (std::size_t t = 0; t < pictures_.size(); ++t) {
      const std::string kind = embedded_format(t);
      pictures.push_back({names_[t], "image/" + kind, changed_[t] != 0,
                          [this, t, kind] { return embedded_picture(t, kind); }});
    }
    GltfOutput output = write_gltf(model_, format, pictures, stem);
    embedded_ = output.embedded;
    made_anew_ = output.made_anew;
    notes_.insert(notes_.end(), output.notes.begin(), output.notes.end());
    return std::move(output.files);
  }

  static bool is_webp(ByteView file) {
    return text_of(file).starts_with("RIFF") && text_of(file).substr(0, 12).ends_with("WEBP");
  }

  /// "jpeg", "png" or "webp": in which of glTF's formats a picture is embedded. WebP takes an extension,
  /// which the place of a picture that is embedded in the document has or has not.
  std::string embedded_format(std::size_t t) const {
    const std::string& own = pictures_[t]->format.file_format;
    const bool embedded = t < before_.size() && !before_[t].empty();
    if (embedded ? is_webp(before_[t]) : own == "webp" || is_webp(copies_[t])) return "webp";
    return own == "jpeg" || text_of(copies_[t]).starts_with("\xff\xd8") ? "jpeg" : "png";
  }

  /// The file of a picture as glTF may hold it; nothing where it is not known.
  Bytes embedded_picture(std::size_t t, const std::string& format) {
    const std::string_view text = text_of(copies_[t]);
    if (text.starts_with("\xff\xd8") || text.starts_with("\x89PNG") ||
        (format == "webp" && is_webp(copies_[t])))
      return copies_[t];
    if (pictures_[t]->pixels.empty()) return {};
    EncodedPicture picture = texture_bytes(*pictures_[t], format);
    for (const std::string& note : picture.notes)
      notes_.push_back(fmt::format("{}: its picture {}", path_.string(), note));
    return std::move(picture.bytes);
  }

  /// The file a picture was read from, or nothing.
  Bytes source(std::size_t t) const {
    const Texture& texture = *pictures_[t];
    std::error_code ignored;
    if (!texture.path.empty())
      return fs::is_regular_file(texture.path, ignored) ? read_file(texture.path) : Bytes();
    return t < before_.size() ? before_[t] : Bytes();
  }

  /// Whether pixels and depth are those of the source.
  bool unchanged(const Texture& texture, const Bytes& source) const {
    return texture.pixels.empty() || (!source.empty() && is_as_read(texture, source));
  }

  /// A name that a file beside the mesh can have, and that no other picture has.
  std::string output_name(std::size_t t, bool keeps_pixels) {
    const Texture& texture = *pictures_[t];
    std::string name = texture.name;
    for (char& c : name) c = (c & 0xe0) == 0 || c == 0x7f ? '_' : c;
    const bool in_place = keeps_pixels && !name.empty() && same_file(folder_ / name, texture.path);
    if (!in_place && !stays_below(name)) name = fs::path(name).filename().string();
    if (name.empty()) name = t == 0 ? "texture" : fmt::format("texture_{}", t);
    if (!in_place && picture_format(name).empty()) name += extension_of(texture.format.file_format);
    const fs::path path(name);
    for (int i = 1; !is_free(name, t, keeps_pixels); ++i)
      name = (path.parent_path() /
              fmt::format("{}_{}{}", path.stem().string(), i, path.extension().string()))
                 .string();
    return name;
  }

  /// Takes a name unless another picture has it; unchanged pictures of one file share theirs.
  bool is_free(const std::string& name, std::size_t t, bool keeps_pixels) {
    const auto taken = names_taken_.try_emplace(name, t);
    const std::size_t other = taken.first->second;
    return taken.second || (keeps_pixels && !changed_[other] && !pictures_[t]->path.empty() &&
                            pictures_[other]->path == pictures_[t]->path);
  }

  void prepare_picture(std::size_t t) {
    const Texture& texture = *pictures_[t];
    Bytes bytes = source(t);
    const bool keeps_pixels = unchanged(texture, bytes);
    const bool unknown = t >= model_.textures.size() && bytes.empty() && texture.pixels.empty();
    const std::string name = unknown ? texture.name : output_name(t, keeps_pixels);
    const bool same_format =
        texture.pixels.empty() || picture_format(name) == texture.format.file_format;
    names_.push_back(name);
    changed_.push_back(!keeps_pixels);
    embedded_.push_back(false);
    copies_.push_back(keeps_pixels && same_format ? std::move(bytes) : Bytes());
  }

  void check_source(std::size_t t) const {
    const fs::path& source = pictures_[t]->path;
    if (changed_[t] && same_file(folder_ / names_[t], source) && !same_file(path_, model_.path))
      throw IoError(
          fmt::format("writing {} would replace the picture {} that it was made from; "
                      "give the new picture another name, or write to another folder",
                      path_.string(), source.string()));
  }

  void write_picture(std::size_t t) {
    const Texture& texture = *pictures_[t];
    const fs::path path = folder_ / names_[t];
    if (!copies_[t].empty()) {
      if (same_file(path, texture.path)) return;
      make_folder(path);
      return write_file(path, copies_[t]);
    }
    if (texture.pixels.empty()) {
      std::error_code ignored;
      const auto tile = tile_name(names_[t]);
      if (!fs::exists(path, ignored) && (!tile || tile->place))
        notes_.push_back(
            fmt::format("the picture {} is not there and was not written", path.string()));
      return;
    }
    make_folder(path);
    const auto notes = write_encoded(
        path, texture, progress_.step("write picture", 0.8 / double(pictures_.size())));
    notes_.insert(notes_.end(), notes.begin(), notes.end());
  }

  /// The folders between the mesh file's and a file that it names.
  void make_folder(const fs::path& path) const {
    std::error_code error;
    if (path.parent_path() != folder_) fs::create_directories(path.parent_path(), error);
  }

  void write_part(const OutputFile& file) {
    const fs::path path = folder_ / file.name;
    if (!stays_below(file.name)) {
      std::error_code ignored;
      if (!fs::exists(path, ignored))
        notes_.push_back(
            fmt::format("{} names {}, which is not there", path_.string(), shown(file.name)));
      return;
    }
    make_folder(path);
    write_file(path, file.bytes);
  }

  const fs::path& path_;
  const Model& model_;
  const Progress& progress_;
  fs::path folder_;
  std::vector<const Texture*> pictures_;  ///< textures, then others
  std::vector<Bytes> before_;             ///< the files of those embedded in the document
  std::vector<std::string> names_;  ///< of the pictures, from the folder
  std::map<std::string, std::size_t> names_taken_;
  std::vector<Bytes> copies_;   ///< of the pictures that are copied
  std::vector<char> changed_;   ///< whether a picture's pixels are not its source's
  std::vector<bool> embedded_;  ///< whether it is in the mesh file, or not named by it
  bool made_anew_ = false;
  std::vector<std::string> notes_;
};

}  // namespace

std::vector<std::string> write_model(const fs::path& path, const Model& model,
                                     const Progress& progress) {
  if (hold_model(path, model)) return {};
  if (model.colors.channels == 0 || model.colors.is_light == names_gltf(path))
    return ModelWriter(path, model, progress).write();
  Model converted = model;
  converted.colors = names_gltf(path) ? as_light(model.colors) : as_displayed(model.colors);
  return ModelWriter(path, converted, progress).write();
}

}  // namespace mq

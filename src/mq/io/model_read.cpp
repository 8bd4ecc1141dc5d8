// A mesh file names other files as some other machine knew them. Each is looked for where its name
// leads from the mesh file's folder, then in that folder by the last part of its name, then with
// other capitals.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <tuple>

#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/base/words.h"
#include "mq/io/document.h"
#include "mq/io/file_names.h"
#include "mq/io/detail/gltf.h"
#include "mq/io/detail/held.h"
#include "mq/io/image_file.h"
#include "mq/io/model_watch.h"
#include "mq/io/detail/obj.h"
#include "mq/io/detail/picture_tiles.h"
#include "mq/io/path_status.h"
#include "mq/io/slots.h"

namespace mq {
namespace {

namespace fs = std::filesystem;
using Pictures = ReadModelOptions::Pictures;

// ---- Which format ----

std::string lower(std::string text) {
  for (char& c : text) c = c >= 'A' && c <= 'Z' ? char(c + 32) : c;
  return text;
}

/// What a file of no mesh format we read begins with, and what it is.
constexpr std::pair<std::string_view, const char*> other_formats[] = {
    {"\x89PNG", "a PNG picture"},    {"\xff\xd8\xff", "a JPEG picture"},
    {"II*", "a TIFF picture"},       {"MM\0*", "a TIFF picture"},
    {"PK\x03\x04", "a zip archive, as USDZ is"}, {"\x1f\x8b", "a gzip archive"},
    {"Kaydara FBX", "an FBX scene"}, {"solid ", "an STL mesh"},
    {"OFF", "an OFF mesh"},          {"newmtl", "a material library, not the mesh"},
    {"#usda", "a USD scene"},        {"PXR-USDC", "a USD scene"},
    {"Ogawa", "an Alembic scene"},   {"\x89HDF", "an HDF5 file, such as Alembic scenes were"},
    {"BLENDER", "a file of Blender"}};

Document::Format format_of(const fs::path& path, ByteView bytes) {
  std::string_view text = text_of(bytes);
  if (text.empty())
    throw IoError(path.string() + " is empty; check that it was written and copied whole");
  if (text.starts_with("ply") && text.find_first_of("\r\n") == text.find_first_of("\r\n "))
    return Document::Format::ply;
  if (text.starts_with("glTF")) return Document::Format::glb;
  for (const auto& [beginning, what] : other_formats)
    if (text.starts_with(beginning))
      throw IoError(fmt::format("{} is {}; convert it to OBJ, PLY, glTF or GLB first, as Blender does{}", path.string(),
                                what,
                                text.starts_with("#usda") || lower_extension(path) == ".usdz"
                                    ? ", or by export where it moves: -o frame_%04d.ply"
                                    : ""));
  if (lower_extension(path) == ".evolving")
    throw IoError(path.string() + " is an evolving mesh: marquetry export says what it holds, and writes its frames");
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first != text.npos && text[first] == '{') return Document::Format::gltf;
  const std::string extension = lower_extension(path);
  if (extension == ".ply" || extension == ".glb" || extension == ".gltf")
    if (text.find("\nv ") == text.npos && !text.starts_with("v "))
      throw IoError(
          fmt::format("{} is not {}: its content is of another kind; check that it was "
                      "copied whole",
                      path.string(), extension.substr(1)));
  return Document::Format::obj;
}

// ---- Files that the mesh file names ----

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

/// The one file of a folder whose name differs in capitals only; nothing where there are several.
std::optional<std::string> find_in_other_case(const fs::path& folder, const std::string& name) {
  std::optional<std::string> found;
  std::error_code ignored;
  for (fs::directory_iterator at(folder.empty() ? "." : folder, ignored), end;
       !ignored && at != end; at.increment(ignored)) {
    const std::string there = at->path().filename().string();
    if (lower(there) != lower(name) || !is_file(at->path())) continue;
    if (found) return {};
    found = there;
  }
  return found;
}

/// The name, from `folder`, under which a file is found: as it is named, by the last part of that,
/// or so but for capitals, which some systems do not tell apart.
std::optional<std::string> find_file(const fs::path& folder, const std::string& name) {
  if (name.empty() || name.find('\0') != name.npos) return {};
  if (is_file(folder / name)) return name;
  const std::string last = fs::path(name).filename().string();
  if (last.empty()) return {};
  if (is_file(folder / last)) return last;
  const fs::path parent = fs::path(name).parent_path();
  if (const auto found = find_in_other_case(folder / parent, last))
    return (parent / *found).string();
  return parent.empty() ? std::nullopt : find_in_other_case(folder, last);
}

class ModelReader {
 public:
  ModelReader(const fs::path& path, const ReadModelOptions& options, const Progress& progress, const ModelWatch& watch)
      : options_(options), progress_(progress), watch_(watch), folder_(path.parent_path()) {
    model_.path = path;
  }

  Model read() {
    const Progress mesh_progress = progress_.step("read mesh", 0.3);
    Document document;
    document.name = model_.path.string();
    document.bytes = read_file(model_.path);
    document.files = {model_.path};
    document.format = format_of(model_.path, document.bytes);
    if (!options_.slot.empty()) document.choice.slot = slot_from_text(options_.slot);
    document.choice.uv_set = options_.uv_set;
    mesh_progress.at(0.3);
    read_parts(document);
    MeshFile file = read_document(document);
    if (const std::string slot = slot_of_given(file); slot != file.slot) {
      document.choice.slot = slot;
      file = read_document(document);
    }
    mesh_progress.at(1);

    model_.mesh = std::move(file.mesh);
    model_.colors = std::move(file.colors);
    model_.notes.insert(model_.notes.end(), file.notes.begin(), file.notes.end());
    model_.defects = std::move(file.defects);
    model_.slots = std::move(file.slots);
    model_.slot = std::move(file.slot);
    model_.uv_sets = std::move(file.uv_sets);
    model_.uv_set = options_.uv_set;
    note_choice();
    if (watch_) watch_(model_);
    take_textures(file.textures);
    take_others(file.others);
    if (watch_) watch_(model_);
    model_.document = std::make_shared<const Document>(std::move(document));
    return std::move(model_);
  }

 private:
  bool reads_pictures() const { return options_.pictures != Pictures::skip; }
  bool needs_pictures() const { return options_.pictures == Pictures::read; }

  void read_parts(Document& document) {
    if (document.is_gltf())
      return read_buffers(document);
    if (document.format != Document::Format::obj) return;
    for (const ObjFile::Library& library : obj_libraries(document.bytes)) {
      // One name with blanks, or else several names.
      std::vector<std::string> names{portable_name(library.names)};
      if (!find_file(folder_, names[0])) {
        Scanner scanner(library.names);
        std::vector<std::string> words;
        for (auto word = scanner.word(); !word.empty(); word = scanner.word())
          words.push_back(portable_name(word));
        if (words.size() > 1 && find_file(folder_, words[0])) names = std::move(words);
      }
      for (const std::string& name : names) read_part(document, name);
    }
  }

  /// A buffer goes by the name the document gives it, wherever it was found.
  void read_buffers(Document& document) {
    for (const std::string& name : gltf_parts(document))
      if (const auto found = find_file(folder_, name)) add_part(document, name, folder_ / *found);
  }

  static void add_part(Document& document, const std::string& name, const fs::path& path) {
    document.parts.push_back({name, read_file(path)});
    document.files.push_back(path);
  }

  void read_part(Document& document, const std::string& name) {
    const auto found = find_file(folder_, name);
    if (!found) {
      missing_parts_.push_back(name);
      return;
    }
    for (const Part& part : document.parts)
      if (part.name == *found) return;
    add_part(document, *found, folder_ / *found);
  }

  /// The last part of a name, the same for all tiles of a picture.
  static std::string pattern_of(const fs::path& path) {
    const std::string name = path.filename().string();
    const std::optional<TileName> tile = tile_name(name);
    return tile ? tile->pattern() : name;
  }

  /// The slot that pictures are given for: one whose own pictures they are, or the one that is read.
  std::string slot_of_given(const MeshFile& file) const {
    if (options_.textures.empty() || !options_.slot.empty()) return file.slot;
    const auto has_given = [&](const MaterialSlot& slot) {
      return std::ranges::all_of(options_.textures, [&](const fs::path& given) {
        return std::ranges::any_of(slot.pictures, [&](const MaterialSlot::Use& use) {
          return pattern_of(use.picture) == pattern_of(given);
        });
      });
    };
    const auto by_name = [&](const std::string& name) {
      return std::ranges::find(file.slots, name, &MaterialSlot::name);
    };
    const auto own = by_name(file.slot);
    if (own != file.slots.end() && has_given(*own)) return file.slot;
    for (const MaterialSlot& slot : file.slots)
      if (has_given(slot)) return slot.name;
    if (!file.slots.empty() && by_name(base_slot) == file.slots.end())
      throw InvalidInput(fmt::format(
          "{}: its materials name pictures for {} and none for {}, and {} is none of them: say what it "
          "is for by {}",
          model_.path.string(), names_of(file.slots), base_slot, options_.textures[0].string(),
          option_name("slot")));
    return file.slot;
  }

  /// Says what was chosen where nobody asked for it.
  void note_choice() {
    if (!options_.slot.empty() || model_.slot == base_slot || model_.slots.empty()) return;
    model_.notes.push_back(
        model_.slots.size() == 1
            ? fmt::format("its materials name pictures for {} alone: these are its textures",
                          model_.slot)
            : fmt::format("{} is its picture for {}: that slot is used",
                          options_.textures[0].filename().string(), model_.slot));
  }

  void take_textures(const std::vector<TextureSlot>& slots) {
    const bool named = std::any_of(slots.begin(), slots.end(), [](const TextureSlot& slot) {
      return !slot.name.empty() || !slot.picture.empty();
    });
    report_missing_parts(named);
    given_ = joined_tiles(options_.textures, slots.size());
    const std::size_t given = given_.size();
    if (!named && (given <= 1 || slots.empty())) {
      // No picture, or one that paints the whole mesh.
      if (given > 1) refuse_count(slots, named);
      model_.mesh.textures.clear();
      if (given == 1) add_picture({}, 0, 1, true);
    } else {
      if (given != 0 && given != slots.size()) refuse_count(slots, named);
      for (std::size_t i = 0; i < slots.size(); ++i) add_picture(slots[i], i, slots.size(), false);
    }
    assign_tiles();
  }

  /// Pictures of the other slots are named, not read; the tiles of those that come in tiles follow.
  void take_others(const std::vector<TextureSlot>& others) {
    std::vector<Texture> tiles;
    for (const TextureSlot& slot : others) {
      Texture& texture = model_.others.emplace_back();
      texture.name = slot.name;
      if (!slot.picture.empty()) continue;
      const auto tile_of_name = tile_name(slot.name);
      if (!tile_of_name || tile_of_name->place)
        if (const auto found = find_file(folder_, slot.name)) texture.path = folder_ / *found;
      if (!tile_of_name) continue;
      for (const auto& [tile, triangles] : tiles_used(model_.mesh, -1)) {
        if (!tile_of_name->has_number_for(tile)) continue;
        const std::string name = tile_of_name->file(tile);
        if (name == slot.name || !is_file(folder_ / name)) continue;
        Texture& one = tiles.emplace_back();
        one.name = name;
        one.path = folder_ / name;
      }
    }
    std::ranges::move(tiles, std::back_inserter(model_.others));
  }

  void note_unused_tiles(const GivenPicture& picture, const std::vector<TilePlace>& tiles) {
    for (const auto& [tile, path] : picture.places)
      if (std::ranges::count(tiles, tile) == 0)
        model_.notes.push_back(
            fmt::format("no triangle lies in the tile of {}, which is not used", path.string()));
  }

  /// A picture of the file, or each of its tiles.
  void add_picture(const TextureSlot& slot, std::size_t i, std::size_t count, bool paints_all) {
    const bool given = i < given_.size();
    const std::string name = given ? given_[i].path.string() : slot.name;
    const auto tile_of_name =
        given || slot.picture.empty() ? tile_name(name) : std::optional<TileName>();
    const std::map<TilePlace, int> used =
        tile_of_name ? tiles_used(model_.mesh, paints_all ? -1 : int(i)) : std::map<TilePlace, int>();
    std::vector<TilePlace> tiles;
    if (tile_of_name) {
      TileName asked = *tile_of_name;
      if (given && given_[i].places.size() > 1) asked.place.reset();  // as if by their pattern
      tiles = tiles_of_picture(asked, used, model_.path.string());
    }
    if (given && !tiles.empty()) note_unused_tiles(given_[i], tiles);
    if (tiles.empty()) {
      model_.tiles.push_back({int(i), 0, 0});
      return add_texture(slot, i, given ? given_[i].path : fs::path(), count);
    }
    tiled_ = true;
    for (MaterialSlot& of_file : model_.slots) of_file.with_texture.clear();
    const auto slot_tile = tile_name(slot.name);
    for (const TilePlace& tile : tiles) {
      TextureSlot one = slot;
      one.name = slot_tile ? slot_tile->file(tile) : "";
      fs::path path;
      if (given) {
        const auto named = given_[i].places.find(tile);
        path = named != given_[i].places.end() ? named->second : fs::path(tile_of_name->file(tile));
      }
      const bool there = given ? is_there(path) : find_file(folder_, one.name).has_value();
      const auto triangles = used.find(tile);
      if (!there && reads_pictures())
        throw IoError(fmt::format(
            "{}: needs tile {} of {} for {}, and {} is not there; put it there{}",
            model_.path.string(), tile_number(*tile_of_name, tile),
            shown(fs::path(tile_of_name->pattern()).filename().string()),
            counted(triangles == used.end() ? 0 : triangles->second, "triangle"),
            given ? path.string() : shown(one.name),
            tile_of_name->place ? ", or, if the picture repeats, rename it: its number says tiles"
                                : ""));
      model_.tiles.push_back({int(i), tile.u, tile.v});
      add_texture(one, i, path, count * tiles.size());
    }
  }

  /// Gives each triangle the texture of its tile.
  void assign_tiles() {
    if (!tiled_) {
      model_.tiles.clear();
      return;
    }
    std::map<std::tuple<int, int, int>, int> ids;
    std::map<int, int> first;  // textures of pictures
    for (std::size_t i = 0; i < model_.tiles.size(); ++i) {
      const TextureTile& tile = model_.tiles[i];
      ids[{tile.picture, tile.u, tile.v}] = int(i);
      first.try_emplace(tile.picture, int(i));
    }
    Mesh& mesh = model_.mesh;
    if (mesh.textures.empty()) mesh.textures.assign(mesh.triangles.size(), 0);
    for (int t = 0; t < mesh.triangle_count(); ++t) {
      int& texture = mesh.textures[std::size_t(t)];
      if (texture < 0) continue;
      const int picture = texture;
      texture = first.at(picture);
      const std::optional<TilePlace> tile = tile_of(mesh, t);
      if (!tile) continue;
      if (const auto id = ids.find({picture, tile->u, tile->v}); id != ids.end())
        texture = id->second;
    }
  }

  void report_missing_parts(bool named) {
    for (const std::string& name : missing_parts_) {
      const std::string what = fmt::format("names the material library {}, which is not in {}",
                                           shown(name), folder_text());
      if (!named && needs_pictures() && options_.textures.empty() && model_.mesh.has_uvs())
        throw IoError(fmt::format("{} {}; put it there, or give the picture yourself",
                                  model_.path.string(), what));
      model_.notes.push_back("it " + what);
    }
  }

  [[noreturn]] void refuse_count(const std::vector<TextureSlot>& slots, bool named) const {
    std::string names;
    for (const TextureSlot& slot : slots) names += (names.empty() ? ": " : ", ") + shown(slot.name);
    throw InvalidInput(fmt::format(
        "{} has {}{}, but {} given; give one for each", model_.path.string(),
        counted(std::max<std::int64_t>(std::ssize(slots), 1), "texture"), named ? names : "",
        options_.textures.size() == 1 ? "1 picture is"
                                      : fmt::format("{} pictures are", options_.textures.size())));
  }

  /// `given`: in place of the slot's own picture; empty: none.
  void add_texture(const TextureSlot& slot, std::size_t i, const fs::path& given_path,
                   std::size_t count) {
    const Progress progress = progress_.step("read picture", 0.7 / double(count));
    Texture texture;
    const bool given = !given_path.empty();
    const fs::path path = given ? given_path : slot_path(slot);
    if (!reads_pictures() || (path.empty() && slot.picture.empty())) {
      texture.path = path;
    } else if (given || slot.picture.empty()) {
      texture = read_texture(path, progress, options_.not_finite, options_.layer);
    } else {
      const std::string name = fmt::format("{}, the embedded picture {}", model_.path.string(),
                                           slot.name.empty() ? std::to_string(i) : slot.name);
      texture = read_texture_bytes(slot.picture, name, progress, options_.not_finite, options_.layer);
    }
    if (const int tag = orientation(texture.format); tag != 1)
      texture.notes.push_back(fmt::format("{}: its orientation {} is not heeded, as renderers do not heed it in "
                                          "textures",
                                          texture.name, tag));
    // A picture given in a file of the same name goes by the name it has in the model.
    const bool renamed = given && path.filename() != fs::path(slot.name).filename();
    texture.name = renamed ? path.filename().string() : slot.name;
    if (slot.wrap != Wrap::unspecified) texture.wrap = slot.wrap;
    texture.meaning = meaning_of_slot(model_.slot);
    if (texture.meaning == TextureMeaning::normals && texture.pixels.channels() < 3)
      texture.meaning = TextureMeaning::values;  // a height for each texel
    model_.textures.push_back(std::move(texture));
  }

  fs::path slot_path(const TextureSlot& slot) {
    if (!slot.picture.empty()) return {};
    const auto found = find_file(folder_, slot.name);
    if (found) {
      if (*found != slot.name)
        model_.notes.push_back(
            fmt::format("the picture {} was found as {}", shown(slot.name), shown(*found)));
      return folder_ / *found;
    }
    const std::string what =
        fmt::format("names the picture {}, which is not in {}", shown(slot.name), folder_text());
    if (needs_pictures())
      throw IoError(fmt::format("{} {}{}; put it there, or give the picture yourself",
                                model_.path.string(), what, pictures_there()));
    model_.notes.push_back("it " + what);
    return {};
  }

  std::string folder_text() const {
    return folder_.empty() ? "the current folder" : folder_.string();
  }

  /// The first pictures in the folder, for a message.
  std::string pictures_there() const {
    std::vector<std::string> names;
    std::error_code ignored;
    for (fs::directory_iterator at(folder_.empty() ? "." : folder_, ignored), end;
         !ignored && at != end; at.increment(ignored)) {
      const std::string extension = lower_extension(at->path());
      for (const char* known : {".png", ".jpg", ".jpeg", ".webp", ".tif", ".tiff", ".exr", ".bmp", ".tga"})
        if (extension == known) names.push_back(at->path().filename().string());
    }
    std::sort(names.begin(), names.end());
    if (names.empty()) return "";
    names.resize(std::min<std::size_t>(names.size(), 3));
    return fmt::format(" (there are {})", fmt::join(names, ", "));
  }

  const ReadModelOptions& options_;
  const Progress& progress_;
  const ModelWatch& watch_;
  fs::path folder_;
  Model model_;
  std::vector<std::string> missing_parts_;
  std::vector<GivenPicture> given_;
  bool tiled_ = false;  ///< whether a picture comes in tiles
};

}  // namespace

Model read_model(const fs::path& path, const ReadModelOptions& options, const Progress& progress) {
  return read_model(path, options, progress, {});
}

Model read_model(const fs::path& path, const ReadModelOptions& options, const Progress& progress,
                 const ModelWatch& watch) {
  if (auto held = held_model(path, options, progress)) return std::move(*held);
  return ModelReader(path, options, progress, watch).read();
}

}  // namespace mq

// A changed number is replaced where it stands; words between and after stay as they are. A library
// is written anew under the mesh file's own name when a picture in it gets another, so that other
// meshes that share it keep theirs.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <set>

#include "mq/base/error.h"
#include "mq/io/detail/mtl.h"
#include "mq/io/detail/obj.h"
#include "mq/io/file_names.h"
#include "mq/io/materials.h"
#include "mq/io/normals.h"
#include "mq/io/slots.h"

namespace mq {
namespace {

namespace fs = std::filesystem;

/// `name`, or with the first number behind it that makes it new; joins `taken`.
std::string unique(const std::string& name, const std::string& extension,
                   std::set<std::string>& taken) {
  std::string result = name + extension;
  for (int i = 1; !taken.insert(result).second; ++i)
    result = fmt::format("{}_{}{}", name, i, extension);
  return result;
}

/// The last part of a name, as another file would call it.
std::string file_name(std::string_view name) {
  return fs::path(portable_name(name)).filename().string();
}

std::string material_name(const std::string& picture) {
  std::string name = fs::path(picture).stem().string();
  std::replace(name.begin(), name.end(), ' ', '_');
  return name.empty() ? "textured" : name;
}

MtlMaterial painted(std::string name, const std::string& picture, const std::string& slot) {
  MtlMaterial material;
  material.name = std::move(name);
  material.maps.push_back({.slot = slot, .picture = picture, .place = {}});
  return material;
}

// ---- Changes to the bytes that were read ----

class ObjSplicer {
 public:
  ObjSplicer(const Model& model, const Document& document, const std::string& stem)
      : model_(model),
        document_(document),
        stem_(stem),
        text_(text_of(document.bytes)),
        obj_(parse_obj(document.bytes, document.name)),
        says_(read_obj(document)) {}

  /// The files, or none where the change is too large to be spliced in.
  std::vector<OutputFile> files(const std::vector<std::string>& pictures) {
    const auto names = slot_names(says_, model_, pictures);
    if (!names || !same_connectivity(says_.mesh, model_.mesh)) return {};
    const bool moved_uvs = says_.mesh.uvs != model_.mesh.uvs;
    if (moved_uvs && says_.mesh.uvs.size() != obj_.uvs.size()) return {};

    edit_vertices();
    if (moved_uvs) edit_uvs();
    std::vector<OutputFile> result(1);
    const auto textures = std::ptrdiff_t(std::min(pictures.size(), model_.textures.size()));
    edit_libraries(*names, {pictures.begin() + textures, pictures.end()}, result);
    add_library(*names, result);
    result[0] = {stem_ + ".obj", edited(document_.bytes, std::move(edits_))};
    return result;
  }

 private:
  void edit_vertices() {
    const int channels = color_channels(model_.colors);
    const bool recolored = model_.colors.channels != says_.colors.channels ||
                           model_.colors.values != says_.colors.values;
    for (int v = 0; v < model_.mesh.vertex_count(); ++v) {
      const Vector3 &now = model_.mesh.positions[v], &before = says_.mesh.positions[v];
      if (now == before && !recolored) continue;
      Edit edit{obj_.vertices[v], obj_.vertices[v], ""};
      Scanner scanner(text_, edit.begin);
      for (int k = 0; k < 3; ++k) replace_number(scanner, edit, before[k], now[k]);
      if (recolored) {
        skip_numbers(scanner, edit);
        for (int c = 0; c < channels; ++c) {
          edit.text += ' ';
          append_number(edit.text, color(model_.colors, v, c));
        }
      }
      edits_.push_back(std::move(edit));
    }
  }

  void edit_uvs() {
    for (std::size_t i = 0; i < obj_.uvs.size(); ++i) {
      const Vector2 &now = model_.mesh.uvs[i], &before = says_.mesh.uvs[i];
      if (now == before) continue;
      Edit edit{obj_.uvs[i], obj_.uvs[i], ""};
      Scanner scanner(text_, edit.begin);
      for (int k = 0; k < 2; ++k) replace_number(scanner, edit, before[k], now[k]);
      edits_.push_back(std::move(edit));
    }
  }

  /// Extends `edit` over the next number, with what stands before it.
  void replace_number(Scanner& scanner, Edit& edit, double before, double now) const {
    Scanner ahead = scanner;
    const std::string_view word = ahead.word();
    if (word.empty()) {  // a second coordinate that was left out
      if (now == before) return;
      edit.text += ' ';
      return append_number(edit.text, now);
    }
    scanner = ahead;
    const std::size_t begin = scanner.offset() - word.size();
    edit.text += text_.substr(edit.end, begin - edit.end);
    if (now == before) {
      edit.text += word;
    } else {
      append_number(edit.text, now);
    }
    edit.end = scanner.offset();
  }

  /// Extends `edit` over the numbers that are left in the line.
  static void skip_numbers(Scanner& scanner, Edit& edit) {
    double number = 0;
    for (;;) {
      const std::string_view word = scanner.word();
      if (!to_number(word, number)) return;
      edit.end = scanner.offset();
    }
  }

  /// Puts another name of a picture where it stands in a part.
  static void rename_picture(const TextureSlot& slot, const std::string& name, int part,
                             const fs::path& folder, std::vector<Edit>& edits) {
    if (name == slot.name) return;
    for (const Place& place : slot.places)
      if (place.part == part)
        edits.push_back(
            {place.begin, place.end,
             place.before +
                 (folder.empty() ? name : fs::path(name).lexically_relative(folder).string())});
  }

  /// Parts as they are, or with names of pictures replaced and then under a name of their own.
  void edit_libraries(const std::vector<std::string>& names, const std::vector<std::string>& others,
                      std::vector<OutputFile>& files) {
    for (std::size_t p = 0; p < document_.parts.size(); ++p) {
      const Part& part = document_.parts[p];
      const fs::path folder = fs::path(part.name).parent_path();
      std::vector<Edit> edits;
      for (std::size_t s = 0; s < says_.textures.size(); ++s)
        rename_picture(says_.textures[s], names[s], int(p), folder, edits);
      for (std::size_t s = 0; s < says_.others.size() && others.size() >= says_.others.size(); ++s)
        rename_picture(says_.others[s], others[s], int(p), folder, edits);
      if (edits.empty()) {
        taken_.insert(part.name);
        files.push_back(part);
        continue;
      }
      const std::string name = unique((folder / stem_).string(), ".mtl", taken_);
      files.push_back({name, edited(part.bytes, std::move(edits))});
      if (name != part.name) rename_library(part.name, name);
    }
  }

  void rename_library(const std::string& before, const std::string& now) {
    for (const ObjFile::Library& library : obj_.libraries) {
      const std::size_t begin = library.place.begin;
      if (file_name(library.names) == file_name(before)) {
        edits_.push_back({begin, library.place.end, now});
        continue;
      }
      Scanner words(library.names);
      for (std::string_view word = words.word(); !word.empty(); word = words.word())
        if (file_name(word) == file_name(before))
          edits_.push_back({begin + words.offset() - word.size(), begin + words.offset(), now});
    }
  }

  /// A library of those materials that no part holds but that have a picture now.
  void add_library(const std::vector<std::string>& names, std::vector<OutputFile>& files) {
    std::vector<MtlMaterial> materials;
    for (std::size_t s = 0; s < says_.textures.size(); ++s)
      if (says_.textures[s].places.empty() && !names[s].empty())
        materials.push_back(painted(obj_.materials[s], names[s], base_slot));
    std::string head;
    if (has_triangles_without_material() && !names.empty() && model_.mesh.textures.empty()) {
      std::set<std::string> taken(obj_.materials.begin(), obj_.materials.end());
      const std::string name = unique(material_name(names[0]), "", taken);
      materials.push_back(painted(name, names[0], base_slot));
      head = "usemtl " + name + "\n";
    }
    if (materials.empty()) return;
    const std::string name = unique(stem_, ".mtl", taken_);
    files.push_back({name, to_bytes(new_mtl(materials))});
    const bool named = std::any_of(
        obj_.libraries.begin(), obj_.libraries.end(),
        [&](const ObjFile::Library& library) { return file_name(library.names) == name; });
    if (!named) head = "mtllib " + name + "\n" + head;
    const std::size_t top = text_.starts_with("\xef\xbb\xbf") ? 3 : 0;
    edits_.push_back({top, top, head});
  }

  bool has_triangles_without_material() const {
    const std::vector<int>& ids = obj_.mesh.textures;
    return ids.empty() ? obj_.mesh.triangle_count() > 0
                       : std::find(ids.begin(), ids.end(), -1) != ids.end();
  }

  const Model& model_;
  const Document& document_;
  const std::string& stem_;
  std::string_view text_;
  ObjFile obj_;
  MeshFile says_;
  std::vector<Edit> edits_;
  std::set<std::string> taken_;
};

// ---- A file made anew ----

void append_positions(std::string& text, const Model& model) {
  const int channels = color_channels(model.colors);
  for (int v = 0; v < model.mesh.vertex_count(); ++v) {
    text += 'v';
    for (int k = 0; k < 3; ++k) {
      text += ' ';
      append_number(text, model.mesh.positions[v][k]);
    }
    for (int c = 0; c < channels; ++c) {
      text += ' ';
      append_number(text, color(model.colors, v, c));
    }
    text += '\n';
  }
}

/// Each vector once; per corner the number of its own, from 1.
std::vector<int> append_normals(std::string& text, const std::vector<Eigen::Vector3f>& normals) {
  std::map<std::array<float, 3>, int> known;
  std::vector<int> numbers;
  for (const Eigen::Vector3f& n : normals) {
    const auto found = known.try_emplace({n.x(), n.y(), n.z()}, int(known.size()) + 1);
    numbers.push_back(found.first->second);
    if (!found.second) continue;
    text += "vn";
    for (const float value : n) {
      text += ' ';
      append_number(text, value);
    }
    text += '\n';
  }
  return numbers;
}

/// `normals`: of all corners, or none.
void append_face(std::string& text, const Mesh& mesh, const std::vector<int>& normals,
                 int triangle) {
  text += 'f';
  for (int k = 0; k < 3; ++k) {
    text += ' ' + std::to_string(mesh.triangles[triangle][k] + 1);
    const int uv = mesh.has_uvs() ? mesh.corner_uvs[triangle][k] : -1;
    if (uv >= 0 || !normals.empty()) text += '/';
    if (uv >= 0) text += std::to_string(uv + 1);
    if (!normals.empty())
      text += '/' + std::to_string(normals[3 * std::size_t(triangle) + std::size_t(k)]);
  }
  text += '\n';
}

MtlMaterial new_material(const Model& model, const ModelMaterials& said, const NewMaterial& part,
                         const std::vector<std::string>& pictures, const std::string& stem,
                         std::set<std::string>& taken) {
  MtlMaterial material;
  if (part.material >= 0) material.look = said.materials[std::size_t(part.material)];
  std::string name = material.look.name;
  std::ranges::replace_if(name, [](unsigned char c) { return c <= ' ' || c == 0x7f; }, '_');
  if (name.empty()) name = part.texture < 0 ? "material" : material_name(pictures[std::size_t(part.texture)]);
  material.name = unique(name, "", taken);
  if (part.texture < 0) return material;
  for (const SlotPicture& one : material_pictures(model, part.texture, stem + ".obj")) {
    if (!mtl_keyword(one.slot))
      throw Unsupported(stem + ".obj: OBJ has no word for pictures of the slot " + one.slot +
                        ": write the pictures alone, or glTF");
    material.maps.push_back(
        {.slot = one.slot, .picture = pictures[std::size_t(one.picture)], .place = {}});
  }
  return material;
}

std::vector<OutputFile> new_files(const Model& model, const std::vector<std::string>& pictures,
                                  const std::string& stem) {
  const ModelMaterials said = file_materials(model);
  const std::vector<NewMaterial> parts = new_materials(model, said);
  std::set<std::string> taken{unknown_material};
  std::vector<MtlMaterial> materials;
  for (const NewMaterial& part : parts)
    materials.push_back(new_material(model, said, part, pictures, stem, taken));

  std::string text;
  if (!materials.empty()) text += "mtllib " + stem + ".mtl\n";
  append_positions(text, model);
  for (const Vector2& uv : model.mesh.uvs) {
    text += "vt ";
    append_number(text, uv.x());
    text += ' ';
    append_number(text, uv.y());
    text += '\n';
  }
  const std::vector<int> normals =
      append_normals(text, frames_to_write(model, stem + ".obj").normals);
  NewMaterial last{.texture = -2};
  std::string name;
  bool untextured = false;
  for (int t = 0; t < model.mesh.triangle_count(); ++t) {
    const NewMaterial part = material_of(model, said, t);
    if (!materials.empty() && part != last) {
      const auto place = std::ranges::find(parts, part);
      untextured = untextured || place == parts.end();
      const std::string own =
          place == parts.end() ? unknown_material : materials[std::size_t(place - parts.begin())].name;
      if (own != name) text += "usemtl " + own + "\n";
      name = own;
      last = part;
    }
    append_face(text, model.mesh, normals, t);
  }
  std::vector<OutputFile> files{{stem + ".obj", to_bytes(text)}};
  if (untextured) materials.push_back({.name = unknown_material, .maps = {}, .end = {}});
  if (!materials.empty()) files.push_back({stem + ".mtl", to_bytes(new_mtl(materials))});
  return files;
}

}  // namespace

std::vector<std::string> libraries_beside(const fs::path& path, const Model& model,
                                          const std::vector<std::string>& pictures) {
  if (lower_extension(path) != ".obj") return {};
  const std::string stem = path.stem().string();
  const Document* document = model.document.get();
  std::vector<OutputFile> files;
  if (document && document->format == Document::Format::obj) files = ObjSplicer(model, *document, stem).files(pictures);
  if (files.empty())
    return new_materials(model, file_materials(model)).empty() ? std::vector<std::string>()
                                                              : std::vector{stem + ".mtl"};
  std::vector<std::string> names;
  for (std::size_t i = 1; i < files.size(); ++i) {
    const OutputFile& file = files[i];
    if (!stays_below(file.name)) continue;
    std::error_code ignored;
    const bool stays = std::ranges::any_of(document->parts, [&](const Part& part) {
      return part.bytes == file.bytes &&
             fs::equivalent(model.path.parent_path() / part.name, path.parent_path() / file.name, ignored);
    });
    if (!stays) names.push_back(file.name);
  }
  return names;
}

ObjOutput write_obj(const Model& model, const std::vector<std::string>& pictures,
                    const std::string& stem) {
  const Document* document = model.document.get();
  if (document && document->format == Document::Format::obj) {
    std::vector<OutputFile> files = ObjSplicer(model, *document, stem).files(pictures);
    if (!files.empty()) return {std::move(files), false};
  }
  return {new_files(model, pictures, stem), true};
}

}  // namespace mq

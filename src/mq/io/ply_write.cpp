// Values that differ are replaced where they stand, in the order of the file, by the bytes of the
// same type; binary files keep their size but for what is added.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <numeric>

#include "mq/base/error.h"
#include "mq/io/detail/ply.h"
#include "mq/io/detail/ply_body.h"
#include "mq/io/normals.h"
#include "mq/io/slots.h"

namespace mq {
namespace {

using Encoding = PlyHeader::Encoding;

const char* type_name(PlyType type) {
  constexpr const char* names[] = {"char", "uchar", "short", "ushort",
                                   "int",  "uint",  "float", "double"};
  return names[int(type)];
}

/// Floats where they hold the values, doubles where they do not.
template <class Vectors>
PlyType smallest_type(const Vectors& vectors) {
  for (const auto& v : vectors)
    for (int k = 0; k < int(v.size()); ++k)
      if (double(float(v[k])) != v[k]) return PlyType::f64;
  return PlyType::f32;
}

struct ColorType {
  PlyType type;
  double scale;
};

ColorType color_type(Depth depth) {
  if (depth == Depth::u8) return {PlyType::u8, 255};
  if (depth == Depth::u16) return {PlyType::u16, 65535};
  return {PlyType::f32, 1};
}

double stored(float value, double scale) {
  return scale == 1 ? double(value) : stored_color(value, unsigned(scale));
}

std::string color_properties(int channels, PlyType type, const std::string& line_end) {
  constexpr const char* names[] = {"red", "green", "blue", "alpha"};
  std::string text;
  for (int c = 0; c < channels; ++c)
    text += fmt::format("property {} {}{}", type_name(type), names[c], line_end);
  return text;
}

// ---- Changes to the bytes that were read ----

class PlySplicer {
 public:
  PlySplicer(const Model& model, const Document& document)
      : model_(model),
        document_(document),
        header_(parse_ply_header(document.bytes, document.name)),
        roles_(header_, document.choice.uv_set),
        says_(parse_ply(document)),
        reader_(document.bytes, header_, document.name) {}

  /// The changed bytes, or none where the change is too large to be spliced in.
  std::optional<Bytes> splice(const std::vector<std::string>& pictures) {
    const auto names = slot_names(says_.file, model_, pictures);
    if (!names || !same_connectivity(says_.file.mesh, model_.mesh) || !types_hold()) return {};
    edit_names(*names);
    for (const PlyElement& element : header_.elements) {
      if (&element == roles_.vertex) {
        if (adds_colors_) edit(element.header_end, element.header_end, color_lines());
        edit_rows(element, [&](std::int64_t row) { edit_vertex(row); });
      } else if (&element == roles_.face && moved_uvs()) {
        edit_rows(element, [&](std::int64_t) { edit_face(); });
      } else {
        edit_rows(element, [](std::int64_t) {});
      }
    }
    return edited(document_.bytes, std::move(edits_));
  }

 private:
  /// Whether the types of the file can hold what is to be written, and what is to be added.
  bool types_hold() {
    const Mesh &now = model_.mesh, &before = says_.file.mesh;
    for (const int p : roles_.position)
      if (is_integer(property(p).type) && now.positions != before.positions) return false;
    constexpr double largest = std::numeric_limits<float>::max();
    for (const Vector3& p : now.positions)
      if (p.cwiseAbs().maxCoeff() > largest && now.positions != before.positions) return false;
    for (const int p : roles_.uv)
      if (p >= 0 && is_integer(property(p).type) && moved_uvs()) return false;
    const int channels = color_channels(model_.colors);
    adds_colors_ = says_.file.colors.channels == 0 && channels > 0;
    return adds_colors_ || channels == says_.file.colors.channels;
  }

  const PlyProperty& property(int p) const { return roles_.vertex->properties[std::size_t(p)]; }
  bool moved_uvs() const { return says_.file.mesh.uvs != model_.mesh.uvs; }

  void edit(std::size_t begin, std::size_t end, std::string text) {
    edits_.push_back({begin, end, std::move(text)});
  }

  void edit_names(const std::vector<std::string>& names) {
    const std::vector<TextureSlot>& slots = says_.file.textures;
    std::string added;
    for (std::size_t s = 0; s < names.size(); ++s) {
      if (s < slots.size() && names[s] == slots[s].name) continue;
      if (s < slots.size() && !slots[s].places.empty()) {
        edit(slots[s].places[0].begin, slots[s].places[0].end, names[s]);
      } else {
        added += "comment TextureFile " + names[s] + header_.line_end;
      }
    }
    if (!added.empty()) edit(header_.last_line, header_.last_line, added);
  }

  std::string color_lines() const {
    return color_properties(color_channels(model_.colors), color_type(model_.colors.depth).type,
                            header_.line_end);
  }

  template <class EditRow>
  void edit_rows(const PlyElement& element, const EditRow& edit_row) {
    std::vector<PlyValue> list;
    for (std::int64_t row = 0; row < element.count && !element.properties.empty(); ++row) {
      reader_.set_place(element, row);
      row_.clear();
      lists_.resize(element.properties.size());
      for (std::size_t p = 0; p < element.properties.size(); ++p) {
        const PlyProperty& property = element.properties[p];
        if (property.count_type) {
          reader_.list(property, lists_[p]);
          row_.push_back({});
        } else {
          row_.push_back(reader_.value(property.type));
        }
      }
      edit_row(row);
    }
  }

  void edit_value(const PlyValue& place, double value, PlyType type) {
    edit(place.begin, place.end, encoded(value, type, header_.encoding));
  }

  void edit_vertex(std::int64_t row) {
    const Vector3 &now = model_.mesh.positions[std::size_t(row)],
                  &before = says_.file.mesh.positions[std::size_t(row)];
    for (int k = 0; k < 3; ++k) {
      const int p = roles_.position[k];
      if (now[k] != before[k]) edit_value(row_[std::size_t(p)], now[k], property(p).type);
    }
    for (int k = 0; k < 2 && roles_.uv[0] >= 0 && roles_.corner_uvs < 0 && moved_uvs_now(row); ++k)
      edit_value(row_[std::size_t(roles_.uv[k])], model_.mesh.uvs[std::size_t(row)][k],
                 property(roles_.uv[k]).type);
    if (adds_colors_) {
      add_colors(int(row));
    } else {
      edit_colors(int(row));
    }
  }

  bool moved_uvs_now(std::int64_t row) const {
    return model_.mesh.uvs[std::size_t(row)] != says_.file.mesh.uvs[std::size_t(row)];
  }

  void edit_colors(int vertex) {
    const double scale = roles_.color_scale();
    for (int c = 0; c < roles_.channels(); ++c) {
      const float now = color(model_.colors, vertex, c);
      if (now == color(says_.file.colors, vertex, c)) continue;
      const int p = roles_.color[c];
      edit_value(row_[std::size_t(p)], stored(now, scale), property(p).type);
    }
  }

  void add_colors(int vertex) {
    const ColorType type = color_type(model_.colors.depth);
    std::string text;
    for (int c = 0; c < color_channels(model_.colors); ++c) {
      if (header_.encoding == Encoding::text) text += ' ';
      text +=
          encoded(stored(color(model_.colors, vertex, c), type.scale), type.type, header_.encoding);
    }
    edit(reader_.offset(), reader_.offset(), text);
  }

  void edit_face() {
    const std::size_t corners = lists_[std::size_t(roles_.indices)].size();
    if (roles_.corner_uvs < 0) return;
    const std::vector<PlyValue>& list = lists_[std::size_t(roles_.corner_uvs)];
    const PlyType type = roles_.face->properties[std::size_t(roles_.corner_uvs)].type;
    for (std::size_t k = 0; k < corners; ++k, ++corner_) {
      const int id = says_.corner_uvs.empty() ? -1 : says_.corner_uvs[corner_];
      if (id < 0 || list.empty()) continue;
      const Vector2 &now = model_.mesh.uvs[std::size_t(id)],
                    &before = says_.file.mesh.uvs[std::size_t(id)];
      for (std::size_t i = 0; i < 2; ++i)
        if (now[int(i)] != before[int(i)]) edit_value(list[2 * k + i], now[int(i)], type);
    }
  }

  const Model& model_;
  const Document& document_;
  const PlyHeader header_;
  const PlyRoles roles_;
  const PlyFile says_;
  PlyReader reader_;
  std::vector<Edit> edits_;
  std::vector<PlyValue> row_;                 ///< of the row at hand, a value per property
  std::vector<std::vector<PlyValue>> lists_;  ///< and its lists
  std::size_t corner_ = 0;
  bool adds_colors_ = false;
};

// ---- A file made anew ----

class NewPly {
 public:
  NewPly(const Model& model, const std::vector<std::string>& pictures)
      : model_(model),
        mesh_(model.mesh),
        colors_(color_type(model.colors.depth)),
        channels_(color_channels(model.colors)),
        position_type_(smallest_type(mesh_.positions)),
        uv_type_(smallest_type(mesh_.uvs)),
        numbered_(std::min(pictures.size(), model.textures.size()) > 1 || has_untextured()),
        other_sets_(other_uv_sets(model)) {
    split_vertices(frames_to_write(model, "new.ply").normals);
    add_header(pictures);
    for (std::size_t i = 0; i < vertices_.size(); ++i) add_vertex(i);
    for (int t = 0; t < mesh_.triangle_count(); ++t) add_face(t);
  }

  Bytes bytes() const { return to_bytes(text_); }

 private:
  bool has_untextured() const {
    return std::any_of(mesh_.textures.begin(), mesh_.textures.end(),
                       [](int texture) { return texture != 0; });
  }

  void add_header(const std::vector<std::string>& pictures) {
    text_ = "ply\nformat binary_little_endian 1.0\n";
    const std::size_t textures = std::min(pictures.size(), model_.textures.size());
    if (textures > 0 && !model_.slot.empty() && model_.slot != base_slot)
      throw Unsupported("PLY names pictures for " + std::string(base_slot) + " alone, not for " +
                        model_.slot + ": write the pictures alone, or glTF");
    for (std::size_t i = 0; i < textures; ++i)
      text_ += "comment TextureFile " + pictures[i] + "\n";
    text_ += fmt::format("element vertex {}\n", vertices_.size());
    for (const char* axis : {"x", "y", "z"})
      text_ += fmt::format("property {} {}\n", type_name(position_type_), axis);
    for (const char* axis : {"nx", "ny", "nz"})
      if (!normals_.empty()) text_ += fmt::format("property float {}\n", axis);
    text_ += color_properties(channels_, colors_.type, "\n");
    text_ += fmt::format("element face {}\nproperty list uchar int vertex_indices\n",
                         mesh_.triangle_count());
    if (mesh_.has_uvs())
      text_ += fmt::format("property list uchar {} texcoord\n", type_name(uv_type_));
    for (std::size_t i = 0; i < other_sets_.size(); ++i) {
      other_types_.push_back(smallest_type(other_sets_[i]->uvs));
      text_ += fmt::format("property list uchar {} texcoord{}\n", type_name(other_types_[i]), i + 1);
    }
    if (numbered_) text_ += "property int texnumber\n";
    text_ += "end_header\n";
  }

  void add(double value, PlyType type) { text_ += encoded(value, type, Encoding::little_endian); }

  /// A vertex has one normal: those whose corners have several are there several times, behind all
  /// others.
  void split_vertices(const std::vector<Eigen::Vector3f>& of_corners) {
    vertices_.resize(mesh_.positions.size());
    std::iota(vertices_.begin(), vertices_.end(), 0);
    triangles_ = mesh_.triangles;
    if (of_corners.empty()) return;
    normals_.assign(vertices_.size(), Eigen::Vector3f::Zero());
    std::map<std::pair<int, std::array<float, 3>>, int> copies;
    for (std::size_t c = 0; c < of_corners.size(); ++c) {
      const Eigen::Vector3f& n = of_corners[c];
      int& v = triangles_[c / 3][c % 3];
      Eigen::Vector3f& first = normals_[std::size_t(v)];
      if (first.isZero(0)) first = n;
      if (first == n) continue;
      const auto copy = copies.try_emplace({v, {n.x(), n.y(), n.z()}}, int(vertices_.size()));
      if (copy.second) {
        vertices_.push_back(v);
        normals_.push_back(n);
      }
      v = copy.first->second;
    }
  }

  void add_vertex(std::size_t i) {
    const int v = vertices_[i];
    for (int k = 0; k < 3; ++k) add(mesh_.positions[v][k], position_type_);
    for (int k = 0; k < 3 && !normals_.empty(); ++k) add(double(normals_[i][k]), PlyType::f32);
    for (int c = 0; c < channels_; ++c)
      add(stored(color(model_.colors, v, c), colors_.scale), colors_.type);
  }

  /// Those of a face's corners, if it has them all.
  void add_uvs(const Triangle& corners, const std::vector<Vector2>& uvs, PlyType type) {
    const bool textured = corners[0] >= 0 && corners[1] >= 0 && corners[2] >= 0;
    add(textured ? 6 : 0, PlyType::u8);
    for (int k = 0; k < 3 && textured; ++k)
      for (int i = 0; i < 2; ++i) add(uvs[std::size_t(corners[std::size_t(k)])][i], type);
  }

  void add_face(int t) {
    add(3, PlyType::u8);
    for (const int v : triangles_[std::size_t(t)]) add(v, PlyType::i32);
    if (mesh_.has_uvs()) add_uvs(mesh_.corner_uvs[std::size_t(t)], mesh_.uvs, uv_type_);
    for (std::size_t i = 0; i < other_sets_.size(); ++i)
      add_uvs(other_sets_[i]->corner_uvs[std::size_t(t)], other_sets_[i]->uvs, other_types_[i]);
    if (numbered_) add(mesh_.texture(t), PlyType::i32);
  }

  const Model& model_;
  const Mesh& mesh_;
  ColorType colors_;
  int channels_;
  PlyType position_type_, uv_type_;
  bool numbered_;
  std::vector<const UvSet*> other_sets_;
  std::vector<PlyType> other_types_;
  std::vector<int> vertices_;             ///< those of the file: the mesh's, and copies of them
  std::vector<Eigen::Vector3f> normals_;  ///< theirs, or none
  std::vector<Triangle> triangles_;       ///< of them
  std::string text_;
};

}  // namespace

OutputFile write_ply(const Model& model, const std::vector<std::string>& pictures,
                     const std::string& stem) {
  const Document* document = model.document.get();
  if (document && document->format == Document::Format::ply)
    if (auto bytes = PlySplicer(model, *document).splice(pictures))
      return {stem + ".ply", std::move(*bytes)};
  return {stem + ".ply", NewPly(model, pictures).bytes()};
}

}  // namespace mq

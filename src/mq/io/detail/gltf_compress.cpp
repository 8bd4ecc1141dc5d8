// Draco rounds each attribute to a grid; one grid for all primitives of the file, so that vertices
// where two meet still do.
#include "mq/io/detail/gltf_compress.h"

#include <draco/attributes/point_attribute.h>
#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>
#include <fmt/format.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <utility>

#include "mq/base/words.h"
#include "mq/io/detail/gltf_meshopt.h"

namespace mq {
namespace {

constexpr const char* draco_name = "KHR_draco_mesh_compression";
constexpr const char* meshopt_name = "EXT_meshopt_compression";

void require_extension(Json& json, const char* name) {
  for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
    Json& names = json[list];
    if (!names.is_array()) names = Json::array();
    if (std::ranges::find(names, Json(name)) == names.end()) names.push_back(name);
  }
}

/// Calls `visit` with each primitive of the JSON and its place.
template <class Visit>
void for_each_primitive(Json& json, const Visit& visit) {
  if (!json.contains("meshes")) return;
  for (std::size_t m = 0; m < json["meshes"].size(); ++m) {
    Json& mesh = json["meshes"][m];
    if (!mesh.contains("primitives")) continue;
    for (std::size_t p = 0; p < mesh["primitives"].size(); ++p)
      visit(mesh["primitives"][p], fmt::format("meshes[{}].primitives[{}]", m, p));
  }
}

bool is_draco(const Json& primitive) {
  const Json* extensions = json_object(primitive, "extensions");
  return extensions && extensions->contains(draco_name);
}

// ---- meshopt ----

class MeshoptWriter {
 public:
  MeshoptWriter(const GltfFile& file, GltfPacker& packer) : file_(file), packer_(packer) {}

  std::vector<std::string> write() {
    for_each_primitive(packer_.json(), [&](Json& primitive, const std::string&) {
      if (is_draco(primitive)) return;
      const bool triangles = primitive.value("mode", 4) == 4;
      if (primitive.contains("indices")) add_indices(primitive["indices"], triangles);
      if (const Json* attributes = json_object(primitive, "attributes"))
        for (const auto& [name, accessor] : attributes->items()) add_attribute(accessor);
      if (primitive.contains("targets"))
        for (const Json& target : primitive["targets"])
          for (const auto& [name, accessor] : target.items()) add_attribute(accessor);
    });
    for (const auto& [view, use] : views_)
      if (use.fits) compress(view, use);
    if (compressed_ == 0) return {file_.name() + ": nothing is there that meshopt could compress"};
    require_extension(packer_.json(), meshopt_name);
    return {};
  }

 private:
  struct Use {
    std::size_t stride = 0;
    bool indices = false;
    bool triangles = true;
    bool fits = true;
  };

  /// The view of an accessor that is neither sparse nor compressed; −1: it is.
  std::int64_t view_of(const Json& id, std::size_t& element) const {
    const auto layout = file_.layout(id.get<std::int64_t>());
    if (!layout) return -1;
    const Json& accessor = file_.item("accessors", id.get<std::int64_t>());
    element = layout->stride;
    return accessor["bufferView"].get<std::int64_t>();
  }

  void add(std::int64_t view, const Use& use) {
    const auto [known, is_new] = views_.try_emplace(view, use);
    Use& all = known->second;
    all.fits = all.fits && use.stride == all.stride && use.indices == all.indices;
    all.triangles = all.triangles && use.triangles;
  }

  void add_indices(const Json& id, bool triangles) {
    std::size_t element = 0;
    const std::int64_t view = view_of(id, element);
    if (view < 0) return;
    const Json& accessor = file_.item("accessors", id.get<std::int64_t>());
    const bool whole = json_count(accessor, "byteOffset", 0, file_.name()) % 3 == 0 &&
                       json_count(accessor, "count", 0, file_.name()) % 3 == 0;
    add(view, {element, true, triangles && whole, element == 2 || element == 4});
  }

  void add_attribute(const Json& id) {
    std::size_t element = 0;
    const std::int64_t view = view_of(id, element);
    if (view >= 0) add(view, {element, false, false, element % 4 == 0 && element <= 256});
  }

  void compress(std::int64_t id, const Use& use) {
    const ByteView bytes = file_.bytes(file_.view(id));
    const std::size_t count = bytes.size() / use.stride;
    if (bytes.empty() || bytes.size() % use.stride != 0) return;
    const bool triangles = use.indices && use.triangles && count % 3 == 0;
    std::vector<unsigned char> stream;
    if (!use.indices) {
      stream.resize(meshopt_encodeVertexBufferBound(count, use.stride));
      stream.resize(
          meshopt_encodeVertexBuffer(stream.data(), stream.size(), bytes.data(), count, use.stride));
    } else {
      stream = index_stream(indices(bytes, use.stride), triangles);
    }
    const ByteView coded = std::as_bytes(std::span(stream));
    packer_.compress_view(id, Bytes(coded.begin(), coded.end()),
                          {{"mode", !use.indices ? "ATTRIBUTES" : triangles ? "TRIANGLES" : "INDICES"},
                           {"count", count},
                           {"byteStride", use.stride}});
    ++compressed_;
  }

  static std::vector<unsigned> indices(ByteView bytes, std::size_t size) {
    std::vector<unsigned> all;
    for (std::size_t at = 0; at < bytes.size(); at += size)
      all.push_back(unsigned(load_component(size == 2 ? GltfType::u16 : GltfType::u32, bytes.data() + at)));
    return all;
  }

  static std::vector<unsigned char> index_stream(const std::vector<unsigned>& indices, bool triangles) {
    const std::size_t vertices = std::size_t(*std::ranges::max_element(indices)) + 1;
    std::vector<unsigned char> stream(
        triangles ? meshopt_encodeIndexBufferBound(indices.size(), vertices)
                  : meshopt_encodeIndexSequenceBound(indices.size(), vertices));
    stream.resize(triangles ? meshopt_encodeIndexBuffer(stream.data(), stream.size(), indices.data(),
                                                        indices.size())
                            : meshopt_encodeIndexSequence(stream.data(), stream.size(),
                                                          indices.data(), indices.size()));
    return stream;
  }

  const GltfFile& file_;
  GltfPacker& packer_;
  std::map<std::int64_t, Use> views_;
  int compressed_ = 0;
};

// ---- Draco ----

struct DracoKind {
  draco::GeometryAttribute::Type type = draco::GeometryAttribute::GENERIC;
  int bits = 0;  ///< 0: floats are kept
};

/// The most bits of a grid: Draco's tables take gigabytes beyond.
constexpr int most_bits = 20;

DracoKind kind_of(const std::string& name, bool floats) {
  if (!floats && name == "NORMAL") return {};  // Draco's coding of normals is of floats
  if (name == "POSITION") return {draco::GeometryAttribute::POSITION, 16};
  if (name == "NORMAL") return {draco::GeometryAttribute::NORMAL, 12};
  if (name.starts_with("TEXCOORD_")) return {draco::GeometryAttribute::TEX_COORD, 16};
  if (name.starts_with("COLOR_")) return {draco::GeometryAttribute::COLOR, 0};
  return {draco::GeometryAttribute::GENERIC, name == "TANGENT" ? 16 : 0};
}

draco::DataType draco_type(GltfType type) {
  switch (type) {
    case GltfType::i8: return draco::DT_INT8;
    case GltfType::u8: return draco::DT_UINT8;
    case GltfType::i16: return draco::DT_INT16;
    case GltfType::u16: return draco::DT_UINT16;
    case GltfType::u32: return draco::DT_UINT32;
    case GltfType::f32: return draco::DT_FLOAT32;
  }
  return draco::DT_INVALID;
}

class DracoWriter {
 public:
  DracoWriter(const GltfFile& file, GltfPacker& packer) : file_(file), packer_(packer) {}

  std::vector<std::string> write() {
    Json& json = packer_.json();
    for_each_primitive(json, [&](Json& primitive, const std::string&) {
      for_each_accessor(primitive, [&](const Json& id) { ++uses_[id.get<std::size_t>()]; });
      if (can_compress(primitive)) find_boxes(primitive);
    });
    for_each_primitive(json, [&](Json& primitive, const std::string& place) {
      if (is_draco(primitive)) return;
      if (can_compress(primitive) && compress(primitive))
        ++compressed_;
      else
        left_.push_back(place);
    });
    if (compressed_ > 0) require_extension(json, draco_name);
    std::vector<std::string> notes;
    if (!left_.empty())
      notes.push_back(fmt::format("{}: {} not compressed ({}): Draco is for indexed triangles with "
                                  "positions in floats, without morph targets or sparse values",
                                  file_.name(),
                                  left_.size() == 1 ? "a primitive is"
                                                    : counted(std::ssize(left_), "primitive") + " are",
                                  left_.front()));
    return notes;
  }

 private:
  /// The grid of an attribute: its least corner and the longest side. What is not finite has none.
  struct Box {
    std::array<float, 4> least{}, most{};
    bool empty = true;
    bool finite = true;
  };

  bool can_compress(const Json& primitive) const {
    const Json* attributes = json_object(primitive, "attributes");
    if (is_draco(primitive) || primitive.contains("targets") || primitive.value("mode", 4) != 4 ||
        !attributes || !attributes->contains("POSITION") || !primitive.contains("indices") ||
        !file_.layout(primitive["indices"].get<std::int64_t>()) ||
        !is_float(attributes->at("POSITION").get<std::int64_t>()))
      return false;
    return std::ranges::all_of(*attributes, [&](const Json& id) {
      return file_.layout(id.template get<std::int64_t>()).has_value();
    });
  }

  bool is_float(std::int64_t accessor) const {
    return file_.item("accessors", accessor).value("componentType", 0) == int(GltfType::f32);
  }

  bool on_grid(const std::string& name, std::int64_t accessor) const {
    return is_float(accessor) && kind_of(name, true).bits > 0;
  }

  /// The vertices that triangles use, in their order; none where an index is out of range.
  std::vector<std::uint32_t> used_vertices(const GltfValues& corners, std::size_t count) const {
    std::vector<char> used(count, 0);
    for (const double corner : corners.values) {
      if (!(corner < double(count))) return {};
      used[std::size_t(corner)] = 1;
    }
    std::vector<std::uint32_t> vertices;
    for (std::size_t v = 0; v < count; ++v)
      if (used[v]) vertices.push_back(std::uint32_t(v));
    return vertices;
  }

  void find_boxes(const Json& primitive) {
    const GltfValues corners = file_.values(primitive["indices"].get<std::int64_t>(), {1});
    for (const auto& [name, id] : primitive["attributes"].items()) {
      if (!on_grid(name, id.get<std::int64_t>())) continue;
      const GltfValues values = file_.values(id.get<std::int64_t>(), {1, 2, 3, 4});
      const auto components = std::size_t(values.components);
      Box& box = boxes_[name];
      for (const std::uint32_t v : used_vertices(corners, values.count())) {
        for (std::size_t c = 0; c < components; ++c) {
          const float value = float(values.values[v * components + c]);
          box.finite = box.finite && std::isfinite(value);
          box.least[c] = box.empty ? value : std::min(box.least[c], value);
          box.most[c] = box.empty ? value : std::max(box.most[c], value);
        }
        box.empty = false;
      }
    }
  }

  /// Values at vertices as they are stored.
  int add_attribute(draco::Mesh& mesh, const std::string& name, std::int64_t accessor,
                    const std::vector<std::uint32_t>& vertices) const {
    const GltfValues values = file_.values(accessor, {1, 2, 3, 4});
    const std::size_t size = std::size_t(values.components * size_of(values.type));
    const GltfLayout layout = *file_.layout(accessor);
    const std::byte* from = file_.buffer(layout.buffer).data() + layout.offset;
    draco::GeometryAttribute attribute;
    attribute.Init(kind_of(name, values.type == GltfType::f32).type, nullptr,
                   std::uint8_t(values.components), draco_type(values.type), values.normalized,
                   std::int64_t(size), 0);
    const int id = mesh.AddAttribute(attribute, true, std::uint32_t(vertices.size()));
    for (std::uint32_t p = 0; p < vertices.size(); ++p)
      mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(p),
                                            from + vertices[p] * layout.stride);
    return id;
  }

  void set_grid(draco::ExpertEncoder& encoder, const std::string& name, std::int64_t accessor,
                int id) const {
    if (!on_grid(name, accessor) || !boxes_.at(name).finite) return;
    const Box& box = boxes_.at(name);
    float range = 0;
    for (std::size_t c = 0; c < 4; ++c) range = std::max(range, box.most[c] - box.least[c]);
    int bits = kind_of(name, true).bits;
    if (name == "NORMAL") {
      encoder.SetAttributeQuantization(id, bits);
      return;
    }
    if (name == "TANGENT") {
      const std::array<float, 4> origin{-1, -1, -1, -1};
      encoder.SetAttributeExplicitQuantization(id, bits, 4, origin.data(), 2);
      return;
    }
    if (name != "POSITION" && range > 1) bits += int(std::ceil(std::log2(range)));
    if (bits > most_bits) return;  // floats, as they are
    const int components = name == "POSITION" ? 3 : 2;
    encoder.SetAttributeExplicitQuantization(id, bits, components, box.least.data(),
                                             range > 0 ? range : 1);
  }

  /// False where Draco refuses, or what it holds is not all of the mesh.
  bool compress(Json& primitive) {
    const Json& attributes = primitive["attributes"];
    const auto points = json_count(
        file_.item("accessors", attributes["POSITION"].get<std::int64_t>()), "count", 0, file_.name());
    const GltfValues corners = file_.values(primitive["indices"].get<std::int64_t>(), {1});
    const std::vector<std::uint32_t> vertices = used_vertices(corners, std::size_t(points));
    if (vertices.empty()) return false;
    std::vector<std::uint32_t> number(std::size_t(points), 0);
    for (std::uint32_t p = 0; p < vertices.size(); ++p) number[vertices[p]] = p;
    draco::Mesh mesh;
    mesh.set_num_points(std::uint32_t(vertices.size()));
    for (std::size_t i = 0; i + 2 < corners.values.size(); i += 3) {
      draco::Mesh::Face face;
      for (std::size_t k = 0; k < 3; ++k)
        face[k] = draco::PointIndex(number[std::size_t(corners.values[i + k])]);
      mesh.AddFace(face);
    }
    std::map<std::string, int> ids;
    for (const auto& [name, id] : attributes.items()) {
      const std::int64_t accessor = id.get<std::int64_t>();
      if (json_count(file_.item("accessors", accessor), "count", 0, file_.name()) != points) return false;
      ids[name] = add_attribute(mesh, name, accessor, vertices);
    }
    for (const int method : {draco::MESH_EDGEBREAKER_ENCODING, draco::MESH_SEQUENTIAL_ENCODING}) {
      draco::ExpertEncoder encoder(mesh);
      encoder.SetEncodingMethod(method);
      encoder.SetSpeedOptions(3, 3);
      encoder.SetTrackEncodedProperties(true);
      for (const auto& [name, id] : ids)
        set_grid(encoder, name, attributes[name].get<std::int64_t>(), id);
      draco::EncoderBuffer out;
      if (!encoder.EncodeToBuffer(&out).ok() || encoder.num_encoded_faces() != mesh.num_faces()) continue;
      store(primitive, mesh, ids, to_bytes({out.data(), out.size()}), encoder.num_encoded_points());
      return true;
    }
    return false;
  }

  /// Accessors that other primitives use stay, and the primitive gets its own.
  void store(Json& primitive, const draco::Mesh& mesh, const std::map<std::string, int>& ids,
             Bytes stream, std::size_t points) {
    Json& accessors = packer_.json()["accessors"];
    const auto renew = [&](Json& id, std::size_t count) {
      const auto old = id.get<std::size_t>();
      if (--uses_[old] > 0) {
        Json copy = accessors[old];
        id = accessors.size();
        accessors.push_back(std::move(copy));
      }
      Json& accessor = accessors[id.get<std::size_t>()];
      accessor.erase("bufferView");
      accessor.erase("byteOffset");
      accessor["count"] = count;
    };
    Json stored = Json::object();
    for (const auto& [name, id] : ids) {
      stored[name] = mesh.attribute(id)->unique_id();
      renew(primitive["attributes"][name], points);
    }
    renew(primitive["indices"], 3 * std::size_t(mesh.num_faces()));
    primitive["extensions"][draco_name] = {{"bufferView", packer_.add_view(std::move(stream))},
                                           {"attributes", stored}};
  }

  template <class Visit>
  static void for_each_accessor(const Json& primitive, const Visit& visit) {
    if (primitive.contains("indices")) visit(primitive["indices"]);
    if (primitive.contains("attributes"))
      for (const Json& id : primitive["attributes"]) visit(id);
    if (primitive.contains("targets"))
      for (const Json& target : primitive["targets"])
        for (const Json& id : target) visit(id);
  }

  const GltfFile& file_;
  GltfPacker& packer_;
  std::map<std::string, Box> boxes_;
  std::map<std::size_t, int> uses_;  ///< of accessors, by primitives that are not compressed
  std::vector<std::string> left_;
  std::size_t compressed_ = 0;
};

}  // namespace

std::vector<std::string> compress_gltf(const GltfFile& file, GltfPacker& packer, Compression compression) {
  switch (compression) {
    case Compression::none: return {};
    case Compression::meshopt: return MeshoptWriter(file, packer).write();
    case Compression::draco: return DracoWriter(file, packer).write();
  }
  return {};
}

Bytes compressed_glb(Bytes glb, const std::string& name, Compression compression) {
  Document plain;
  plain.format = Document::Format::glb;
  plain.name = name;
  plain.bytes = std::move(glb);
  const GltfFile file(plain);
  GltfPacker packer(file);
  compress_gltf(file, packer, compression);
  return packer.packed(Document::Format::glb, name).bytes;
}

}  // namespace mq

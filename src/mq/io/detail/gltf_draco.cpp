// Draco's decoder makes its tables for as many triangles as a stream says it has. So the counts are
// read here first: after the head of 11 bytes and the metadata come, for the edgebreaker method, its
// traversal, vertices and triangles, for the sequential method triangles and points.
#include "mq/io/detail/gltf_draco.h"

#include <draco/attributes/attribute_quantization_transform.h>
#include <draco/compression/decode.h>
#include <draco/core/varint_decoding.h>
#include <draco/metadata/geometry_metadata.h>
#include <draco/metadata/metadata_decoder.h>
#include <fmt/format.h>

#include <cstring>
#include <new>
#include <stdexcept>

#include "mq/base/error.h"

namespace mq {
namespace {

/// The most triangles or points that a byte of a stream can stand for; flat grids take a tenth of a
/// byte each. A head that promises more is not to be believed.
constexpr std::uint64_t draco_expansion = 2000;

[[noreturn]] void fail_draco(const std::string& place, const std::string& what) {
  throw IoError(fmt::format("{}: compressed by Draco, and {}; the file may be damaged: export it again",
                            place, what));
}

class DracoReader {
 public:
  DracoReader(ByteView stream, const std::string& place) : stream_(stream), place_(place) {}

  DracoMesh read(const std::set<std::uint32_t>& ids) {
    check_counts();
    try {
      decode();
      for (const std::uint32_t id : ids) read_attribute(id);
      read_corners();
    } catch (const std::bad_alloc&) {
      fail_draco(place_, "what it says to hold does not fit into memory");
    } catch (const std::length_error&) {
      fail_draco(place_, "what it says to hold does not fit into memory");
    }
    return std::move(result_);
  }

 private:
  draco::DecoderBuffer buffer() const {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(stream_.data()), stream_.size());
    return buffer;
  }

  void check_counts() const {
    draco::DecoderBuffer from = buffer();
    char magic[5] = {};
    std::uint8_t major = 0, minor = 0, kind = 0, method = 0;
    std::uint16_t flags = 0;
    if (!from.Decode(magic, sizeof magic) || std::memcmp(magic, "DRACO", 5) != 0)
      fail_draco(place_, "it does not begin as Draco's streams do");
    if (!from.Decode(&major) || !from.Decode(&minor) || !from.Decode(&kind) ||
        !from.Decode(&method) || !from.Decode(&flags))
      fail_draco(place_, "it is cut short");
    if (major < 2)
      throw Unsupported(fmt::format("{}: compressed by Draco as of version {}.{}; from 2.0 it can be "
                                    "read: export it again",
                                    place_, major, minor));
    if (kind != draco::TRIANGULAR_MESH) fail_draco(place_, "it is no mesh");
    from.set_bitstream_version(std::uint16_t(major << 8 | minor));
    draco::GeometryMetadata metadata;
    if ((flags & METADATA_FLAG_MASK) != 0 &&
        !draco::MetadataDecoder().DecodeGeometryMetadata(&from, &metadata))
      fail_draco(place_, "its metadata cannot be read");
    const bool before_2_2 = minor < 2 && major == 2;
    std::uint32_t first = 0, second = 0;
    if (method == draco::MESH_EDGEBREAKER_ENCODING) {
      std::uint8_t traversal = 0;
      std::uint32_t new_vertices = 0;
      if (!from.Decode(&traversal) || (before_2_2 && !draco::DecodeVarint(&new_vertices, &from)) ||
          !draco::DecodeVarint(&first, &from) || !draco::DecodeVarint(&second, &from))
        fail_draco(place_, "it is cut short");
    } else if (before_2_2 ? !from.Decode(&first) || !from.Decode(&second)
                          : !draco::DecodeVarint(&first, &from) ||
                                !draco::DecodeVarint(&second, &from)) {
      fail_draco(place_, "it is cut short");
    }
    if (std::max(first, second) / draco_expansion > stream_.size())
      fail_draco(place_, fmt::format("{} bytes cannot hold {} triangles and vertices",
                                     stream_.size(), std::uint64_t(first) + second));
  }

  /// Positions stay on their grid, so that its step is known; they are taken off it afterwards, as
  /// the decoder itself would.
  void decode() {
    draco::DecoderBuffer from = buffer();
    draco::Decoder decoder;
    decoder.SetSkipAttributeTransform(draco::GeometryAttribute::POSITION);
    auto decoded = decoder.DecodeMeshFromBuffer(&from);
    if (!decoded.ok()) {
      const std::string said = decoded.status().error_msg_string();
      fail_draco(place_, "its decoder gives up" + (said.empty() ? "" : " (" + said + ")"));
    }
    mesh_ = std::move(decoded).value();
    if (!mesh_) fail_draco(place_, "its decoder gives up");
    result_.points = mesh_->num_points();
  }

  void read_attribute(std::uint32_t id) {
    const draco::PointAttribute* stored = mesh_->GetAttributeByUniqueId(id);
    if (!stored) fail_draco(place_, fmt::format("it has no attribute {}", id));
    draco::AttributeQuantizationTransform transform;
    std::unique_ptr<draco::PointAttribute> floats;
    const bool on_grid = stored->GetAttributeTransformData() != nullptr &&
                         transform.InitFromAttribute(*stored) && transform.quantization_bits() > 0;
    if (on_grid) {
      floats = transform_back(*stored, transform);
      result_.step = double(transform.range()) / double((1ULL << transform.quantization_bits()) - 1);
    }
    result_.attributes[id] = values_of(on_grid ? *floats : *stored, *stored);
  }

  std::unique_ptr<draco::PointAttribute> transform_back(
      const draco::PointAttribute& stored, draco::AttributeQuantizationTransform& transform) const {
    draco::GeometryAttribute kind;
    kind.Init(stored.attribute_type(), nullptr, stored.num_components(), draco::DT_FLOAT32, false,
              std::int64_t(stored.num_components()) * 4, 0);
    auto floats = std::make_unique<draco::PointAttribute>(kind);
    if (stored.data_type() != draco::DT_INT32 || !floats->Reset(stored.size()) ||
        !transform.InverseTransformAttribute(stored, floats.get()))
      fail_draco(place_, "its positions cannot be read");
    return floats;
  }

  static GltfType type_of_draco(draco::DataType type, const std::string& place) {
    switch (type) {
      case draco::DT_INT8: return GltfType::i8;
      case draco::DT_UINT8:
      case draco::DT_BOOL: return GltfType::u8;
      case draco::DT_INT16: return GltfType::i16;
      case draco::DT_UINT16: return GltfType::u16;
      case draco::DT_UINT32: return GltfType::u32;
      case draco::DT_FLOAT32: return GltfType::f32;
      default: fail_draco(place, "an attribute is of a type that glTF does not have");
    }
  }

  /// The values at each point; `map` says which those are.
  GltfValues values_of(const draco::PointAttribute& attribute, const draco::PointAttribute& map) const {
    GltfValues values;
    values.type = type_of_draco(attribute.data_type(), place_);
    values.components = attribute.num_components();
    const auto width = std::size_t(size_of(values.type));
    const std::size_t element = width * std::size_t(values.components);
    const std::size_t bytes = attribute.buffer() ? attribute.buffer()->data_size() : 0;
    const auto stride = std::size_t(attribute.byte_stride()), first = std::size_t(attribute.byte_offset());
    values.values.reserve(result_.points * std::size_t(values.components));
    for (std::uint32_t p = 0; p < result_.points; ++p) {
      if (!map.is_mapping_identity() && p >= map.indices_map_size())
        fail_draco(place_, "an attribute does not reach to its last vertex");
      const std::size_t at = first + map.mapped_index(draco::PointIndex(p)).value() * stride;
      if (at > bytes || element > bytes - at)
        fail_draco(place_, "an attribute does not reach to its last vertex");
      const auto* from = reinterpret_cast<const std::byte*>(attribute.buffer()->data()) + at;
      for (int c = 0; c < values.components; ++c)
        values.values.push_back(load_component(values.type, from + std::size_t(c) * width));
    }
    return values;
  }

  void read_corners() {
    result_.corners.reserve(3 * std::size_t(mesh_->num_faces()));
    for (std::uint32_t f = 0; f < mesh_->num_faces(); ++f)
      for (const draco::PointIndex& p : mesh_->face(draco::FaceIndex(f)))
        result_.corners.push_back(p.value());
  }

  ByteView stream_;
  const std::string& place_;
  std::unique_ptr<draco::Mesh> mesh_;
  DracoMesh result_;
};

}  // namespace

DracoMesh decode_draco(ByteView stream, const std::set<std::uint32_t>& ids, const std::string& place) {
  return DracoReader(stream, place).read(ids);
}

}  // namespace mq

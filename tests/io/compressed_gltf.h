#pragma once
/// GLB files taken apart and compressed, by the encoders of Draco and meshoptimizer themselves.

#include <draco/attributes/point_attribute.h>
#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "io/models.h"
#include "mq/io/bytes.h"
#include "mq/io/detail/gltf_container.h"

namespace mq::test {

using Json = nlohmann::json;

/// The JSON and the binary part of a GLB.
struct GltfParts {
  Json json;
  Bytes binary;
  bool has_fallback = false;

  explicit GltfParts(const std::string& glb = "") {
    if (glb.empty()) return;
    std::uint32_t length = 0;
    std::memcpy(&length, glb.data() + 12, 4);
    json = Json::parse(glb.substr(20, length));
    binary = to_bytes(std::string_view(glb).substr(20 + length + 8));
  }

  std::string glb() const { return std::string(text_of(glb_bytes(bytes_of(json.dump()), binary, {}))); }

  ByteView view(std::size_t v) const {
    const Json& view = json["bufferViews"][v];
    return ByteView(binary).subspan(view.value("byteOffset", 0), view["byteLength"]);
  }

  template <class Number>
  std::vector<Number> numbers(std::size_t accessor) const {
    const ByteView bytes = view(json["accessors"][accessor]["bufferView"]);
    std::vector<Number> all(bytes.size() / sizeof(Number));
    std::memcpy(all.data(), bytes.data(), bytes.size());
    return all;
  }

  std::size_t add_bytes(ByteView bytes) {
    pad_to_four(binary, '\0');
    binary.insert(binary.end(), bytes.begin(), bytes.end());
    json["buffers"][0]["byteLength"] = binary.size();
    return binary.size() - bytes.size();
  }

  std::size_t add_view(ByteView bytes) {
    const std::size_t at = add_bytes(bytes);
    json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", at}, {"byteLength", bytes.size()}});
    return json["bufferViews"].size() - 1;
  }

  /// The same without geometry in its buffer; pictures come first.
  GltfParts emptied() const {
    GltfParts parts;
    parts.json = json;
    parts.json["bufferViews"] = Json::array();
    if (json.contains("images"))
      for (Json& image : parts.json["images"])
        if (image.contains("bufferView")) image["bufferView"] = parts.add_view(view(image["bufferView"]));
    return parts;
  }
};

struct DracoHow {
  int method = 1;  ///< 0 sequential, 1 edgebreaker
  int bits = 14;   ///< of positions; 0: floats
  int speed = 5;
};

/// All primitives, which have POSITION, TEXCOORD_0 and indices, and may have NORMAL and TANGENT.
inline GltfParts by_draco(const GltfParts& plain, const DracoHow& how) {
  GltfParts parts = plain.emptied();
  for (Json& mesh : parts.json["meshes"])
    for (Json& primitive : mesh["primitives"]) {
      const auto corners = plain.numbers<std::uint32_t>(primitive["indices"]);
      draco::Mesh coded;
      Json ids;
      const std::size_t points = parts.json["accessors"][int(primitive["attributes"]["POSITION"])]["count"];
      coded.set_num_points(std::uint32_t(points));
      for (const auto& [name, size, type] :
           {std::tuple("POSITION", 3, draco::GeometryAttribute::POSITION),
            std::tuple("TEXCOORD_0", 2, draco::GeometryAttribute::TEX_COORD),
            std::tuple("NORMAL", 3, draco::GeometryAttribute::NORMAL),
            std::tuple("TANGENT", 4, draco::GeometryAttribute::GENERIC)}) {
        if (!primitive["attributes"].contains(name)) continue;
        const auto values = plain.numbers<float>(primitive["attributes"][name]);
        draco::GeometryAttribute attribute;
        attribute.Init(type, nullptr, std::uint8_t(size), draco::DT_FLOAT32, false, 4 * size, 0);
        const int id = coded.AddAttribute(attribute, true, std::uint32_t(points));
        for (std::uint32_t p = 0; p < points; ++p)
          coded.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(p),
                                                 values.data() + std::size_t(size) * p);
        ids[name] = coded.attribute(id)->unique_id();
      }
      for (std::size_t i = 0; i < corners.size(); i += 3) {
        draco::Mesh::Face face;
        for (std::size_t k = 0; k < 3; ++k) face[k] = draco::PointIndex(corners[i + k]);
        coded.AddFace(face);
      }
      draco::Encoder encoder;
      encoder.SetEncodingMethod(how.method);
      encoder.SetSpeedOptions(how.speed, how.speed);
      encoder.SetTrackEncodedProperties(true);
      if (how.bits > 0) {
        encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, how.bits);
        encoder.SetAttributeQuantization(draco::GeometryAttribute::TEX_COORD, 14);
        encoder.SetAttributeQuantization(draco::GeometryAttribute::NORMAL, 10);
      }
      draco::EncoderBuffer out;
      if (!encoder.EncodeMeshToBuffer(coded, &out).ok()) throw std::runtime_error("draco");
      const std::size_t view = parts.add_view(bytes_of({out.data(), out.size()}));
      primitive["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", view}, {"attributes", ids}};
      for (const auto& [name, id] : ids.items())
        parts.json["accessors"][int(primitive["attributes"][name])]["count"] = encoder.num_encoded_points();
      parts.json["accessors"][int(primitive["indices"])]["count"] = 3 * encoder.num_encoded_faces();
    }
  for (Json& accessor : parts.json["accessors"]) accessor.erase("bufferView");
  parts.json["extensionsUsed"] = parts.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  return parts;
}

struct MeshoptHow {
  bool quantised = true;     ///< positions and texture coordinates as 16-bit integers
  bool exponential = false;  ///< positions by the filter EXPONENTIAL, if they are not quantised
  bool sequence = false;     ///< indices as a sequence, not as triangles
};

/// A view whose bytes are `stream`; in the fallback buffer 1, which has none, they would have others.
inline std::size_t add_meshopt(GltfParts& parts, const std::vector<unsigned char>& stream,
                               const char* mode, std::size_t count, std::size_t stride,
                               const char* filter = "NONE") {
  Json& fallback = parts.json["buffers"][1];
  if (!fallback.is_object())
    fallback = {{"byteLength", 0}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}};
  const std::size_t at = fallback["byteLength"];
  fallback["byteLength"] = at + count * stride;
  const std::size_t compressed = parts.add_bytes(std::as_bytes(std::span(stream)));
  Json view = {{"buffer", 1}, {"byteOffset", at}, {"byteLength", count * stride}};
  if (mode == std::string("ATTRIBUTES")) view["byteStride"] = stride;
  view["extensions"]["EXT_meshopt_compression"] = {
      {"buffer", 0},     {"byteOffset", compressed}, {"byteLength", stream.size()}, {"count", count},
      {"byteStride", stride}, {"mode", mode},        {"filter", filter}};
  parts.json["bufferViews"].push_back(view);
  return parts.json["bufferViews"].size() - 1;
}

template <class Element>
std::vector<unsigned char> meshopt_vertices(const std::vector<Element>& elements) {
  std::vector<unsigned char> stream(meshopt_encodeVertexBufferBound(elements.size(), sizeof(Element)));
  stream.resize(meshopt_encodeVertexBuffer(stream.data(), stream.size(), elements.data(),
                                           elements.size(), sizeof(Element)));
  return stream;
}

/// Positions p are stored as (p + 2) · 16383 where quantised: a node's translation and scale undo it.
inline constexpr double meshopt_grid = 16383;

inline GltfParts by_meshopt(const GltfParts& plain, const MeshoptHow& how) {
  GltfParts parts = plain.emptied();
  meshopt_encodeIndexVersion(1);
  for (Json& mesh : parts.json["meshes"])
    for (Json& primitive : mesh["primitives"]) {
      Json& accessors = parts.json["accessors"];
      const auto positions = plain.numbers<float>(primitive["attributes"]["POSITION"]);
      const auto uvs = plain.numbers<float>(primitive["attributes"]["TEXCOORD_0"]);
      const auto corners = plain.numbers<std::uint32_t>(primitive["indices"]);
      const std::size_t points = positions.size() / 3;
      Json& position = accessors[int(primitive["attributes"]["POSITION"])];
      Json& uv = accessors[int(primitive["attributes"]["TEXCOORD_0"])];
      if (how.quantised) {
        std::vector<std::array<std::uint16_t, 4>> p(points);
        std::vector<std::array<std::uint16_t, 2>> t(points);
        for (std::size_t i = 0; i < points; ++i) {
          for (std::size_t k = 0; k < 3; ++k)
            p[i][k] = std::uint16_t(std::lround((positions[3 * i + k] + 2) * meshopt_grid));
          for (std::size_t k = 0; k < 2; ++k)
            t[i][k] = std::uint16_t(std::lround(uvs[2 * i + k] * 65535));
        }
        position["bufferView"] = add_meshopt(parts, meshopt_vertices(p), "ATTRIBUTES", points, 8);
        position["componentType"] = uv["componentType"] = 5123;
        uv["bufferView"] = add_meshopt(parts, meshopt_vertices(t), "ATTRIBUTES", points, 4);
        uv["normalized"] = true;
      } else if (how.exponential) {
        std::vector<std::array<std::int32_t, 3>> p(points);
        meshopt_encodeFilterExp(p.data(), points, 12, 15, positions.data());
        position["bufferView"] =
            add_meshopt(parts, meshopt_vertices(p), "ATTRIBUTES", points, 12, "EXPONENTIAL");
      } else {
        std::vector<std::array<float, 3>> p(points);
        std::memcpy(p.data(), positions.data(), 12 * points);
        position["bufferView"] = add_meshopt(parts, meshopt_vertices(p), "ATTRIBUTES", points, 12);
      }
      if (!how.quantised) {
        std::vector<std::array<float, 2>> t(points);
        std::memcpy(t.data(), uvs.data(), 8 * points);
        uv["bufferView"] = add_meshopt(parts, meshopt_vertices(t), "ATTRIBUTES", points, 8);
      }
      std::vector<unsigned char> stream(how.sequence
                                            ? meshopt_encodeIndexSequenceBound(corners.size(), points)
                                            : meshopt_encodeIndexBufferBound(corners.size(), points));
      stream.resize(how.sequence ? meshopt_encodeIndexSequence(stream.data(), stream.size(),
                                                               corners.data(), corners.size())
                                 : meshopt_encodeIndexBuffer(stream.data(), stream.size(),
                                                             corners.data(), corners.size()));
      accessors[int(primitive["indices"])]["bufferView"] =
          add_meshopt(parts, stream, how.sequence ? "INDICES" : "TRIANGLES", corners.size(), 4);
    }
  if (how.quantised)
    for (Json& node : parts.json["nodes"]) {
      node["translation"] = {-2, -2, -2};
      node["scale"] = {1 / meshopt_grid, 1 / meshopt_grid, 1 / meshopt_grid};
    }
  parts.json["extensionsRequired"] = {"EXT_meshopt_compression"};
  if (how.quantised) parts.json["extensionsRequired"].push_back("KHR_mesh_quantization");
  parts.json["extensionsUsed"] = parts.json["extensionsRequired"];
  return parts;
}

/// The frame of the tube at a point: normal, tangent and handedness, which differs from place to place.
inline std::array<float, 8> tube_frame(double x, double y) {
  const double r = std::hypot(x, y);
  return {float(x / r), float(y / r), 0, 0, float(-y / r), float(x / r), 0, y > 0.1 ? 1.0F : -1.0F};
}

/// tube_frame at the vertices of the first primitive of `plain`.
inline std::vector<std::array<float, 8>> tube_frames(const GltfParts& plain) {
  const auto p = plain.numbers<float>(plain.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"]);
  std::vector<std::array<float, 8>> frames;
  for (std::size_t i = 0; i < p.size(); i += 3) frames.push_back(tube_frame(p[i], p[i + 1]));
  return frames;
}

inline void add_frame_accessor(GltfParts& parts, const char* name, std::size_t view, int type,
                               std::size_t count) {
  parts.json["accessors"].push_back({{"bufferView", view},
                                     {"componentType", type},
                                     {"normalized", type != 5126},
                                     {"count", count},
                                     {"type", name == std::string("NORMAL") ? "VEC3" : "VEC4"}});
  parts.json["meshes"][0]["primitives"][0]["attributes"][name] = parts.json["accessors"].size() - 1;
}

/// The tube with NORMAL and TANGENT.
inline GltfParts with_frames(GltfParts plain) {
  const auto frames = tube_frames(plain);
  std::vector<float> normals, tangents;
  for (const auto& frame : frames) {
    normals.insert(normals.end(), frame.begin(), frame.begin() + 3);
    tangents.insert(tangents.end(), frame.begin() + 4, frame.end());
  }
  for (const auto& [name, values] : {std::pair("NORMAL", &normals), {"TANGENT", &tangents}})
    add_frame_accessor(plain, name, plain.add_view(std::as_bytes(std::span(*values))), 5126, frames.size());
  return plain;
}

/// `parts`, the tube compressed by meshopt, with the frames that gltfpack would write: bytes, by the
/// filter OCTAHEDRAL.
inline GltfParts with_octahedral_frames(GltfParts parts, const GltfParts& plain) {
  const auto frames = tube_frames(plain);
  for (const auto& [name, first] : {std::pair("NORMAL", 0), {"TANGENT", 4}}) {
    std::vector<std::array<float, 4>> values(frames.size());
    for (std::size_t i = 0; i < frames.size(); ++i)
      for (std::size_t k = 0; k < 4; ++k) values[i][k] = frames[i][std::size_t(first) + k];
    std::vector<std::array<std::int8_t, 4>> bytes(frames.size());
    meshopt_encodeFilterOct(bytes.data(), frames.size(), 4, 8, values[0].data());
    const std::size_t view =
        add_meshopt(parts, meshopt_vertices(bytes), "ATTRIBUTES", frames.size(), 4, "OCTAHEDRAL");
    add_frame_accessor(parts, name, view, 5120, frames.size());
  }
  return parts;
}

/// A tube closed over a seam, its left and right halves of two textures: around 2 π, along 1.
inline Model tube(int around, int along, bool two_textures) {
  Model model;
  for (int j = 0; j <= along; ++j)
    for (int i = 0; i <= around; ++i) {
      const double angle = 2 * std::numbers::pi * i / around;
      if (i < around)
        model.mesh.positions.emplace_back(float(std::cos(angle)), float(std::sin(angle)),
                                          float(double(j) / along + 0.05 * std::cos(3 * angle)));
      model.mesh.uvs.emplace_back(float(0.05 + 0.9 * i / around), float(0.05 + 0.9 * j / along));
    }
  const auto vertex = [&](int i, int j) { return j * around + i % around; };
  const auto uv = [&](int i, int j) { return j * (around + 1) + i; };
  for (int j = 0; j < along; ++j)
    for (int i = 0; i < around; ++i) {
      model.mesh.triangles.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)});
      model.mesh.triangles.push_back({vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
      model.mesh.corner_uvs.push_back({uv(i, j), uv(i + 1, j), uv(i + 1, j + 1)});
      model.mesh.corner_uvs.push_back({uv(i, j), uv(i + 1, j + 1), uv(i, j + 1)});
      const int texture = two_textures && j >= along / 2;
      model.mesh.textures.insert(model.mesh.textures.end(), 2, texture);
    }
  model.textures.push_back(ramp_texture("a.png"));
  if (two_textures) model.textures.push_back(ramp_texture("b.png", 5, 4));
  return model;
}

inline Vector2 uv_middle(const Mesh& mesh, int t) {
  return (mesh.uv(t, 0) + mesh.uv(t, 1) + mesh.uv(t, 2)) / 3;
}

/// Each triangle of `a` is one of `b`, corners in the same order around it, and none is two of `a`'s.
inline void expect_same_triangles(const Mesh& a, const Mesh& b, double position_error, double uv_error) {
  ASSERT_EQ(a.triangle_count(), b.triangle_count());
  std::vector<char> used(std::size_t(b.triangle_count()));
  for (int t = 0; t < a.triangle_count(); ++t) {
    int best = 0;
    double distance = 1e300;
    for (int s = 0; s < b.triangle_count(); ++s)
      if (const double d = (uv_middle(a, t) - uv_middle(b, s)).norm();
          d < distance && a.texture(t) == b.texture(s))
        distance = d, best = s;
    EXPECT_FALSE(used[std::size_t(best)]++);
    int turn = 0;
    for (int k = 1; k < 3; ++k)
      if ((b.uv(best, k) - a.uv(t, 0)).norm() < (b.uv(best, turn) - a.uv(t, 0)).norm()) turn = k;
    for (int k = 0; k < 3; ++k) {
      EXPECT_LE((a.position(t, k) - b.position(best, (turn + k) % 3)).cwiseAbs().maxCoeff(),
                position_error);
      EXPECT_LE((a.uv(t, k) - b.uv(best, (turn + k) % 3)).cwiseAbs().maxCoeff(), uv_error);
    }
  }
}

}  // namespace mq::test

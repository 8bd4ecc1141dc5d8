#pragma once
/// glTF scenes made by hand.

#include <nlohmann/json.hpp>

#include <span>
#include <string>
#include <vector>

#include "mq/base/error.h"
#include "mq/io/detail/gltf.h"
#include "mq/io/uri.h"

namespace mq::test {

/// A scene of one triangle in JSON, its buffer as data, to be varied by a test.
class Scene {
 public:
  Scene() {
    json["asset"] = {{"version", "2.0"}};
    json["scenes"] = {{{"nodes", {0}}}};
    json["nodes"] = {{{"mesh", 0}}};
    json["meshes"] = {{{"primitives", {{{"attributes", nlohmann::json::object()}}}}}};
    attributes()["POSITION"] = add<float>("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
    attributes()["TEXCOORD_0"] = add<float>("VEC2", {0, 0.25f, 1, 0.25f, 0, 1});
  }

  nlohmann::json& primitive() { return json["meshes"][0]["primitives"][0]; }
  nlohmann::json& attributes() { return primitive()["attributes"]; }

  template <class Number>
  std::size_t view(std::vector<Number> numbers) {
    while (data.size() % 4) data.push_back(std::byte(0));
    const auto bytes = std::as_bytes(std::span(numbers));
    json["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", data.size()}, {"byteLength", bytes.size()}});
    data.insert(data.end(), bytes.begin(), bytes.end());
    return json["bufferViews"].size() - 1;
  }

  template <class Number>
  std::size_t add(const std::string& type, std::vector<Number> numbers, bool normalized = false) {
    const std::size_t components = type == "SCALAR" ? 1 : std::size_t(type.back() - '0');
    json["accessors"].push_back({{"bufferView", view(numbers)},
                                 {"componentType", number_type(Number())},
                                 {"count", numbers.size() / components},
                                 {"type", type}});
    if (normalized) json["accessors"].back()["normalized"] = true;
    return json["accessors"].size() - 1;
  }

  /// Gives the primitive a material whose texture is this image.
  void paint(nlohmann::json image) {
    json["images"].push_back(std::move(image));
    json["textures"] = {{{"source", 0}}};
    json["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}};
    primitive()["material"] = 0;
  }

  std::string gltf() const {
    nlohmann::json all = json;
    if (!all.contains("buffers"))
      all["buffers"] = {
          {{"byteLength", data.size()}, {"uri", data_uri("application/gltf-buffer", data)}}};
    return all.dump(2);
  }

  MeshFile read() const {
    Document document;
    document.format = Document::Format::gltf;
    document.name = "a.gltf";
    document.bytes = to_bytes(gltf());
    return read_gltf(document);
  }

  std::string refusal() const {
    try {
      read();
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }

  nlohmann::json json;
  Bytes data;

 private:
  static int number_type(std::int8_t) { return 5120; }
  static int number_type(std::uint8_t) { return 5121; }
  static int number_type(std::int16_t) { return 5122; }
  static int number_type(std::uint16_t) { return 5123; }
  static int number_type(std::uint32_t) { return 5125; }
  static int number_type(float) { return 5126; }
};

}  // namespace mq::test

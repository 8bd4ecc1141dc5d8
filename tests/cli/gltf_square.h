#pragma once
/// A glTF square of two UV sets, whose materials a test chooses.

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "cli/models.h"
#include "mq/io/bytes.h"
#include "mq/io/uri.h"

namespace mq::test {

/// Corners of a square from a to b in texture coordinates, as glTF counts v.
inline std::vector<float> square_uvs(float a, float b) {
  return {a, 1 - a, b, 1 - a, b, 1 - b, a, 1 - b};
}

/// A unit square of one chart: 0.9² on set 0, 0.8² on set 1. `pictures` are images and textures alike.
inline nlohmann::json square_gltf(const std::vector<std::string>& pictures,
                                  const nlohmann::json& material) {
  using Json = nlohmann::json;
  Bytes data;
  Json gltf;
  gltf["asset"] = {{"version", "2.0"}, {"generator", "by hand"}};
  const auto add = [&](const std::vector<float>& numbers, const std::string& type) {
    const ByteView bytes = std::as_bytes(std::span(numbers));
    gltf["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", data.size()}, {"byteLength", bytes.size()}});
    gltf["accessors"].push_back({{"bufferView", gltf["bufferViews"].size() - 1},
                                 {"componentType", 5126},
                                 {"count", 4},
                                 {"type", type}});
    data.insert(data.end(), bytes.begin(), bytes.end());
    return gltf["accessors"].size() - 1;
  };
  Json attributes;
  attributes["POSITION"] = add({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, "VEC3");
  attributes["TEXCOORD_0"] = add(square_uvs(0.05F, 0.95F), "VEC2");
  attributes["TEXCOORD_1"] = add(square_uvs(0.1F, 0.9F), "VEC2");
  gltf["meshes"] = {{{"primitives", {{{"attributes", attributes}, {"mode", 6}, {"material", 0}}}}}};
  gltf["nodes"] = {{{"mesh", 0}}};
  gltf["scenes"] = {{{"nodes", {0}}}};
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    gltf["images"].push_back({{"uri", pictures[i]}});
    gltf["textures"].push_back({{"source", i}});
  }
  gltf["materials"] = {material};
  gltf["buffers"] = {{{"byteLength", data.size()}, {"uri", data_uri("application/octet-stream", data)}}};
  return gltf;
}

/// lightmap.gltf, whose only picture, light.png of 64², is the occlusion on set 1.
inline void write_lightmap(const Folder& folder) {
  write_bytes(folder / "lightmap.gltf",
              square_gltf({"light.png"}, {{"occlusionTexture", {{"index", 0}, {"texCoord", 1}}}}).dump(1));
  write_image(folder / "light.png", busy_picture(64, 64));
}

/// pbr.gltf with base colour, metallic-roughness, normal and emissive, each a picture of its own.
inline void write_pbr(const Folder& folder) {
  const nlohmann::json material = {
      {"pbrMetallicRoughness",
       {{"baseColorTexture", {{"index", 0}}}, {"metallicRoughnessTexture", {{"index", 1}}}}},
      {"normalTexture", {{"index", 2}, {"scale", 0.5}}},
      {"emissiveTexture", {{"index", 3}, {"texCoord", 1}}}};
  write_bytes(folder / "pbr.gltf",
              square_gltf({"g_color.png", "g_orm.png", "g_n.png", "g_glow.png"}, material).dump(1));
  write_image(folder / "g_color.png", busy_picture(64, 64));
  write_image(folder / "g_orm.png", busy_picture(32, 32));
  Image<float> flat(64, 64, 3);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      for (int c = 0; c < 3; ++c) flat(x, y, c) = c == 2 ? 1.0F : 128.0F / 255;
  write_image(folder / "g_n.png", flat);
  write_image(folder / "g_glow.png", busy_picture(16, 16));
}

/// The same square as NAME.obj with NAME.mtl, of one chart from a to b, painted with a picture.
inline void write_square_obj(const Folder& folder, const std::string& name, const std::string& a,
                             const std::string& b, const std::string& picture) {
  const auto vt = [](const std::string& u, const std::string& v) {
    return "vt " + u + " " + v + "\n";
  };
  write_bytes(folder / (name + ".obj"),
              "mtllib " + name + ".mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n" + vt(a, a) +
                  vt(b, a) + vt(b, b) + vt(a, b) + "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n");
  write_bytes(folder / (name + ".mtl"), "newmtl m\nmap_Kd " + picture + "\n");
}

}  // namespace mq::test

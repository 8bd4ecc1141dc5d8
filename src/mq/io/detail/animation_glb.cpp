#include "mq/io/detail/animation_glb.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "mq/io/detail/animation_floats.h"
#include "mq/io/detail/gltf_container.h"
#include "mq/io/image_file.h"

namespace mq {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr int float_type = 5126, index_type = 5125, byte_type = 5121, array_target = 34962, element_target = 34963;

/// glTF's vertices: equal corners of a segment are one.
struct Corners {
  std::vector<int> vertices;  // of the segment
  std::vector<Vector2> uvs;   // empty: none
  std::vector<std::uint32_t> indices;

  explicit Corners(const EvolvingSegment& segment) {
    std::map<std::pair<int, int>, std::uint32_t> ids;
    const bool textured = !segment.corner_uvs.empty();
    for (std::size_t t = 0; t < segment.triangles.size(); ++t)
      for (int k = 0; k < 3; ++k) {
        const int vertex = segment.triangles[t][k];
        const int uv = textured ? segment.corner_uvs[t][k] : -1;
        const auto [place, is_new] = ids.try_emplace({vertex, uv}, std::uint32_t(vertices.size()));
        if (is_new) {
          vertices.push_back(vertex);
          if (textured) uvs.push_back(uv >= 0 ? segment.uvs[uv] : Vector2(0, 0));
        }
        indices.push_back(place->second);
      }
  }
};

class Animation {
 public:
  Animation(const EvolvingReader& reader, const AnimationPart& part, const PictureOfFrame& pictures)
      : reader_(reader), rate_(part.frames_per_second), pictures_(pictures) {
    // Times are in seconds from 0; this says what the frames' numbers were.
    json_["asset"] = {{"version", "2.0"},
                      {"generator", "Marquetry"},
                      {"extras", {{"first_frame", reader.frames()[part.first].number}, {"frames_per_second", rate_}}}};
    json_["scene"] = 0;
    json_["scenes"] = OrderedJson::array({{{"nodes", OrderedJson::array()}}});
    json_["animations"] = OrderedJson::array({{{"samplers", OrderedJson::array()}, {"channels", OrderedJson::array()}}});
  }

  /// Frames [begin, end) of one segment; the whole is [first, stop).
  void add_segment(int begin, int end, int first, int stop) {
    const EvolvingSegment segment = reader_.segment(reader_.frames()[begin].segment);
    const Corners corners(segment);
    const std::vector<Vector3> base = reader_.positions(begin);
    OrderedJson primitive = {{"attributes", {{"POSITION", add_points(corners, begin, base, nullptr)}}}};
    if (!corners.uvs.empty()) {
      std::vector<float> values;
      for (const Vector2& uv : corners.uvs) {
        values.push_back(float(uv.x()));
        values.push_back(float(1 - uv.y()));  // glTF counts v from the top
      }
      primitive["attributes"]["TEXCOORD_0"] = add_floats(values, "VEC2", array_target);
    }
    Bytes indices;
    for (const std::uint32_t index : corners.indices) append_raw(indices, index);
    primitive["indices"] =
        add_accessor(indices, corners.indices.size(), index_type, "SCALAR", element_target);
    if (Image<float> picture = pictures_ ? pictures_(begin) : Image<float>(); !picture.values().empty())
      primitive["material"] = add_picture(std::move(picture));
    for (int f = begin + 1; f < end; ++f)
      primitive["targets"].push_back({{"POSITION", add_points(corners, f, reader_.positions(f), &base)}});
    OrderedJson mesh = {{"primitives", OrderedJson::array({primitive})}};
    if (end - begin > 1) mesh["weights"] = std::vector<float>(std::size_t(end - begin - 1), 0);
    const int node = int(json_["nodes"].size());
    json_["scenes"][0]["nodes"].push_back(node);
    json_["nodes"].push_back({{"mesh", json_["meshes"].size()}});
    // At rest one segment is shown too.
    if (begin > first) json_["nodes"].back()["scale"] = {0, 0, 0};
    json_["meshes"].push_back(mesh);
    if (end - begin > 1) animate_weights(node, begin, end, first);
    if (begin > first || end < stop) animate_presence(node, begin, end, first, stop);
  }

  Bytes bytes() {
    if (json_["animations"][0]["channels"].empty()) json_.erase("animations");
    json_["buffers"].push_back({{"byteLength", buffer_.size()}});
    return glb_bytes(to_bytes(json_.dump()), buffer_, {});
  }

 private:
  float time(int frame, int first) const {
    return float((reader_.frames()[frame].number - reader_.frames()[first].number) / rate_);
  }

  void animate_weights(int node, int begin, int end, int first) {
    // Every frame has a weight for every other, 0 or 1: as bytes, of which 255 is 1.
    std::vector<float> times;
    Bytes weights;
    for (int f = begin; f < end; ++f) {
      times.push_back(time(f, first));
      for (int target = begin + 1; target < end; ++target) weights.push_back(target == f ? std::byte(255) : std::byte(0));
    }
    const std::size_t output = add_accessor(weights, weights.size(), byte_type, "SCALAR", 0);
    json_["accessors"][output]["normalized"] = true;
    add_channel(node, "weights", "LINEAR", times, output);
  }

  void animate_presence(int node, int begin, int end, int first, int stop) {
    std::vector<float> times, scales;
    const auto add = [&](int frame, float scale) {
      times.push_back(time(frame, first));
      for (int k = 0; k < 3; ++k) scales.push_back(scale);
    };
    if (begin > first) add(first, 0);
    add(begin, 1);
    if (end < stop) add(end, 0);
    add_channel(node, "scale", "STEP", times, add_floats(scales, "VEC3", 0));
  }

  void add_channel(int node, const char* path, const char* how, const std::vector<float>& times,
                   std::size_t output) {
    OrderedJson& animation = json_["animations"][0];
    const std::size_t input = add_floats(times, "SCALAR", 0);
    json_["accessors"][input]["min"] = OrderedJson::array({times.front()});
    json_["accessors"][input]["max"] = OrderedJson::array({times.back()});
    animation["channels"].push_back(
        {{"sampler", animation["samplers"].size()}, {"target", {{"node", node}, {"path", path}}}});
    animation["samplers"].push_back(
        {{"input", input}, {"interpolation", how}, {"output", output}});
  }

  /// Positions in metres, or how far they are from `base`, with their bounds.
  std::size_t add_points(const Corners& corners, int frame, const std::vector<Vector3>& positions,
                         const std::vector<Vector3>* base) {
    std::vector<float> values;
    Eigen::Vector3f least = Eigen::Vector3f::Constant(std::numeric_limits<float>::max());
    Eigen::Vector3f most = -least;
    for (const int v : corners.vertices) {
      const Vector3 place = base ? Vector3(positions[v] - (*base)[v]) : positions[v];
      const Eigen::Vector3f x = as_floats(reader_.metres_per_unit() * place, reader_, frame, "glTF");
      values.insert(values.end(), {x.x(), x.y(), x.z()});
      least = least.cwiseMin(x);
      most = most.cwiseMax(x);
    }
    const std::size_t id = add_floats(values, "VEC3", array_target);
    json_["accessors"][id]["min"] = {least.x(), least.y(), least.z()};
    json_["accessors"][id]["max"] = {most.x(), most.y(), most.z()};
    return id;
  }

  std::size_t add_floats(const std::vector<float>& values, const char* shape, int target) {
    Bytes bytes;
    for (const float value : values) append_raw(bytes, value);
    const std::size_t size = shape == std::string("VEC3")   ? 3
                             : shape == std::string("VEC2") ? 2
                                                            : 1;
    return add_accessor(bytes, values.size() / size, float_type, shape, target);
  }

  std::size_t add_accessor(const Bytes& bytes, std::size_t count, int type, const char* shape,
                           int target) {
    json_["accessors"].push_back({{"bufferView", add_view(bytes, target)},
                                  {"componentType", type},
                                  {"count", count},
                                  {"type", shape}});
    return json_["accessors"].size() - 1;
  }

  /// The material that shows a picture.
  std::size_t add_picture(Image<float> pixels) {
    Texture texture;
    texture.pixels = std::move(pixels);
    const std::size_t image = json_["images"].size();
    json_["images"].push_back({{"bufferView", add_view(texture_bytes(texture, "png").bytes, 0)},
                               {"mimeType", "image/png"}});
    json_["textures"].push_back({{"source", image}});
    json_["materials"].push_back({{"pbrMetallicRoughness",
                                   {{"baseColorTexture", {{"index", image}}},
                                    {"metallicFactor", 0},
                                    {"roughnessFactor", 1}}}});
    return image;
  }

  std::size_t add_view(const Bytes& bytes, int target) {
    pad_to_four(buffer_, '\0');
    OrderedJson view = {{"buffer", 0}, {"byteOffset", buffer_.size()}, {"byteLength", bytes.size()}};
    if (target > 0) view["target"] = target;
    json_["bufferViews"].push_back(view);
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
    return json_["bufferViews"].size() - 1;
  }

  const EvolvingReader& reader_;
  double rate_;
  const PictureOfFrame& pictures_;
  OrderedJson json_;
  Bytes buffer_;
};

}  // namespace

Bytes animation_glb(const EvolvingReader& reader, const AnimationPart& part, const PictureOfFrame& pictures,
                    const Progress& progress) {
  Animation animation(reader, part, pictures);
  for (const FrameRange& range : ranges_of_segments(reader, part)) {
    animation.add_segment(range.begin, range.end, part.first, part.last + 1);
    progress.at(double(range.end - part.first) / (part.last + 1 - part.first));
  }
  return animation.bytes();
}

}  // namespace mq

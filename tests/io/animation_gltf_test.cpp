// glTF of other programs that moves: what of it is taken, and what is said of the rest.
#include <string>

#include "io/animations.h"
#include "mq/io/bytes.h"
#include "mq/io/image_file.h"
#include "mq/io/model.h"
#include "mq/io/uri.h"

namespace mq {
namespace {

class GltfAnimation : public AnimationTest {};

/// A triangle that morphs over half a second and a second, with its numbers in the file.
std::string morphing_gltf(const std::string& nodes, const std::string& channels, const std::string& samplers) {
  Bytes bytes;
  for (const float value : {0.F, 0.F,  0.F, 1.F, 0.F, 0.F,  0.F, 1.F, 0.F,  // positions
                            0.F, 0.F,  1.F, 0.F, 0.F, 1.F,  0.F, 0.F, 2.F,  // differences
                            0.F, 0.5F, 1.F, 0.F, 1.F, 0.5F,                 // times, weights
                            0.F, 0.F,  0.F, 1.F, 0.F, 0.F,  1.F, 0.F})      // rotations
    append_raw(bytes, value);
  const std::string size = std::to_string(bytes.size());
  return R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[)" + nodes +
         R"(],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"targets":[{"POSITION":1}]}]}],
    "animations":[{"channels":[)" +
         channels + R"(],"samplers":[)" + samplers + R"(]}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},
      {"bufferView":0,"byteOffset":36,"componentType":5126,"count":3,"type":"VEC3"},
      {"bufferView":0,"byteOffset":72,"componentType":5126,"count":3,"type":"SCALAR"},
      {"bufferView":0,"byteOffset":84,"componentType":5126,"count":3,"type":"SCALAR"},
      {"bufferView":0,"byteOffset":72,"componentType":5126,"count":2,"type":"SCALAR"},
      {"bufferView":0,"byteOffset":96,"componentType":5126,"count":2,"type":"VEC4"}],
    "bufferViews":[{"buffer":0,"byteLength":)" +
         size + R"(}],"buffers":[{"byteLength":)" + size + R"(,"uri":")" +
         data_uri("application/octet-stream", bytes) + R"("}]})";
}

constexpr const char* weights_channel = R"({"sampler":0,"target":{"node":0,"path":"weights"}})";
constexpr const char* weights_sampler = R"({"input":2,"output":3})";

TEST_F(GltfAnimation, TakesMorphingGltfOfOtherPrograms) {
  const OpenAnimation found =
      open_animation(put("morph.gltf", morphing_gltf(R"({"mesh":0,"translation":[0,0,5],"scale":[2,2,2]})",
                                                     weights_channel, weights_sampler)));
  ASSERT_EQ(found.reader.frames().size(), 3U);
  EXPECT_EQ(found.frames_per_second, 2);
  EXPECT_THAT(found.notes, IsEmpty());
  EXPECT_EQ(found.reader.positions(0)[2], Vector3(0, 2, 5));
  EXPECT_EQ(found.reader.positions(1)[2], Vector3(0, 2, 9));
  EXPECT_EQ(found.reader.positions(2)[2], Vector3(0, 2, 7));  // half of the difference
  EXPECT_EQ(found.reader.frames()[2].number, 2);
}

TEST_F(GltfAnimation, LeavesOutWhatStandsStillInGltf) {
  const std::string turned =
      weights_channel + std::string(R"(,{"sampler":1,"target":{"node":1,"path":"rotation"}})");
  const std::string samplers = weights_sampler + std::string(R"(,{"input":4,"output":5})");
  std::string text = morphing_gltf(R"({"mesh":0},{"camera":0})", turned, samplers);
  EXPECT_THAT(open_animation(put("camera.gltf", text)).notes, IsEmpty());  // nothing that is seen turns
  const std::string nodes = R"("nodes":[0])";
  text = morphing_gltf(R"({"mesh":0},{"mesh":0})", weights_channel, weights_sampler);
  EXPECT_THAT(
      open_animation(put("two.gltf", text.replace(text.find(nodes), nodes.size(), R"("nodes":[0,1])"))).notes,
      ElementsAre(HasSubstr("1 mesh")));
}

TEST_F(GltfAnimation, SaysWhatOfGltfItDoesNotTake) {
  const std::string turned = R"({"sampler":0,"target":{"node":0,"path":"rotation"}})";
  EXPECT_THAT(refusal("a.gltf", morphing_gltf(R"({"mesh":0})", turned, R"({"input":4,"output":5})")),
              AllOf(HasSubstr("rotation"), HasSubstr("nodes[0]"), HasSubstr("morph targets")));
  EXPECT_THAT(refusal("a.gltf", morphing_gltf(R"({"mesh":0,"skin":0})", weights_channel, weights_sampler)),
              AllOf(HasSubstr("bones"), HasSubstr("frame_%04d.ply")));
  EXPECT_THAT(refusal("a.gltf", morphing_gltf(R"({"mesh":0})", weights_channel,
                                              R"({"input":2,"output":3,"interpolation":"CUBICSPLINE"})")),
              AllOf(HasSubstr("a.gltf, animations[0].channels[0]"), HasSubstr("CUBICSPLINE")));
  EXPECT_THAT(refusal("a.gltf", morphing_gltf(R"({"mesh":0})", weights_channel, R"({"input":4,"output":3})")),
              HasSubstr("3 values at 2 times"));
  EXPECT_THAT(refusal("a.gltf", morphing_gltf(R"({"camera":0})", "", "")), HasSubstr("no mesh"));
  const std::string twice = weights_channel + std::string(",") + weights_channel;
  EXPECT_THAT(refusal("a.gltf", morphing_gltf(R"({"mesh":0})", twice, weights_sampler)),
              AllOf(HasSubstr("a.gltf, animations[0].channels[1]"), HasSubstr("\"weights\" of nodes[0]"),
                    HasSubstr("animations[0].channels[0] does")));
}

TEST_F(GltfAnimation, SaysWhatOfGltfIsNotSeen) {
  // A scale that steps from 1 to 0 after a second.
  std::string text =
      morphing_gltf(R"({"mesh":0},{"camera":0})",
                    weights_channel + std::string(R"(,{"sampler":1,"target":{"node":0,"path":"scale"}})"),
                    weights_sampler + std::string(R"(,{"input":4,"output":6,"interpolation":"STEP"})"));
  const std::string last = R"({"bufferView":0,"byteOffset":96,"componentType":5126,"count":2,"type":"VEC4"})";
  // Bytes 12 to 35: (1, 0, 0) and (0, 1, 0), of which x is what is looked at.
  text.replace(text.find(last), last.size(),
               last + R"(,{"bufferView":0,"byteOffset":12,"componentType":5126,"count":2,"type":"VEC3"})");
  const std::string nodes = R"("nodes":[0])";
  text.replace(text.find(nodes), nodes.size(), R"("nodes":[0,1])");
  const OpenAnimation found = open_animation(put("hides.gltf", text));
  EXPECT_EQ(found.reader.frames().size(), 1U);
  EXPECT_THAT(found.notes,
              ElementsAre(AllOf(HasSubstr("2 of 3 frames"), HasSubstr("the first at second 0.5, the last at 1"))));
  EXPECT_THAT(found.remarks, ElementsAre(HasSubstr("1 camera")));
}

/// `text` with the accessor of a visibility at two keys, shown and then not, as the last one.
std::string with_visibility(std::string text) {
  const std::string last = R"({"bufferView":0,"byteOffset":96,"componentType":5126,"count":2,"type":"VEC4"})";
  // Bytes 15 and 16: the highest of 1.F, 0x3f, and the lowest of 0.F.
  return text.replace(text.find(last), last.size(),
                      last + R"(,{"bufferView":0,"byteOffset":15,"componentType":5121,"count":2,"type":"SCALAR"})");
}

std::string pointing(const std::string& pointer, int sampler) {
  return R"({"sampler":)" + std::to_string(sampler) +
         R"(,"target":{"path":"pointer","extensions":{"KHR_animation_pointer":{"pointer":")" + pointer + R"("}}}})";
}

TEST_F(GltfAnimation, LeavesOutWhatIsHidden) {
  const std::string hidden = R"({"mesh":0},{"extensions":{"KHR_node_visibility":{"visible":false}},"children":[2]},)"
                             R"({"mesh":0})";
  std::string text = morphing_gltf(hidden, weights_channel, weights_sampler);
  const std::string nodes = R"("nodes":[0])";
  text.replace(text.find(nodes), nodes.size(), R"("nodes":[0,1])");
  const OpenAnimation found = open_animation(put("hidden.gltf", text));
  EXPECT_THAT(found.notes, IsEmpty());
  EXPECT_THAT(found.remarks, ElementsAre(AllOf(HasSubstr("nodes[2] is hidden"), HasSubstr("KHR_node_visibility"))));
  EXPECT_THAT(read_model(folder / "hidden.gltf").notes, Contains(HasSubstr("KHR_node_visibility")));
  EXPECT_EQ(read_model(folder / "hidden.gltf").mesh.triangle_count(), 1);
}

TEST_F(GltfAnimation, FollowsPointersToNodes) {
  const std::string both = weights_sampler + std::string(R"(,{"input":4,"output":6,"interpolation":"STEP"})");
  const OpenAnimation found = open_animation(put(
      "points.gltf",
      with_visibility(morphing_gltf(
          R"({"mesh":0})",
          pointing("/nodes/0/weights", 0) + "," + pointing("/nodes/0/extensions/KHR_node_visibility/visible", 1),
          both))));
  EXPECT_EQ(found.reader.frames().size(), 1U);
  EXPECT_THAT(found.notes, ElementsAre(HasSubstr("2 of 3 frames show nothing")));
  EXPECT_THAT(open_animation(put("paints.gltf", morphing_gltf(R"({"mesh":0})",
                                                              weights_channel + std::string(",") +
                                                                  pointing("/materials/0/alphaCutoff", 0),
                                                              weights_sampler)))
                  .notes,
              ElementsAre(AllOf(HasSubstr("\"/materials/0/alphaCutoff\""), HasSubstr("KHR_animation_pointer"))));
}

TEST_F(GltfAnimation, SaysThatAPictureIsMultiplied) {
  std::string text = morphing_gltf(R"({"mesh":0})", weights_channel, weights_sampler);
  const std::string attributes = R"("targets":)";
  text.replace(text.find(attributes), attributes.size(), R"("material":0,"targets":)");
  Texture dot;
  dot.pixels = Image<float>(2, 2, 3, 0.5F);
  write_texture(folder / "dot.png", dot);
  const auto opened = [&](const std::string& factor) {
    return open_animation(put("tinted.gltf",
                              R"({"materials":[{"pbrMetallicRoughness":{)" + factor +
                                  R"("baseColorTexture":{"index":0}}}],"textures":[{"source":0}],)"
                                  R"("images":[{"uri":"dot.png"}],)" +
                                  text.substr(1)));
  };
  EXPECT_THAT(opened("").notes, Not(Contains(HasSubstr("baseColorFactor"))));
  EXPECT_THAT(opened(R"("baseColorFactor":[1,0.5,1,1],)").notes,
              Contains(AllOf(HasSubstr("materials[0]"), HasSubstr("1, 0.5, 1, 1 (baseColorFactor)"))));
}

}  // namespace
}  // namespace mq

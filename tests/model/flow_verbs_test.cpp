// What flow and interpolate do is a few calls of the library: the same calls give the same files,
// byte for byte.

#include <gtest/gtest.h>

#include <cmath>

#include "model/program_files.h"
#include "mq/io/flow_file.h"
#include "mq/io/vector_field.h"
#include "mq/model/outputs.h"
#include "mq/model/signal_pair.h"

namespace mq {
namespace {

using test::Folder;

/// Waves, moved to the right by so many pixels; the right half of the strip, without the gap between
/// its charts, goes on where the left one ends.
Image<float> waves(int width, int height, double moved, int channels = 3, double gap = 0) {
  Image<float> image(width, height, channels, 1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < channels; ++c) {
        const double along = x - moved - (x < width / 2 ? 0 : gap);
        image(x, y, c) = float(0.5 + 0.2 * std::sin(0.31 * along + 0.8 * c) * std::cos(0.23 * y) +
                               0.15 * std::cos(0.11 * along - 0.17 * y));
      }
  return image;
}

/// Two pictures in a folder.
struct Pictures {
  Folder folder;
  Messages messages;

  explicit Pictures(int channels = 3) {
    write_image(folder / "a.png", waves(70, 60, 0, channels), Depth::u16);
    write_image(folder / "b.png", waves(70, 60, 2, channels), Depth::u16);
  }
  PicturePair pair(const ValueSpace& values = {}) {
    return PicturePair(folder / "a.png", folder / "b.png", values, messages);
  }
};

TEST(VerbFlow, IsTheImageFlowOfTwoPictures) {
  Pictures both;
  run(both.folder, {"flow", "a.png", "b.png", "-o", "out"});
  const PicturePair pair = both.pair();
  const ImageFlow flow = pair.align();
  write_flow(both.folder / "ours.flo", forward_displacement(flow));
  EXPECT_EQ(bytes(both.folder, "ours.flo"), bytes(both.folder, "out/field.flo"));
  write_texture(both.folder / "ours.png", pair.stored(pair.between(flow, 0.5)));
  EXPECT_EQ(bytes(both.folder, "ours.png"), bytes(both.folder, "out/halfway.png"));
  EXPECT_FALSE(pair.likeness().equal || pair.likeness().first_constant);
}

TEST(VerbFlow, TakesOptionsThatBothKindsHave) {
  Pictures both;
  run(both.folder, {"flow", "a.png", "b.png", "-o", "out", "--alignment", "forward", "--steps", "2",
                    "--gradients", "2", "--robust-data", "0.5", "--largest", "6tx", "--space",
                    "linear"});
  ImageFlowOptions options;
  options.alignment = FlowAlignment::forward;
  options.steps = 2;
  options.gradient_weight = 2;
  options.robust_data = 0.5;
  options.largest = {6, Length::Unit::texels};
  const PicturePair pair = both.pair({.space = ColourSpace::linear});
  write_flow(both.folder / "ours.flo", forward_displacement(pair.align(options)));
  EXPECT_EQ(bytes(both.folder, "ours.flo"), bytes(both.folder, "out/field.flo"));
}

TEST(VerbFlow, FollowsAFieldThatIsKnown) {
  Pictures both;
  run(both.folder, {"flow", "a.png", "b.png", "-o", "out"});
  run(both.folder, {"flow", "a.png", "b.png", "-o", "again", "--flow", "out/field.flo"});
  const PicturePair pair = both.pair();
  const ImageFlow flow = pair.follow(pair.read_field(both.folder / "out/field.flo"));
  write_texture(both.folder / "ours.png", pair.stored(pair.between(flow, 0.5)));
  EXPECT_EQ(bytes(both.folder, "ours.png"), bytes(both.folder, "again/halfway.png"));
}

TEST(VerbInterpolate, MixesPicturesAlongTheirFlow) {
  for (const int channels : {3, 4}) {  // with alpha: colours multiplied by it
    Pictures both(channels);
    run(both.folder, {"interpolate", "a.png", "b.png", "-t", "0.3", "-o", "out.png"});
    const PicturePair pair = both.pair();
    const Model between = pair.with(pair.between(pair.align(), 0.3));
    Outputs(both.folder / "ours.png", pair.model(), Outputs::Kind::pictures).write(between, {});
    EXPECT_EQ(bytes(both.folder, "ours.png"), bytes(both.folder, "out.png")) << channels;
  }
}

TEST(PicturePair, RefusesPicturesAndFieldsOfOtherSizes) {
  Pictures both;
  write_image(both.folder / "small.png", waves(20, 20, 0));
  write_flow(both.folder / "small.flo", Image<float>(20, 20, 2));
  EXPECT_THROW(PicturePair(both.folder / "a.png", both.folder / "small.png", {}, both.messages),
               InvalidInput);
  EXPECT_THROW(both.pair().read_field(both.folder / "small.flo"), IoError);
}

/// The strip with two textures.
struct Strip {
  Folder folder;
  Messages messages;
  TexturedModel model;

  Strip() {
    test::write_strip(folder);
    write_image(folder / "a.png", waves(64, 48, 0, 3, 6.4), Depth::u16);
    write_image(folder / "b.png", waves(64, 48, 2, 3, 6.4), Depth::u16);
    LoadOptions options;
    options.textures = {folder / "a.png"};
    model = load_textured_model(folder / "strip.obj", options, messages);
  }
  ModelPair pair(const ValueSpace& values = {}) {
    return ModelPair(model, std::vector{read_texture(folder / "b.png")}, values, messages);
  }
  void write(const std::string& file, const Model& between) {
    Outputs(folder / file, model.model, Outputs::Kind::pictures).write(between, {});
  }
};

TEST(VerbFlow, IsTheTextureFlowOfTwoTextures) {
  Strip strip;
  run(strip.folder, {"flow", "strip.obj", "a.png", "b.png", "-o", "out"});
  const ModelPair pair = strip.pair();
  EXPECT_FALSE(pair.at_vertices());
  EXPECT_EQ(pair.quick_edge(2), 2);
  const ModelPairFlow flow = pair.align();
  write_vector_field(strip.folder / "ours.vf", strip.model.surface.mesh, flow.field());
  EXPECT_EQ(bytes(strip.folder, "ours.vf"), bytes(strip.folder, "out/field.vf"));
  const WarpedPair met = flow.warp_pair(0.5);
  strip.write("ours.png", pair.with(0.5 * (met.source + met.target), 0.5));
  EXPECT_EQ(bytes(strip.folder, "ours.png"), bytes(strip.folder, "out/halfway/a.png"));
}

TEST(VerbFlow, TakesLengthsInTexelsOnTheTrianglesCut) {
  Strip strip;
  run(strip.folder, {"flow", "strip.obj", "a.png", "b.png", "-o", "out", "--largest", "8tx",
                     "--longest-edge", "3", "--space", "linear", "--gradients", "1"});
  ModelFlowOptions options;
  options.longest_edge = 3;
  options.largest = {8, Length::Unit::texels};
  options.gradient_weight = 1;
  const ModelPair pair = strip.pair({.space = ColourSpace::linear});
  write_vector_field(strip.folder / "ours.vf", strip.model.surface.mesh,
                     pair.align(options).field());
  EXPECT_EQ(bytes(strip.folder, "ours.vf"), bytes(strip.folder, "out/field.vf"));
}

TEST(VerbInterpolate, MixesTexturesAlongTheirFlow) {
  Strip strip;
  run(strip.folder,
      {"interpolate", "strip.obj", "a.png", "b.png", "--frames", "0-3", "-o", "out_%d.png"});
  const ModelPair pair = strip.pair();
  const ModelPairFlow flow = pair.align();
  for (const int frame : {0, 1, 3}) {
    strip.write("ours.png", pair.with(flow.between(frame / 3.0), frame / 3.0));
    EXPECT_EQ(bytes(strip.folder, "ours.png"),
              bytes(strip.folder, "out_" + std::to_string(frame) + ".png"))
        << frame;
  }
}

TEST(VerbInterpolate, MixesColoursAtVertices) {
  const Folder folder;
  test::write_bytes(folder / "a.ply", test::coloured_ply);
  std::string other = test::coloured_ply;
  other.replace(other.find("100 100 100"), 11, "150 100 250");
  test::write_bytes(folder / "b.ply", other);
  run(folder, {"interpolate", "a.ply", "b.ply", "-t", "0.25", "--detail", "0", "-o", "out.ply"});
  Messages messages;
  const TexturedModel model = load_textured_model(folder / "a.ply", {}, messages);
  const ModelPair pair(model, read_model(folder / "b.ply"), messages);
  EXPECT_TRUE(pair.at_vertices());
  ModelFlowOptions options;
  options.detail = {};
  const ModelPairFlow flow = pair.align(options);
  write_model(folder / "ours.ply", pair.with(flow.between(0.25), 0.25));
  EXPECT_EQ(bytes(folder, "ours.ply"), bytes(folder, "out.ply"));
}

TEST(ModelPair, RefusesWhatDoesNotFit) {
  Strip strip;
  EXPECT_THROW(ModelPair(strip.model, std::vector<Texture>(), {}, strip.messages), InvalidInput);
  write_image(strip.folder / "small.png", waves(20, 20, 0));
  EXPECT_THROW(ModelPair(strip.model, std::vector{read_texture(strip.folder / "small.png")}, {},
                         strip.messages),
               InvalidInput);
  EXPECT_THROW(ModelPair(strip.model, strip.model.model, strip.messages), InvalidInput);
}

}  // namespace
}  // namespace mq

// What verbs of one model do is a few calls of the library: the same calls give the same files, byte for
// byte.

#include <gtest/gtest.h>

#include <limits>

#include "cli/models.h"
#include "mq/draw/texel_maps.h"
#include "mq/model/lossless_textures.h"
#include "mq/model/outputs.h"
#include "mq/model/texture_fill.h"
#include "mq/model/unwrapped_model.h"

namespace mq {
namespace {

using test::Folder;
using test::marquetry;

/// What the program writes as FILE when it is asked for these words.
std::string of_program(const Folder& folder, std::vector<std::string> words,
                       const std::string& file) {
  words.insert(words.end(), {"-o", file});
  const test::Result result = marquetry(folder, words);
  EXPECT_EQ(result.status, 0) << result.error;
  return test::file_bytes(folder / file);
}

/// What a model becomes as a file of that name.
std::string of_library(const Folder& folder, const Model& model, const std::string& file,
                       Outputs::Kind kind = Outputs::Kind::pictures) {
  Outputs(folder / file, model, kind).write(model, {});
  return test::file_bytes(folder / file);
}

/// The strip of two charts.
struct TwoCharts {
  Folder folder;
  Messages messages;
  TexturedModel model;

  explicit TwoCharts(MissingPictures missing = MissingPictures::refuse) {
    test::write_strip(folder);
    model = load_textured_model(folder / "strip.obj", {.missing = missing}, messages);
  }
};

TEST(VerbFill, ContinuesChartsAtTheirBordersAndSpreadsThem) {
  for (const char* distance : {"", "3"}) {
    TwoCharts strip;
    std::vector<std::string> words = {"fill", "strip.obj"};
    FillOptions options;
    if (*distance) words.insert(words.end(), {"--distance", distance}), options.distance = 3;
    const std::string wanted = of_program(strip.folder, words, "out.png");
    const TextureFill fill(strip.model, options, strip.messages);
    EXPECT_GT(fill.border_texels(), 0);
    EXPECT_GT(fill.put(fill.solve(), strip.model.model), 0);
    EXPECT_EQ(of_library(strip.folder, strip.model.model, "ours.png"), wanted);
  }
}

TEST(VerbFill, LetsChartsGoOnByThemselvesInLight) {
  TwoCharts strip;
  const std::string wanted = of_program(
      strip.folder, {"fill", "strip.obj", "--weight", "0", "--space", "linear"}, "out.png");
  const TextureFill fill(strip.model,
                         {.values = {.space = ColourSpace::linear}, .weight = 0, .distance =
                              std::numeric_limits<double>::infinity()},
                         strip.messages);
  fill.put(fill.solve(), strip.model.model);
  EXPECT_EQ(of_library(strip.folder, strip.model.model, "ours.png"), wanted);
}

TEST(TextureFill, RefusesAModelWithoutCharts) {
  TwoCharts strip;
  strip.model.atlas.reset();
  EXPECT_THROW(TextureFill(strip.model, {}, strip.messages), InvalidInput);
}

TEST(VerbMask, DrawsWhatTexelsAreUsedFor) {
  const std::vector<std::pair<std::string, TexelUse>> uses = {{"active", TexelUse::active},
                                                              {"boundary", TexelUse::boundary},
                                                              {"chart", TexelUse::chart},
                                                              {"triangle", TexelUse::triangle},
                                                              {"overlap", TexelUse::overlap}};
  for (const auto& [name, use] : uses) {
    TwoCharts strip(MissingPictures::assume);
    const std::string wanted =
        of_program(strip.folder, {"mask", "strip.obj", "--what", name}, "out.png");
    TexelMaps maps = texel_maps(strip.model.surface, *strip.model.atlas, use);
    EXPECT_GT(maps.marked, 0);
    replace_with_lossless(strip.model.model, std::move(maps.pictures), "mask");
    EXPECT_EQ(of_library(strip.folder, strip.model.model, "ours.png"), wanted) << name;
  }
}

TEST(VerbUnwrap, GivesTheModelTheAtlasOfItsSurface) {
  TwoCharts strip(MissingPictures::unneeded);
  const std::string wanted =
      of_program(strip.folder, {"unwrap", "strip.obj", "--size", "64"}, "out.obj");
  put_unwrapped(unwrap(strip.model.surface, {.width = 64, .height = 64}), strip.model);
  EXPECT_EQ(overlapping_texels(strip.model, {64, 64}), 0);
  EXPECT_EQ(of_library(strip.folder, strip.model.model, "ours.obj", Outputs::Kind::model), wanted);
}

}  // namespace
}  // namespace mq

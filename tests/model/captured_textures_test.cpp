#include "mq/model/captured_textures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/folder.h"
#include "model/sequences.h"
#include "mq/base/error.h"
#include "mq/io/frame_files.h"
#include "mq/mesh/orient.h"
#include "mq/unwrap/unwrap.h"

namespace mq {
namespace {

using testing::HasSubstr;

/// Frames as files, and a store that follows them.
class CapturedTexturesTest : public FolderTest {
 protected:
  CapturedTexturesTest() {
    const std::vector<MemoryFrames::Frame> made = bending(2);
    for (const MemoryFrames::Frame& frame : made) write_model(path(frame.number), frame.model);
    MemoryStore store;
    SequenceTracker(MemoryFrames(made), store, coarse()).run();
    evolving = store.mesh();
    write_evolving(folder / "body.evolving", evolving, store.step());
  }
  std::filesystem::path path(int number) const {
    return folder / frame_name("frame_%04d.ply", number);
  }
  CapturedTextures captured(const EvolvingReader& reader, CapturedTextureOptions options = {}) {
    return {reader, folder.string(), {0, 1}, std::move(options), heard};
  }

  Heard heard;
  EvolvingMesh evolving;
};

TEST_F(CapturedTexturesTest, GiveVerticesTheColoursThatWereCapturedThere) {
  const EvolvingReader reader(folder / "body.evolving");
  CapturedTextures textures = captured(reader);
  const CapturedTextures::Coloured first = textures.at_vertices(0);
  EXPECT_EQ(first.number, 0);
  EXPECT_EQ(first.unseen, 0);
  EXPECT_EQ(first.model.mesh.positions, evolving.frames[0].positions);
  // The first frame follows itself: its vertices are those of the file, in an order of their own.
  const Model file = read_model(path(0));
  int same = 0;
  for (int v = 0; v < first.model.mesh.vertex_count(); ++v)
    for (int w = 0; w < file.mesh.vertex_count(); ++w)
      if ((first.model.mesh.positions[v] - file.mesh.positions[w]).norm() < 1e-5) {
        ++same;
        for (int k = 0; k < 3; ++k)
          EXPECT_NEAR(first.model.colors.values[3 * v + k], file.colors.values[3 * w + k], 0.01);
      }
  EXPECT_GT(same, 0.9 * file.mesh.vertex_count());
}

TEST_F(CapturedTexturesTest, RefuseFramesOfSomethingElse) {
  Model other = read_model(path(1));
  for (Vector3& p : other.mesh.positions) p = 3 * p + Vector3(5, 0, 0);
  write_model(path(1), other);
  const EvolvingReader reader(folder / "body.evolving");
  CapturedTextures textures = captured(reader);
  EXPECT_NO_THROW(textures.at_vertices(0));
  try {
    textures.at_vertices(1);
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), HasSubstr(path(1).string()));
    EXPECT_THAT(error.what(), HasSubstr("made of something else"));
  }
}

TEST_F(CapturedTexturesTest, FillATextureWithThem) {
  evolving.segments[0].uvs.clear();
  const Unwrapped atlas = unwrap(make_surface(evolving.mesh(0)), {.width = 64, .height = 64});
  evolving.segments[0].uvs = atlas.uvs;
  evolving.segments[0].corner_uvs = atlas.corner_uvs;
  write_evolving(folder / "laid.evolving", evolving, store_step(2));
  const EvolvingReader reader(folder / "laid.evolving");
  const CapturedTextures::Textured shown = captured(reader, {.side = 64}).texture(1);
  EXPECT_EQ(shown.number, 1);
  EXPECT_EQ(shown.texture.picture.width(), 64);
  EXPECT_GT(shown.texture.texels, 1000);
  EXPECT_LT(shown.texture.unseen, shown.texture.texels / 20);
  EXPECT_FALSE(shown.is_light);
  EXPECT_EQ(shown.depth, Depth::u8);
  EXPECT_FALSE(shown.steps_were_taken_out);
  EXPECT_THROW(
      captured(reader, {.side = 64, .steps = CapturedTextureOptions::Steps::taken_out}).texture(1),
      InvalidInput);  // colours at vertices have no charts
}

TEST_F(CapturedTexturesTest, TurnBackWhatFacesTheWrongWay) {
  const EvolvingReader reader(folder / "body.evolving");
  const std::vector<float> sound = captured(reader).at_vertices(1).model.colors.values;
  Model model = read_model(path(1));
  std::vector<int> all;
  for (int t = 0; t < model.mesh.triangle_count(); ++t) all.push_back(t);
  model.mesh = with_flipped(std::move(model.mesh), all);
  write_model(path(1), model);
  CapturedTextures textures = captured(reader);
  EXPECT_EQ(textures.at_vertices(1).model.colors.values, sound);
  ASSERT_EQ(textures.defects().size(), 1U);
  EXPECT_EQ(textures.defects()[0].kind, "inside_out_triangles");
  EXPECT_THAT(heard.warnings, HasSubstr("frame_0001.ply: "));
}

TEST_F(CapturedTexturesTest, RefuseFramesWithoutColours) {
  Model model = read_model(path(0));
  model.colors = {};
  model.document = nullptr;
  write_model(path(0), model);
  const EvolvingReader reader(folder / "body.evolving");
  CapturedTextures textures = captured(reader);
  EXPECT_THROW(textures.at_vertices(0), InvalidInput);
  std::filesystem::remove(path(1));
  EXPECT_THROW(captured(reader), IoError);
}

}  // namespace
}  // namespace mq

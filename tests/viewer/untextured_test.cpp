// Tools on models without pictures: colours at vertices, or pictures of the size that verbs assume.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "viewer/sessions.h"

namespace mq::test {
namespace {

using testing::HasSubstr;

/// shape.ply, without texture coordinates, and coloured.ply, with colours at its vertices.
void write_shapes(const Folder& folder) {
  write_sphere(folder, "64");
  Model model = read_model(folder / "sphere.obj");
  model.mesh.uvs.clear();
  model.mesh.corner_uvs.clear();
  model.textures.clear();
  model.document = nullptr;
  write_model(folder / "shape.ply", model);
  model.colors.channels = 3;
  for (const Vector3& at : model.mesh.positions)
    for (int c = 0; c < 3; ++c)
      model.colors.values.push_back(at[c] > 0.3 * at[(c + 1) % 3] ? 0.8F : 0.2F);
  write_model(folder / "coloured.ply", model);
}

/// What the surface pane shows of the colours that a verb writes.
Image<float> shown_of_verb(const Folder& folder, std::vector<std::string> words) {
  words.insert(words.end(), {"-o", "verb.ply", "--overwrite"});
  const Result verb = marquetry(folder, words);
  EXPECT_EQ(verb.status, 0) << verb.error;
  EXPECT_EQ(view(folder, "show vertex-colours\nscreenshot verb.png surface\n", {"verb.ply"}).status,
            0);
  return picture(folder, "verb.png");
}

TEST(ToolsAtVertices, ShowWhatVerbsWriteIntoModels) {
  const Folder folder;
  write_shapes(folder);
  struct Tried {
    std::string model, script;
    std::vector<std::string> verb;
  };
  const std::vector<Tried> all = {
      {"shape.ply",
       "tool geodesic\nset isolines 7\nsource 0,0,1\n",
       {"geodesic", "shape.ply", "--from", "0,0,1", "--isolines", "7"}},
      {"shape.ply", "tool lic\nset length 9%\n", {"lic", "shape.ply", "--length", "9%"}},
      {"shape.ply",
       "tool react\nset scale 30%\nset time 500\n",
       {"react", "shape.ply", "--scale", "30%", "--time", "500"}},
      {"coloured.ply",
       "tool denoise\nset length 5%\nset edge 0.5\n",
       {"denoise", "coloured.ply", "--length", "5%", "--edge", "0.5"}},
      {"coloured.ply",
       "tool shock\nset smooth 4%\nset time 4\n",
       {"shock", "coloured.ply", "--smooth", "4%", "--time", "4"}}};
  for (const auto& [model, script, verb] : all) {
    const Result result = view(folder,
                               "screenshot before.png surface\n" + script +
                                   "wait\nscreenshot shown.png surface\n"
                                   "save-texture saved.ply\ncopy-command command.txt\n"
                                   "wipe 1\nscreenshot wiped.png surface\nwipe off\n"
                                   "tool none\nscreenshot after.png surface\n",
                               {model});
    ASSERT_EQ(result.status, 0) << script << result.error;
    const Image<float> shown = picture(folder, "shown.png");
    EXPECT_TRUE(std::ranges::equal(shown.values(), shown_of_verb(folder, verb).values())) << script;
    EXPECT_FALSE(file_bytes(folder / "shown.png") == file_bytes(folder / "before.png")) << script;
    EXPECT_TRUE(file_bytes(folder / "after.png") == file_bytes(folder / "before.png")) << script;
    EXPECT_TRUE(file_bytes(folder / "saved.ply") == file_bytes(folder / "verb.ply")) << script;
    EXPECT_THAT(file_bytes(folder / "command.txt"), HasSubstr("--output=saved.ply"));
    std::filesystem::remove(folder / "saved.ply");
    if (model != "coloured.ply") continue;
    // All of the pane on the left of the wipe is as it was, but for the word "before".
    const Image<float> wiped = picture(folder, "wiped.png"), before = picture(folder, "before.png");
    for (int y = 30; y < before.height(); ++y)
      for (int x = 0; x < before.width() - 4; ++x) ASSERT_EQ(wiped(x, y, 0), before(x, y, 0));
  }
}

/// Colours of two models, of which both solve to 1e-6: in steps of 8 bits, and how many differ.
std::pair<double, int> largest_difference(const Folder& folder, const char* a, const char* b) {
  const std::vector<float> first = read_model(folder / a).colors.values,
                           second = read_model(folder / b).colors.values;
  EXPECT_EQ(first.size(), second.size());
  double largest = 0;
  int others = 0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    largest = std::max(largest, 255 * std::abs(double(first[i]) - second[i]));
    others += first[i] != second[i];
  }
  return {largest, others};
}

TEST(ToolsAtVertices, PaintWhatFilterMakesOfTheSavedMask) {
  const Folder folder;
  write_shapes(folder);
  const Result result = view(folder,
                             "view front\nscreenshot before.png surface\ntool filter\nwait\n"
                             "set length 3%\nset beta 2.5\nsize 30%\nstrength 0.7\n"
                             "stroke 0,0,1 0.5,0,0.86\nbrush smooth\nstroke -0.6,0,0.8\n"
                             "wait\nscreenshot painted.png surface\n"
                             "save-mask mask.ply\nsave-texture painted.ply\n"
                             "copy-command command.txt\nundo\nundo\nwait\n"
                             "screenshot undone.png surface\nredo\nredo\nwait\n"
                             "screenshot redone.png surface\nundo\nundo\n"
                             "fill everywhere\nsave-texture all.ply\ncopy-command all.txt\n",
                             {"coloured.ply"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto tool = result.json()["result"]["tool"];
  EXPECT_GT(tool["strokes"][0]["vertices"], 10);
  EXPECT_FALSE(file_bytes(folder / "painted.png") == file_bytes(folder / "before.png"));
  EXPECT_TRUE(file_bytes(folder / "undone.png") == file_bytes(folder / "before.png"));
  EXPECT_EQ(file_bytes(folder / "command.txt"),
            "marquetry filter --output=painted.ply --beta=2.5 --mask=mask.ply --length=3% "
            "coloured.ply\n");
  EXPECT_EQ(file_bytes(folder / "all.txt"),
            "marquetry filter --output=all.ply --beta=2.5 --length=3% coloured.ply\n");
  for (const auto& [mask, saved] : {std::pair{"mask.ply", "painted.ply"}, {"", "all.ply"}}) {
    std::vector<std::string> words = {"filter", "coloured.ply", "-o",  "verb.ply",   "--length",
                                      "3%",     "-b",           "2.5", "--overwrite"};
    if (*mask) words.insert(words.end(), {"--mask", mask});
    const Result verb = marquetry(folder, words);
    ASSERT_EQ(verb.status, 0) << verb.error;
    const auto [largest, others] = largest_difference(folder, "verb.ply", saved);
    EXPECT_LE(largest, 1.001) << saved;
    EXPECT_LE(others, read_model(folder / saved).mesh.vertex_count() / 100) << saved;
    EXPECT_GT(largest_difference(folder, "coloured.ply", saved).second, 100) << saved;
  }
  const Result refused =
      view(folder, "tool filter\nfill everywhere\nsave-mask mask.png\n", {"coloured.ply"});
  EXPECT_EQ(refused.status, 2);
}

/// Two spheres that touch in a vertex, at which the surface is parted: a file has one mask for
/// both.
TEST(ToolsAtVertices, PaintAllPartsOfAVertexAlike) {
  const Folder folder;
  write_shapes(folder);
  Model model = read_model(folder / "coloured.ply");
  model.document = nullptr;
  const int count = model.mesh.vertex_count();
  const auto top =
      std::ranges::max_element(model.mesh.positions, {}, [](const Vector3& p) { return p.z(); });
  const int touching = int(top - model.mesh.positions.begin());
  const double plane = top->z();
  for (int v = 0; v < count; ++v) {
    const Vector3 p = model.mesh.positions[std::size_t(v)];
    model.mesh.positions.emplace_back(p.x(), p.y(), 2 * plane - p.z());
    for (int c = 0; c < 3; ++c)
      model.colors.values.push_back(1 - model.colors.values[std::size_t(3 * v + c)]);
  }
  const int triangles = model.mesh.triangle_count();
  for (int t = 0; t < triangles; ++t) {
    Triangle other = model.mesh.triangles[std::size_t(t)];
    for (int& v : other) v = v == touching ? touching : v + count;
    model.mesh.triangles.push_back({other[0], other[2], other[1]});
  }
  write_model(folder / "touching.ply", model);
  const Result result = view(folder,
                             "tool filter\nset length 10%\nset beta 4\nsize 20%\nstrength 1\n"
                             "stroke 0.1,0,0.99\nsave-mask mask.ply\nsave-texture painted.ply\n",
                             {"touching.ply"});
  ASSERT_EQ(result.status, 0) << result.error;
  ASSERT_EQ(marquetry(folder, {"filter", "touching.ply", "-o", "verb.ply", "-b", "4", "--length",
                               "10%", "--mask", "mask.ply"})
                .status,
            0);
  const auto [largest, others] = largest_difference(folder, "verb.ply", "painted.ply");
  EXPECT_LE(largest, 1.001);
  EXPECT_LE(others, count / 100);
  EXPECT_GT(largest_difference(folder, "touching.ply", "painted.ply").second, 20);
}

TEST(ToolsAtVertices, TellTheColourUnderTheMouse) {
  const Folder folder;
  write_bytes(folder / "fan.ply", coloured_ply);
  const Result result = view(folder, "view front\nhover surface 300 218\n", {"fan.ply"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto pick = result.json()["result"]["picks"][0]["pick"];
  ASSERT_TRUE(pick.contains("values")) << pick;
  EXPECT_NEAR(pick["values"][0].get<double>(),
              (100 + 100 * pick["barycentric"][0].get<double>()) / 255, 1e-5);
}

TEST(ToolsAtVertices, BeginDistancesWhereTheMouseIs) {
  const Folder folder;
  write_shapes(folder);
  const Result result = view(folder,
                             "view front\ntool geodesic\ndrag surface 300 200 280 220\nwait\n"
                             "hover surface 280 220\ncopy-command command.txt\n",
                             {"shape.ply"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto at = result.json()["result"]["picks"][0]["pick"]["point"];
  const std::string line = file_bytes(folder / "command.txt");
  EXPECT_THAT(line, HasSubstr("--from=" + at[0].dump().substr(0, 6)));
}

TEST(ToolsAtVertices, RefuseInTheWordsOfTheVerb) {
  const Folder folder;
  write_shapes(folder);
  write_bytes(folder / "bare.obj",
              std::string(strip_obj).substr(std::string(strip_obj).find("v 0")));
  for (const char* mesh : {"shape.ply", "bare.obj"})
    for (const char* tool : {"filter", "denoise", "shock", "seams", "stitch"}) {
      std::vector<std::string> words = {tool, mesh, "-o", "out.png"};
      if (tool == std::string("filter")) words.insert(words.end(), {"--beta", "3"});
      const Result verb = marquetry(folder, words);
      ASSERT_EQ(verb.status, 2) << tool << mesh;
      const std::size_t begin = verb.error.rfind(std::string(mesh) + ": ");
      ASSERT_NE(begin, std::string::npos) << verb.error;
      const Result result = view(folder, std::string("tool ") + tool + "\n", {mesh});
      EXPECT_EQ(result.status, 2) << tool << mesh;
      EXPECT_THAT(result.error, HasSubstr("session.txt, line 1: " + verb.error.substr(begin)));
    }
}

/// Texture coordinates without pictures: pictures of the assumed size.
TEST(ToolsWithoutPictures, ShowTheTexturesThatVerbsMake) {
  const Folder folder;
  write_bytes(folder / "bare.obj", bare_obj);
  const Result result = view(folder,
                             "tool geodesic\nsource 0,0,0\nwait\nscreenshot shown.png atlas\n"
                             "save-texture saved.png\n",
                             {"bare.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  ASSERT_EQ(marquetry(folder, {"geodesic", "bare.obj", "--from", "0,0,0", "-o", "verb.png"}).status,
            0);
  EXPECT_TRUE(file_bytes(folder / "saved.png") == file_bytes(folder / "verb.png"));
  ASSERT_EQ(view(folder, "screenshot verb_shown.png atlas\n", {"bare.obj", "verb.png"}).status, 0);
  EXPECT_TRUE(file_bytes(folder / "shown.png") == file_bytes(folder / "verb_shown.png"));
}

TEST(ToolsInSequences, WorkOnTheFileOfTheFrame) {
  const Folder folder;
  write_shapes(folder);
  std::filesystem::copy(folder / "coloured.ply", folder / "frame_0003.ply");
  std::filesystem::copy(folder / "coloured.ply", folder / "frame_0004.ply");
  const Result result =
      view(folder, "frame 4\ntool denoise\nset length 5%\nwait\ncopy-command command.txt\n",
           {"frame_%04d.ply"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(file_bytes(folder / "command.txt"),
            "marquetry denoise --output=out.ply --length=5% frame_0004.ply\n");
}

}  // namespace
}  // namespace mq::test

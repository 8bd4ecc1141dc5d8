// Where results of filter go, and what they may replace.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "cli/models.h"
#include "cli/refusal.h"

namespace mq::test {
namespace {

using testing::HasSubstr;
using Words = std::vector<std::string>;

TEST(Filter, ProtectsWhatExistsFromBeingReplaced) {
  const Folder folder;
  write_strip(folder);
  write_bytes(folder / "out.png", "precious");
  const Words words = {"filter", "strip.obj", "-o", "out.png", "--beta", "2", "--no-clobber"};
  const Result result = marquetry(folder, words);
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.error, HasSubstr("out.png: exists already"));
  EXPECT_EQ(file_bytes(folder / "out.png"), "precious");
}

TEST(Filter, WritesNothingWhenItIsOnlyRehearsed) {
  const Folder folder;
  write_strip(folder);
  const auto before = folder.names();
  const Result result = marquetry(folder, {"filter", "strip.obj", "-o", "new/", "--beta", "2",
                                           "--dry-run", "--report", "report.json"});
  EXPECT_EQ(result.status, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("would write new/strip.png"));
  EXPECT_EQ(folder.names(), before);
}

TEST(Filter, LeavesNothingHalfWrittenOnAFullDisk) {
  const Folder folder;
  write_strip(folder, 200, 200);
  const auto before = folder.names();
  const Result result = marquetry(folder, {"filter", "strip.obj", "-o", "out.png", "--beta", "2"},
                                  {.largest_file = 4096});
  EXPECT_EQ(result.status, 2) << result.error;
  EXPECT_THAT(result.error, HasSubstr("out.png"));
  EXPECT_EQ(folder.names(), before);
}

TEST(Filter, RefusesOutputsItCannotWriteBeforeItWorks) {
  const Folder folder;
  write_strip(folder);
  for (const char* output : {"/proc/out.png", "strip.obj/out.png"}) {
    const Result result = marquetry(folder, {"filter", "strip.obj", "-o", output, "--beta", "2"});
    EXPECT_EQ(result.status, 2) << output;
    EXPECT_THAT(result.error, HasSubstr("out.png"));
  }
}

TEST(Filter, MakesTheFoldersOfItsOutput) {
  const Folder folder;
  write_strip(folder);
  const Result result = marquetry(folder, {"filter", "strip.obj", "-o", "none/of/these/out.png", "--beta", "2"});
  EXPECT_EQ(result.status, 0) << result.error;
  EXPECT_TRUE(std::filesystem::exists(folder / "none/of/these/out.png"));
}

TEST(Filter, TakesNamesAsTheyCome) {
  const Folder folder;
  write_strip(folder);
  std::filesystem::rename(folder / "strip.png", folder / "Größe 1 – ß.png");
  write_bytes(folder / "strip.mtl", "newmtl strip\nmap_Kd Größe 1 – ß.png\n");
  const Result result =
      marquetry(folder, {"filter", "strip.obj", "-o", "aus gabe é.png", "--beta", "2", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["result"]["outputs"][0], "aus gabe é.png");
  EXPECT_TRUE(std::filesystem::exists(folder / "aus gabe é.png"));
}

TEST(Filter, WritesAModelBesideItsSource) {
  const Folder folder;
  write_strip(folder);
  const std::string before = file_bytes(folder / "strip.png");
  ASSERT_EQ(marquetry(folder, {"filter", "strip.obj", "-o", "smooth.obj", "--beta", "0"}).status,
            0);
  EXPECT_EQ(file_bytes(folder / "strip.png"), before);
  const Model model = read_model(folder / "smooth.obj");
  ASSERT_EQ(model.textures.size(), 1U);
  EXPECT_EQ(model.textures[0].path.filename(), "smooth.png");
}

TEST(Filter, WritesOverNoInputUnlessAllowed) {
  const Folder folder;
  write_strip(folder);
  write_bytes(folder / "fan.ply", coloured_ply);
  std::filesystem::create_symlink("strip.png", folder / "link.png");
  std::filesystem::create_hard_link(folder / "strip.png", folder / "twin.png");
  std::filesystem::create_directory(folder / "d");
  const std::string picture = file_bytes(folder / "strip.png");
  const auto run = [&](const Words& words) {
    Words all = {"filter", "--beta", "0"};
    all.insert(all.end(), words.begin(), words.end());
    return marquetry(folder, all);
  };
  for (const char* output : {"strip.obj", "strip.png", "./strip.png", "d/../strip.png", "link.png",
                             "twin.png", "strip.mtl", "."}) {
    const Result result = run({"strip.obj", "-o", output});
    EXPECT_EQ(result.status, 2) << output;
    if (std::string(output) != "strip.mtl") {
      EXPECT_THAT(result.error, HasSubstr("--overwrite")) << output;
    }
    EXPECT_EQ(file_bytes(folder / "strip.png"), picture) << output;
  }
  EXPECT_EQ(run({"fan.ply", "-o", "fan.ply"}).status, 2);
  EXPECT_EQ(run({"strip.obj", "-o", "o.png", "--report", "strip.mtl"}).status, 2);
  EXPECT_EQ(run({"strip.obj", "-o", "o.png", "--report", "./o.png"}).status, 2);
  EXPECT_EQ(run({"strip.obj", "-o", "strip.png", "--overwrite", "--no-clobber"}).status, 2);
  EXPECT_EQ(run({"fan.ply", "-o", "fan.ply", "--overwrite"}).status, 0);
  EXPECT_EQ(run({"strip.obj", "-o", "strip.png", "--overwrite"}).status, 0);
  EXPECT_NE(file_bytes(folder / "strip.png"), picture);
}

/// The model was named, and not what comes with it.
TEST(FilterOutputs, ReplaceNoPictureThatNobodyNamed) {
  const Folder folder;
  write_strip(folder);
  write_bytes(folder / "holiday.png", "a picture");
  std::vector<std::string> words = {"filter", "strip.obj", "--beta", "2", "-o", "holiday.obj"};
  EXPECT_THAT(refusal(folder, words, "holiday.obj"), HasSubstr("holiday.png: exists already, and the new holiday.obj"));
  EXPECT_EQ(file_bytes(folder / "holiday.png"), "a picture");
  words.push_back("--overwrite");
  EXPECT_EQ(marquetry(folder, words).status, 0);
  words.pop_back();
  EXPECT_EQ(marquetry(folder, words).status, 0) << "that is its own picture now";
}

TEST(FilterOutputs, OfFramesAreBegunWhereAllAreThere) {
  const Folder folder;
  write_strip(folder);
  std::filesystem::copy(folder / "strip.png", folder / "skin_1.png");
  const std::string said = refusal(
      folder, {"filter", "strip.obj", "skin_%d.png", "--beta", "2", "-o", "out_%d.png", "--frames", "1-2"}, "out_1.png");
  EXPECT_THAT(said, HasSubstr("skin_2.png: frame 2 of --frames is not there"));
}

/// Libraries and pictures that an OBJ file brings with it are outputs as it is.
TEST(FilterOutputs, NameWhatAnObjWritesBesideIt) {
  const Folder folder;
  write_strip(folder);
  std::filesystem::create_directory(folder / "out");
  const auto outputs = [&](const std::vector<std::string>& words) {
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 0) << result.error;
    return result.json()["result"]["outputs"].get<std::vector<std::string>>();
  };
  using testing::UnorderedElementsAre;
  EXPECT_THAT(outputs({"filter", "strip.obj", "--beta", "2", "-o", "new.obj", "--json"}),
              UnorderedElementsAre("new.obj", "new.png", "new.mtl"));
  EXPECT_THAT(outputs({"filter", "strip.obj", "--beta", "2", "-o", "out/far.obj", "--json"}),
              UnorderedElementsAre("out/far.obj", "out/far.png", "out/far.mtl"));
  EXPECT_THAT(outputs({"filter", "strip.obj", "--beta", "2", "-o", "out/strip.obj", "--json"}),
              UnorderedElementsAre("out/strip.obj", "out/strip.png", "out/strip.mtl"));
  EXPECT_THAT(outputs({"filter", "strip.obj", "--geometry", "--beta", "2", "-o", "near.obj", "--json"}),
              UnorderedElementsAre("near.obj"));
  for (const char* name : {"out/far.obj", "out/strip.png", "out/strip.mtl"}) std::filesystem::remove(folder / name);
  EXPECT_THAT(outputs({"filter", "strip.obj", "--geometry", "--beta", "2", "-o", "out/far.obj", "--json"}),
              UnorderedElementsAre("out/far.obj", "out/strip.png", "out/strip.mtl"));
  for (const char* name : {"out/far.obj", "out/strip.png", "out/strip.mtl"})
    EXPECT_TRUE(std::filesystem::exists(folder / name)) << name;
  // A library of another model that would be replaced.
  const Result refused =
      marquetry(folder, {"filter", "strip.obj", "--geometry", "--beta", "2", "-o", "out/other.obj", "--no-clobber"});
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.error, testing::HasSubstr("exists already"));
  // Over itself as before.
  EXPECT_THAT(outputs({"filter", "strip.obj", "--geometry", "--beta", "2", "-o", "strip.obj", "--json", "--overwrite"}),
              UnorderedElementsAre("strip.obj"));
}

}  // namespace
}  // namespace mq::test

// Pipes in the place of files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/wait.h>

#include <cstdlib>

#include "cli/models.h"
#include "cli/program.h"
#include "places.h"

namespace mq::test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

/// Runs with this file as standard input, and temporary files in a folder that must be empty afterwards.
Result piped(const Folder& folder, const std::vector<std::string>& words, const std::string& input) {
  const Folder temporary;
  const Result result = marquetry(
      folder, words,
      {.environment = {{"TMPDIR", temporary.path().string()}}, .standard_input = (folder / input).string()});
  EXPECT_THAT(temporary.names(), IsEmpty());
  return result;
}

/// What a refused run says; it sends nothing.
std::string refused(const Folder& folder, const std::vector<std::string>& words, const std::string& input) {
  const Result result = piped(folder, words, input);
  EXPECT_EQ(result.status, 2) << result.error;
  EXPECT_EQ(result.output, "");
  return result.error;
}

TEST(StandardStreams, AreAPictureLikeAnyOther) {
  const Folder folder;
  write_strip(folder);
  ASSERT_EQ(marquetry(folder, {"filter", "strip.png", "--beta", "2", "-o", "file.png"}).status, 0);
  const Result result = piped(folder, {"filter", "-", "--beta", "2", "-o", "-"}, "strip.png");
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.output, file_bytes(folder / "file.png"));
  EXPECT_THAT(result.error, Not(HasSubstr("/")));
}

TEST(StandardStreams, AreModels) {
  const Folder folder;
  write_bytes(folder / "fan.ply", coloured_ply);
  ASSERT_EQ(marquetry(folder, {"filter", "fan.ply", "--vertices", "--beta", "0", "-o", "file.glb"}).status,
            0);
  const Result result = piped(folder, {"filter", "-", "--vertices", "--beta", "0", "-o", "glb:-"}, "fan.ply");
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.output, file_bytes(folder / "file.glb"));
}

TEST(StandardStreams, StandForMasksAndConfigurationsToo) {
  const Folder folder;
  write_strip(folder);
  ASSERT_EQ(
      marquetry(folder, {"filter", "strip.obj", "--beta", "2", "-o", "a.png", "--report", "run.json"}).status,
      0);
  ASSERT_EQ(piped(folder, {"filter", "--config", "-", "-o", "b.png"}, "run.json").status, 0);
  EXPECT_EQ(file_bytes(folder / "a.png"), file_bytes(folder / "b.png"));
  const Result masked =
      piped(folder, {"filter", "strip.obj", "--beta", "2", "--mask", "-", "-o", "c.png"}, "strip.png");
  EXPECT_EQ(masked.status, 0) << masked.error;
}

TEST(StandardStreams, AreHyphensInReports) {
  const Folder folder;
  write_strip(folder);
  ASSERT_EQ(piped(folder, {"filter", "-", "--beta", "2", "-o", "png:-", "--report", "run.json"}, "strip.png")
                .status,
            0);
  const auto report = nlohmann::json::parse(file_bytes(folder / "run.json"));
  EXPECT_EQ(report.at("options").at("mesh"), "-");
  EXPECT_EQ(report.at("options").at("output"), "png:-");
  EXPECT_THAT(report.at("result").at("outputs").get<std::vector<std::string>>(), ElementsAre("png:-"));
  EXPECT_THAT(report.dump(), Not(HasSubstr("standard_")));
  const Result again = piped(folder, {"filter", "--config", "run.json"}, "strip.png");
  EXPECT_EQ(again.status, 0) << again.error;
  EXPECT_EQ(again.output, piped(folder, {"filter", "-", "--beta", "2", "-o", "-"}, "strip.png").output);
}

TEST(StandardStreams, BringModelsThatFindWhatLiesHere) {
  const Folder folder;
  write_strip(folder);
  ASSERT_EQ(marquetry(folder, {"filter", "strip.obj", "--beta", "2", "-o", "file.glb"}).status, 0);
  const Result result =
      piped(folder, {"filter", "-", "--beta", "2", "-o", "glb:-", "--report", "run.json"}, "strip.obj");
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.output, file_bytes(folder / "file.glb"));
  EXPECT_THAT(file_bytes(folder / "run.json"), Not(HasSubstr("marquetry-pipe")));
  EXPECT_THAT(result.error, Not(HasSubstr("marquetry-pipe")));
  // A shape goes alone, and names the library that lies here.
  const Result shape =
      piped(folder, {"filter", "-", "--geometry", "--beta", "2", "-o", "obj:-", "--report", "shape.json"}, "strip.obj");
  ASSERT_EQ(shape.status, 0) << shape.error;
  EXPECT_THAT(shape.output, HasSubstr("mtllib strip.mtl"));
  EXPECT_EQ(nlohmann::json::parse(file_bytes(folder / "shape.json"))["result"]["outputs"], nlohmann::json({"obj:-"}));
}

/// What a command of the shell ends with, in a folder and with another for temporary files, `$program` in
/// front of it.
int shell(const Folder& folder, const std::string& command) {
  const Folder temporary;
  const std::string all = "cd '" + folder.path().string() + "' && export TMPDIR='" +
                          temporary.path().string() + "' program='" + places::program().string() + "' && " +
                          command;
  const int status = std::system(("bash -c \"" + all + "\"").c_str());
  EXPECT_THAT(temporary.names(), IsEmpty()) << command;
  return WEXITSTATUS(status);
}

TEST(StandardStreams, EndWithWhoeverIsAtTheOtherEnd) {
  const Folder folder;
  write_strip(folder, 512, 384);
  // Closed; silent until Ctrl-C; endless; no longer read; a pipe with a name.
  EXPECT_EQ(shell(folder, "timeout 20 \\$program filter - --beta 2 -o png:- <&- > out 2> said"), 2);
  EXPECT_THAT(file_bytes(folder / "said"), HasSubstr("nothing came by standard input"));
  EXPECT_EQ(
      shell(folder,
            "sleep 3 | timeout --preserve-status -s INT 1 \\$program filter - --beta 2 -o png:- 2> said; "
            "exit \\${PIPESTATUS[1]}"),
      130);
  EXPECT_EQ(shell(folder,
                  "yes | timeout 20 \\$program filter - --beta 2 -o png:- 2> said; exit \\${PIPESTATUS[1]}"),
            2);
  EXPECT_THAT(file_bytes(folder / "said"), HasSubstr("is in no format"));
  EXPECT_EQ(shell(folder,
                  "\\$program filter strip.png --beta 1 -o png:- 2> said | head -c 10 > out; exit "
                  "\\${PIPESTATUS[0]}"),
            2);
  EXPECT_THAT(file_bytes(folder / "said"), HasSubstr("nobody reads it any more"));
  EXPECT_EQ(shell(folder, "\\$program filter <(cat strip.png) --beta 1 -o piped.png 2> said"), 0);
  EXPECT_TRUE(std::filesystem::exists(folder / "piped.png"));
}

TEST(StandardStreams, AreNamedInMessages) {
  const Folder folder;
  write_strip(folder);
  const std::string picture = file_bytes(folder / "strip.png");
  write_bytes(folder / "cut.png", picture.substr(0, picture.size() / 2));
  EXPECT_THAT(refused(folder, {"filter", "-", "--beta", "2", "-o", "-"}, "cut.png"),
              HasSubstr(": standard input"));
  write_bytes(folder / "nothing", "");
  EXPECT_THAT(refused(folder, {"filter", "-", "-o", "-"}, "nothing"), HasSubstr("nothing came"));
  write_bytes(folder / "words", "once upon a time");
  EXPECT_THAT(refused(folder, {"filter", "-", "-o", "-"}, "words"), HasSubstr("obj:-"));
}

TEST(StandardStreams, BringAStoreWhoseBlocksLieHere) {
  const Folder folder;
  const std::vector<std::string> sample{"sample", "merging", "-o", "balls/", "--triangles", "1200", "--frames", "28-30"};
  ASSERT_EQ(marquetry(folder, sample).status, 0);
  ASSERT_EQ(marquetry(folder, {"track", "balls", "-o", "balls.evolving"}).status, 0);
  const Result told = piped(folder, {"export", "-"}, "balls.evolving");
  EXPECT_EQ(told.status, 0) << told.error;
  EXPECT_THAT(told.output, HasSubstr("3 frames"));
  std::filesystem::remove(folder / "balls.blocks");
  const std::string said = refused(folder, {"export", "-"}, "balls.evolving");
  EXPECT_THAT(said, HasSubstr("balls.blocks"));
  EXPECT_THAT(said, Not(HasSubstr("/tmp")));
}

TEST(StandardStreams, AreToldOfAFormatThatTheVerbMakes) {
  const Folder folder;
  write_strip(folder);
  EXPECT_THAT(refused(folder, {"play", "strip.evolving", "-o", "-"}, "strip.png"),
              AllOf(HasSubstr("html:-"), Not(HasSubstr("png:-"))));
  EXPECT_THAT(refused(folder, {"evolve", "strip_%04d.ply", "-o", "-"}, "strip.png"), HasSubstr("is two files"));
}

TEST(StandardStreams, TakeOneFileAndNothingElse) {
  const Folder folder;
  write_strip(folder);
  EXPECT_THAT(refused(folder, {"filter", "strip.obj", "--beta", "2", "-o", "-"}, "strip.png"),
              HasSubstr("png:-"));
  EXPECT_THAT(refused(folder, {"filter", "strip.obj", "--beta", "2", "-o", "obj:-"}, "strip.png"),
              AllOf(HasSubstr("standard output takes one"), HasSubstr("glb:-")));
  EXPECT_THAT(refused(folder, {"filter", "-", "-", "-o", "-"}, "strip.png"), HasSubstr("taken already"));
  EXPECT_THAT(refused(folder, {"filter", "strip.obj", "--report", "-", "-o", "png:-"}, "strip.png"),
              HasSubstr("./-"));
  const Result both = piped(folder, {"filter", "-", "--beta", "2", "-o", "-", "--json"}, "strip.png");
  EXPECT_EQ(both.status, 2);
  EXPECT_THAT(both.error, HasSubstr("--report FILE"));
}

TEST(StandardStreams, NoticeThatNobodyTakesTheResult) {
  const Folder folder;
  write_strip(folder);
  const Result lost =
      marquetry(folder, {"filter", "strip.png", "--beta", "2", "-o", "-"}, {.standard_output = "/dev/full"});
  EXPECT_EQ(lost.status, 2);
  EXPECT_THAT(lost.error, HasSubstr("standard output cannot be written to"));
}

}  // namespace
}  // namespace mq::test

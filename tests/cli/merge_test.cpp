// marquetry merge and --shard: parts of a sequence are the whole, and nothing missing goes unseen.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "cli/models.h"
#include "places.h"

namespace mq::test {
namespace {

using testing::HasSubstr;
using Words = std::vector<std::string>;

/// A filter over frames 2 to 8, part of which is asked for.
struct Sequence {
  Sequence() {
    write_strip(folder);
    for (int frame = 2; frame <= 8; ++frame)
      std::filesystem::copy(folder / "strip.png", folder / ("in_" + std::to_string(frame) + ".png"));
  }

  Words words(const Words& more) const {
    Words all = {"filter", "strip.obj", "in_%d.png", "-o", "out_%d.png", "--beta", "0", "--frames", "2-8"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }

  void run_part(int part, int count, const Words& more = {}) const {
    Words all = words({"--shard", std::to_string(part) + "/" + std::to_string(count), "--report",
                       "part_" + std::to_string(part) + ".json"});
    all.insert(all.end(), more.begin(), more.end());
    const Result result = marquetry(folder, all);
    ASSERT_EQ(result.status, 0) << result.error;
  }

  Words reports(int count) const {
    Words all = {"merge"};
    for (int part = count; part >= 1; --part) all.push_back("part_" + std::to_string(part) + ".json");
    return all;
  }

  Folder folder;
};

std::string refused(const Folder& folder, const Words& words) {
  const Result result = marquetry(folder, words);
  EXPECT_EQ(result.status, 2) << result.output;
  return result.error;
}

TEST(Merge, MakesOneReportOfPartsThatWroteWhatTheWholeWrites) {
  const Sequence sequence;
  const Folder& folder = sequence.folder;
  ASSERT_EQ(marquetry(folder, sequence.words({"--report", "one.json"})).status, 0);
  std::vector<std::string> whole;
  for (int frame = 2; frame <= 8; ++frame) {
    const auto file = folder / ("out_" + std::to_string(frame) + ".png");
    whole.push_back(file_bytes(file));
    std::filesystem::remove(file);
  }
  for (const int part : {3, 1, 2}) sequence.run_part(part, 3);
  for (int frame = 2; frame <= 8; ++frame)
    EXPECT_TRUE(file_bytes(folder / ("out_" + std::to_string(frame) + ".png")) == whole[std::size_t(frame - 2)]) << frame;

  Words words = sequence.reports(3);
  words.insert(words.end(), {"-o", "whole.json", "--json"});
  const Result result = marquetry(folder, words);
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["result"]["frames"], 7);
  using Json = nlohmann::ordered_json;
  const Json merged = Json::parse(file_bytes(folder / "whole.json")), one = Json::parse(file_bytes(folder / "one.json"));
  EXPECT_EQ(merged["options"], one["options"]);
  EXPECT_FALSE(merged.contains("shard"));
  ASSERT_EQ(merged["frames"].size(), one["frames"].size());
  for (std::size_t i = 0; i < one["frames"].size(); ++i)
    for (const char* name : {"frame", "result", "solve", "input"})
      EXPECT_EQ(merged["frames"][i][name], one["frames"][i][name]) << i;
  EXPECT_EQ(marquetry(folder, {"filter", "--config", "whole.json", "--dry-run"}).status, 0);
}

TEST(Merge, RefusesGapsAndPartsThatDoNotGoTogether) {
  const Sequence sequence;
  const Folder& folder = sequence.folder;
  for (const int part : {1, 2, 3}) sequence.run_part(part, 3);
  EXPECT_THAT(refused(folder, {"merge", "part_1.json", "part_3.json"}), HasSubstr("one is missing: 2; run it with --shard 2/3"));
  EXPECT_THAT(refused(folder, {"merge", "part_1.json", "part_2.json", "part_1.json"}), HasSubstr("part 1/3 is in part_1.json too"));
  std::filesystem::remove(folder / "out_5.png");
  EXPECT_THAT(refused(folder, sequence.reports(3)), HasSubstr("out_5.png: not there, though part_2.json says that frame 5"));
  sequence.run_part(2, 3, {"--length", "2tx"});
  EXPECT_THAT(refused(folder, sequence.reports(3)), HasSubstr("--alpha is not given, but in part_3.json it is 0.001"));
  sequence.run_part(2, 3);
  EXPECT_EQ(marquetry(folder, sequence.reports(3)).status, 0);
  ASSERT_EQ(marquetry(folder, sequence.words({"--report", "one.json"})).status, 0);
  EXPECT_THAT(refused(folder, {"merge", "one.json"}), HasSubstr("a report of no part of a sequence"));
  write_bytes(folder / "text.json", "[1, 2");
  EXPECT_THAT(refused(folder, {"merge", "text.json"}), HasSubstr("text.json, line 1"));
}

TEST(Merge, TakesMorePartsThanFrames) {
  const Sequence sequence;
  for (int part = 1; part <= 9; ++part) sequence.run_part(part, 9);
  const Result result = marquetry(sequence.folder, sequence.reports(9));
  EXPECT_EQ(result.status, 0) << result.error;
  EXPECT_THAT(result.output, HasSubstr("7 frames of 9 parts"));
}

TEST(Merge, ShardsWantFramesAndANumberThatThereIs) {
  const Sequence sequence;
  for (const char* shard : {"0/3", "4/3", "2", "a/b", "1/", "/2", "1/2/3"})
    EXPECT_THAT(refused(sequence.folder, sequence.words({"--shard", shard})), HasSubstr("3/16")) << shard;
  EXPECT_THAT(refused(sequence.folder, {"filter", "strip.obj", "-o", "out.png", "--beta", "0", "--shard", "1/2"}),
              HasSubstr("give --frames too"));
}

/// The script runs all parts, and after one was lost that one alone.
TEST(Merge, IsDoneByAScript) {
  const Sequence sequence;
  const std::string script = places::source().string() + "/examples/cluster/parallel.sh";
  const auto run = [&] {
    return std::system(("cd '" + sequence.folder.path().string() + "' && MARQUETRY='" + places::program().string() + "' '" + script +
                        "' 3 whole.json filter strip.obj in_%d.png -o out_%d.png --beta 0 --frames 2-8 > log.txt 2>&1")
                           .c_str());
  };
  ASSERT_EQ(run(), 0) << file_bytes(sequence.folder / "log.txt");
  const std::string whole = file_bytes(sequence.folder / "out_5.png");
  EXPECT_TRUE(std::filesystem::exists(sequence.folder / "whole.json"));
  const auto other = std::filesystem::last_write_time(sequence.folder / "out_2.png");
  std::filesystem::remove(sequence.folder / "out_5.png");
  std::filesystem::remove(sequence.folder / "whole.json.part_2_of_3");
  ASSERT_EQ(run(), 0) << file_bytes(sequence.folder / "log.txt");
  EXPECT_TRUE(file_bytes(sequence.folder / "out_5.png") == whole);
  EXPECT_EQ(std::filesystem::last_write_time(sequence.folder / "out_2.png"), other);
}

}  // namespace
}  // namespace mq::test

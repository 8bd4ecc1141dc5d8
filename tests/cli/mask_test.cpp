#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "cli/models.h"

namespace mq::test {
namespace {

using testing::HasSubstr;
using testing::Not;

/// The strip, with the second square laid over four columns of the first.
void write_overlap(const Folder& folder) {
  std::string text = strip_obj;
  for (const auto& [from, to] : {std::pair{"vt 0.55 0.1", "vt 0.4 0.1"}, std::pair{"vt 0.55 0.9", "vt 0.4 0.9"}})
    text.replace(text.find(from), std::string(from).size(), to);
  write_strip(folder);
  write_bytes(folder / "strip.obj", text);
}

std::int64_t white(const Folder& folder) {
  const Image<float> marks = read_texture(folder / "out.png").pixels;
  EXPECT_EQ(std::ranges::count_if(marks.values(), [](float v) { return v != 0 && v != 1; }), 0);
  return std::ranges::count(marks.values(), 1.0F);
}

TEST(Mask, ShowsOverlapsInWhiteAndSaysWhereTheyAre) {
  const Folder folder;
  write_overlap(folder);
  const Result result = marquetry(folder, {"mask", "strip.obj", "-w", "overlap", "-o", "out.png", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto figures = result.json()["result"];
  EXPECT_GT(figures["texels"], 50);
  EXPECT_EQ(white(folder), figures["texels"]);
  EXPECT_EQ(figures["places"], 1);
  const auto& largest = figures["largest"][0];
  EXPECT_EQ(largest["texels"], figures["texels"]);
  EXPECT_EQ(largest["name"], "strip.png");
  EXPECT_GE(largest["column"], 25);
  EXPECT_LE(largest["column"], 29);
  EXPECT_THAT(result.error, HasSubstr("texels in 1 place, at column 27, row 23"));
}

TEST(Mask, DrawsFewMarksLargerWhenAsked) {
  const Folder folder;
  write_overlap(folder);
  ASSERT_EQ(marquetry(folder, {"mask", "strip.obj", "-w", "overlap", "-o", "out.png"}).status, 0);
  const std::int64_t before = white(folder);
  const Result result = marquetry(folder, {"mask", "strip.obj", "-w", "overlap", "-o", "out.png", "--grow", "5", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["result"]["texels"], before);
  EXPECT_GT(white(folder), 2 * before);
  const Result coloured = marquetry(folder, {"mask", "strip.obj", "-w", "chart", "-o", "out.png", "--grow", "5"});
  EXPECT_EQ(coloured.status, 2);
  EXPECT_THAT(coloured.error, HasSubstr("--grow: --what chart stands for numbers"));
}

TEST(Mask, SaysThatFewMarksAreHardToSee) {
  const Folder folder;
  std::string text = strip_obj;
  text.replace(text.find("vt 0.55 0.1"), 11, "vt 0.44 0.1");  // a hair of the square lies over the other
  write_strip(folder, 512, 512);
  write_bytes(folder / "strip.obj", text);
  const Result result = marquetry(folder, {"mask", "strip.obj", "-w", "overlap", "-o", "out.png"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_LT(white(folder), 262);
  EXPECT_THAT(result.error, HasSubstr("so few are hard to see: --grow 4 draws them larger"));
}

TEST(Mask, SaysThatNothingOverlaps) {
  const Folder folder;
  write_strip(folder);
  const Result result = marquetry(folder, {"mask", "strip.obj", "-w", "overlap", "-o", "out.png"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("nothing is marked: no texel's centre lies in two triangles"));
  EXPECT_EQ(white(folder), 0);
}

TEST(Check, SaysWhereTexelsAre) {
  const Folder folder;
  write_overlap(folder);
  const Result told = marquetry(folder, {"check", "strip.obj"});
  EXPECT_THAT(told.output, HasSubstr("in 1 place, at column 27, row "));
  EXPECT_THAT(told.output, Not(HasSubstr("counted row by row")));
  const auto defects = marquetry(folder, {"check", "strip.obj", "--json"}).json()["defects"];
  const auto shared = std::ranges::find_if(defects, [](const auto& one) { return one["kind"] == "overlapping_triangles"; });
  ASSERT_NE(shared, defects.end());
  EXPECT_FALSE((*shared)["ids"].empty());
  EXPECT_EQ((*shared)["place_count"], 1);
  EXPECT_EQ((*shared)["places"][0]["name"], "strip.png");
}

TEST(Warnings, TakeALineEachAndPointToCheckOnce) {
  const Folder folder;
  write_overlap(folder);
  const Result result = marquetry(folder, {"filter", "strip.obj", "-o", "out.png", "--beta", "2"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr(" texels between which triangles lie on each other: one colour for all\n"));
  EXPECT_THAT(result.error, HasSubstr(" read by several charts: values leak between them\n"));
  const std::string pointer = "'marquetry check strip.obj' tells more of these warnings\n";
  const std::size_t at = result.error.find(pointer);
  ASSERT_NE(at, std::string::npos) << result.error;
  EXPECT_EQ(result.error.find(pointer, at + 1), std::string::npos);
  EXPECT_GT(at, result.error.rfind("warning: "));
}

TEST(Inspect, SaysWhatItDoesNotList) {
  const Folder folder;
  write_overlap(folder);
  EXPECT_THAT(marquetry(folder, {"inspect", "strip.obj"}).output,
              HasSubstr("not listed        overlaps and shared texels, which are not looked for here: 'marquetry check "
                        "strip.obj' lists all\n"));
  write_bytes(folder / "split.obj",
              "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 4 6 5\n");
  EXPECT_THAT(marquetry(folder, {"inspect", "split.obj"}).output,
              HasSubstr("not listed        1 note: 'marquetry check split.obj' lists all\n"));
}

}  // namespace
}  // namespace mq::test

// Strokes as a file has them, and what is wrong with it by line and column.

#include "mq/io/field_strokes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/folder.h"
#include "mq/base/error.h"
#include "mq/io/atomic_file.h"
#include "mq/io/bytes.h"

namespace mq {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

class FieldStrokes : public FolderTest {
 protected:
  std::vector<FieldStroke> read(const std::string& text) const {
    write_file(folder / "strokes.json", to_bytes(text));
    return read_field_strokes(folder / "strokes.json");
  }
  void expect_refused(const std::string& text, const std::string& why) const {
    EXPECT_THAT([&] { read(text); }, ThrowsMessage<IoError>(AllOf(HasSubstr("strokes.json"), HasSubstr(why)))) << text;
  }
};

TEST_F(FieldStrokes, AreLinesInSpaceAndInTextures) {
  const std::vector<FieldStroke> strokes = read(
      R"({"strokes": [{"points": [[0, 1, 2], [3, 4, 5.5], [6, 7, 8]], "strength": 0.5},
                      {"uv": [[0.25, 0.5], [0.5, 1]], "texture": 2}]})");
  ASSERT_EQ(strokes.size(), 2U);
  EXPECT_EQ(strokes[0].points, (std::vector<Vector3>{{0, 1, 2}, {3, 4, 5.5}, {6, 7, 8}}));
  EXPECT_EQ(strokes[0].strength, 0.5);
  EXPECT_EQ(strokes[1].uvs, (std::vector<Vector2>{{0.25, 0.5}, {0.5, 1}}));
  EXPECT_EQ(strokes[1].texture, 2);
  EXPECT_EQ(strokes[1].strength, 1);
  EXPECT_THAT(strokes[1].place, HasSubstr("line 2"));
}

TEST_F(FieldStrokes, ComeBackFromTheirFile) {
  std::vector<FieldStroke> strokes(2);
  strokes[0].points = {{0.1, 1.0 / 3, -2e-9}, {4, 5, 6}};
  strokes[0].strength = 0.25;
  strokes[1].uvs = {{0.1, 0.2}, {0.3, 0.7}, {1, 1}};
  strokes[1].texture = 3;
  write_field_strokes(folder / "made.json", strokes);
  const std::vector<FieldStroke> read = read_field_strokes(folder / "made.json");
  ASSERT_EQ(read.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(read[i].points, strokes[i].points);
    EXPECT_EQ(read[i].uvs, strokes[i].uvs);
    EXPECT_EQ(read[i].texture, strokes[i].texture);
    EXPECT_EQ(read[i].strength, strokes[i].strength);
  }
}

TEST_F(FieldStrokes, AreRefusedWithThePlace) {
  expect_refused("{", "line 1");
  expect_refused(R"({"strokes": [{"uv": [[0, 0], [1, 1]], "strenght": 2}]})",
                 "found \"strenght\", did you mean 'strength'?");
  expect_refused("[]", "wanted an object with \"strokes\"");
  expect_refused("{}", "\"strokes\"");
  expect_refused(R"({"strokes": []})", "no strokes");
  expect_refused(R"({"strokes": [{}]})", "found neither");
  expect_refused(R"({"strokes": [{"uv": [[0, 0], [1, 1]], "points": [[0, 0, 0], [1, 1, 1]]}]})", "found both");
  expect_refused(R"({"strokes": [{"points": [[0, 0, 0]]}]})", "found 1 point, wanted two");
  expect_refused(R"({"strokes": [{"points": [[0, 0], [1, 1]]}]})", "a row of 3 numbers");
  expect_refused(R"({"strokes": [{"points": [[0, 0, 0], [1, 1, "x"]]}]})", "a number");
  expect_refused(R"({"strokes": [{"uv": [[0.5, 0], [0.5, 0], [0.5, 0]]}]})", "found 3 points that are one");
  expect_refused(R"({"strokes": [{"points": 3}]})", "a list of rows of 3 numbers");
  expect_refused(R"({"strokes": [{"uv": [[0, 0], [1, 1e300]]}]})", "wanted");
  expect_refused(R"({"strokes": [{"uv": [[0, 0], [1, 1]], "strength": 0}]})", "wanted a number above 0");
  expect_refused(R"({"strokes": [{"uv": [[0, 0], [1, 1]], "strength": 1e300}]})", "1000000 at most");
  expect_refused(R"({"strokes": [{"uv": [[0, 0], [1, 1]], "texture": -1}]})", "texture");
}

}  // namespace
}  // namespace mq

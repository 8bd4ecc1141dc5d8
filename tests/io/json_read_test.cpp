// JSON that goes too deep is refused where it does, before anything calls itself for each level.
#include "mq/io/json_read.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fixtures.h"
#include "mq/base/error.h"
#include "mq/io/evolving_file.h"
#include "mq/io/model.h"
#include "io/folder.h"

namespace mq {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string nested(int levels) {
  return std::string(std::size_t(levels), '[') + std::string(std::size_t(levels), ']');
}

TEST(JsonDepth, IsBounded) {
  EXPECT_EQ(parse_json("a.json", nested(256), "a list").size(), 1u);
  try {
    parse_json("a.json", "\n " + nested(257), "a list");
    FAIL();
  } catch (const IoError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("a.json, line 2, column 258"), HasSubstr("256 deep")));
  }
  EXPECT_THROW(parse_json("a.json", std::string(1 << 20, '['), "a list"), IoError);
}

TEST(JsonDepth, CountsWhatIsNoText) {
  std::string texts = "[";
  for (int i = 0; i < 300; ++i) texts += R"(["[{\"[", {}], )";
  EXPECT_EQ(parse_json("a.json", texts + "0]", "a list").size(), 301u);
}

TEST(Json, NumbersThatAreNoneAreNamed) {
  for (const std::string word : {"NaN", "Infinity", "-Infinity", "nan"})
    EXPECT_THAT(fixtures::error_of<IoError>([&] { parse_json("a.json", "{\"fx\":\n " + word + "}", "cameras"); }),
                AllOf(HasSubstr("a.json, line 2, column 2: found " + word + ", which stands for no number"),
                      HasSubstr("wanted a number")));
}

using DeepFiles = FolderTest;

TEST_F(DeepFiles, AreRefused) {
  put("deep.gltf", R"({"asset": {"version": "2.0"}, "extras": )" + nested(100000) + "}");
  EXPECT_THROW(read_model(folder / "deep.gltf"), IoError);
  put("deep.evolving", nested(100000) + "\n");
  EXPECT_THROW(EvolvingReader(folder / "deep.evolving"), IoError);
}

}  // namespace
}  // namespace mq

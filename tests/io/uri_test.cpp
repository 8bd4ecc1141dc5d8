// Names of files and places of values in JSON.
#include "mq/io/uri.h"

#include <gtest/gtest.h>

#include "mq/io/detail/json_text.h"

namespace mq {
namespace {

TEST(Uri, DecodesWhatItEncodes) {
  for (int size = 0; size < 9; ++size) {
    Bytes bytes;
    for (int i = 0; i < size; ++i) bytes.push_back(std::byte(250 - 37 * i));
    EXPECT_EQ(data_of_uri(data_uri("a/b", bytes)), bytes);
  }
  EXPECT_EQ(data_uri("", bytes_of("light wor")), "data:;base64,bGlnaHQgd29y");
  EXPECT_FALSE(data_of_uri("data:,plain"));
  EXPECT_FALSE(data_of_uri("data:;base64,a b"));
  for (const std::string name : {"a b/\xc3\xa4%20#?.png", "plain-1.png"})
    EXPECT_EQ(name_of_uri(uri_of_name(name)), name);
}

TEST(JsonText, FindsAValueAndNothingElse) {
  const std::string text =
      R"( {"a\"}": [1, {"b": "]"} , 2 ], "c" : {"d": -1.5e3, "e": null} , "c":{"d" : true }} )";
  const auto at = [&](std::initializer_list<JsonStep> steps) {
    const auto place = find_json(text, steps);
    return place ? text.substr(place->begin, place->end - place->begin) : "none";
  };
  EXPECT_EQ(at({"a\"}", std::size_t(1), "b"}), "\"]\"");
  EXPECT_EQ(at({"a\"}", std::size_t(1)}), "{\"b\": \"]\"}");
  EXPECT_EQ(at({"a\"}", std::size_t(2)}), "2");
  EXPECT_EQ(at({"c", "d"}), "true");
  EXPECT_EQ(at({"c", "e"}), "none");
  EXPECT_EQ(at({"a\"}", std::size_t(3)}), "none");
  EXPECT_EQ(at({"x"}), "none");
}

}  // namespace
}  // namespace mq

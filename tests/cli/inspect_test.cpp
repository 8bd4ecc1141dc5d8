#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/models.h"

namespace mq::test {
namespace {

using testing::HasSubstr;
using Json = nlohmann::json;

TEST(Inspect, CountsWhatAModelHas) {
  const Folder folder;
  write_strip(folder);
  const Result result = marquetry(folder, {"inspect", "strip.obj", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  const Json json = result.json();
  EXPECT_EQ(json["verb"], "inspect");
  EXPECT_EQ(json["input"]["vertices"], 6);
  EXPECT_EQ(json["input"]["triangles"], 4);
  EXPECT_EQ(json["input"]["charts"], 2);
  EXPECT_EQ(json["input"]["textures"][0]["width"], 64);
  EXPECT_EQ(json["input"]["textures"][0]["depth"], "u8");
  EXPECT_EQ(json["result"]["atlas"]["seam_edges"], 1);
  EXPECT_NEAR(json["result"]["surface"]["area"].get<double>(), 2, 1e-12);
  // A square of 25.6 × 38.4 texels over one of 1 × 1.
  EXPECT_NEAR(json["result"]["atlas"]["stretch"]["p50"].get<double>(), 1.5, 1e-9);
  for (const char* field : {"version", "options", "defects", "solve", "seconds", "peak_bytes"})
    EXPECT_TRUE(json.contains(field)) << field;
}

TEST(Inspect, SpeaksToPeopleOtherwise) {
  const Folder folder;
  write_strip(folder);
  const Result result = marquetry(folder, {"inspect", "strip.obj"});
  EXPECT_EQ(result.status, 0);
  EXPECT_THAT(result.output, HasSubstr("charts            2 (0 mirrored)"));
}

TEST(Inspect, AssumesATextureWhereThereIsNone) {
  const Folder folder;
  write_bytes(folder / "a.obj", folded_obj);
  const Result result = marquetry(folder, {"inspect", "a.obj"});
  EXPECT_EQ(result.status, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("2048 × 2048"));
}

TEST(Inspect, WritesTheReportItPrints) {
  const Folder folder;
  write_strip(folder);
  const Result result =
      marquetry(folder, {"inspect", "strip.obj", "--json", "--report", "report.json"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(file_bytes(folder / "report.json"), result.output);
}

TEST(Inspect, RefusesWhatIsNotThere) {
  const Folder folder;
  const Result result = marquetry(folder, {"inspect", "nothing.obj"});
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.error, HasSubstr("nothing.obj"));
  EXPECT_EQ(result.output, "");
}

TEST(Check, FindsNothingWrongWithASoundModel) {
  const Folder folder;
  write_strip(folder);
  const Result result = marquetry(folder, {"check", "strip.obj"});
  EXPECT_EQ(result.status, 0) << result.output << result.error;
  EXPECT_THAT(result.output, HasSubstr("nothing to complain of"));
}

TEST(Check, FindsAFold) {
  const Folder folder;
  write_bytes(folder / "folded.obj", folded_obj);
  write_image(folder / "a.png", busy_picture(32, 32));
  const Result result = marquetry(folder, {"check", "folded.obj", "a.png", "--json"});
  EXPECT_EQ(result.status, 1) << result.error;
  const Json json = result.json();
  EXPECT_EQ(json["result"]["usable"], false);
  const bool named = std::ranges::any_of(json["defects"], [](const Json& defect) {
    return defect["kind"] == "flipped_triangles" && defect["severity"] == "refused" &&
           defect["ids"].size() == 1;
  });
  EXPECT_TRUE(named) << json["defects"];
  EXPECT_EQ(marquetry(folder, {"check", "folded.obj", "a.png", "--flipped", "keep"}).status, 1);
}

TEST(Check, WarnsOfAFileThatMayBeCutShort) {
  const Folder folder;
  write_bytes(folder / "whole.obj", folded_obj);
  const std::string text = folded_obj;
  write_bytes(folder / "cut.obj", text.substr(0, text.size() - 1));
  const auto kinds = [&](const char* model) {
    std::string all;
    const Json json = marquetry(folder, {"check", model, "--json"}).json();
    for (const Json& defect : json["defects"])
      all += defect["kind"].get<std::string>() + " ";
    return all;
  };
  EXPECT_THAT(kinds("whole.obj"), testing::Not(HasSubstr("maybe_cut_short")));
  EXPECT_THAT(kinds("cut.obj"), HasSubstr("maybe_cut_short"));
  EXPECT_THAT(marquetry(folder, {"inspect", "cut.obj"}).output, HasSubstr("maybe_cut_short"));
}

TEST(Check, RefusesAModelWithoutFaces) {
  const Folder folder;
  write_bytes(folder / "points.obj", "v 0 0 0\nv 1 0 0\n");
  for (const char* verb : {"check", "inspect"}) {
    const Result result = marquetry(folder, {verb, "points.obj"});
    EXPECT_EQ(result.status, 2);
    EXPECT_THAT(result.error, HasSubstr("points.obj: has 2 vertices and no faces"));
  }
}

}  // namespace
}  // namespace mq::test

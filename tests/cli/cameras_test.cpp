#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "cli/models.h"
#include "cli/refusal.h"

namespace mq::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using Json = nlohmann::json;

/// A bust, and pictures of it from two sides with their cameras in one file.
class CamerasVerb : public testing::Test {
 protected:
  CamerasVerb() {
    run({"sample", "bust", "--size", "64", "--triangles", "600", "-o", "./"});
    Json both = {{"cameras", Json::array()}};
    for (const char* view : {"front", "left"}) {
      const std::string name = view;
      run({"render", "bust.obj", "--view", name, "--size", "120x80", "-o", name + ".png", "--cameras", name + ".json"});
      both["cameras"].push_back(Json::parse(file_bytes(folder / (name + ".json")))["cameras"][0]);
    }
    write_bytes(folder / "cameras.json", both.dump());
  }

  Result run(const std::vector<std::string>& words) const {
    Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 0) << result.error;
    return result;
  }

  const Folder folder;
};

TEST_F(CamerasVerb, SaysWhatThereIs) {
  const Result result = run({"cameras", "cameras.json", "--mesh", "bust.obj"});
  EXPECT_THAT(result.output, AllOf(HasSubstr("views             2, of which 0 without a picture"),
                                   HasSubstr("perspective (2)"), HasSubstr("120 × 80 (2)"), HasSubstr("lie in a view")));
  const Json found = run({"cameras", "cameras.json", "--mesh", "bust.obj", "--json"}).json()["result"];
  EXPECT_EQ(found["format"], "JSON");
  EXPECT_EQ(found["views"], 2);
  EXPECT_EQ(found["found"], 2);
  EXPECT_EQ(found["missing"].size(), 0U);
  EXPECT_EQ(found["sizes"]["120 × 80"], 2);
  EXPECT_EQ(found["lenses"]["perspective"], 2);
  // Both pictures hold all of the model.
  EXPECT_EQ(found["triangles"]["in_a_view"], 1);
  EXPECT_EQ(found["triangles"]["in_three_views"], 0);
}

TEST_F(CamerasVerb, ConvertsThereAndBack) {
  run({"cameras", "cameras.json", "-o", "sparse"});
  run({"cameras", "sparse", "-o", "binary", "--format", "colmap-binary"});
  run({"cameras", "binary", "-o", "transforms.json"});
  run({"cameras", "transforms.json", "-o", "back.json"});
  const Json before = Json::parse(file_bytes(folder / "cameras.json"))["cameras"],
             after = Json::parse(file_bytes(folder / "back.json"))["cameras"];
  ASSERT_EQ(after.size(), 2U);
  for (int k = 0; k < 2; ++k) {
    EXPECT_EQ(after[k]["image"], before[k]["image"]);
    for (const char* name : {"fx", "fy", "cx", "cy"})
      EXPECT_NEAR(after[k][name].get<double>(), before[k][name].get<double>(), 1e-12) << name;
    for (int i = 0; i < 9; ++i)
      EXPECT_NEAR(after[k]["rotation"][i / 3][i % 3].get<double>(), before[k]["rotation"][i / 3][i % 3].get<double>(), 1e-12);
    for (int i = 0; i < 3; ++i)
      EXPECT_NEAR(after[k]["translation"][i].get<double>(), before[k]["translation"][i].get<double>(), 1e-12);
  }
}

TEST_F(CamerasVerb, DrawsCamerasAroundTheirModel) {
  const std::vector<std::string> words = {"cameras", "cameras.json", "--mesh", "bust.obj", "--picture",
                                          "c.png",   "--size",       "200x100"};
  EXPECT_THAT(run(words).error, HasSubstr("wrote c.png"));
  // The same view without cameras is of the model alone, which is larger in it.
  run({"render", "bust.obj", "--size", "200x100", "-o", "m.png"});
  EXPECT_NE(file_bytes(folder / "c.png"), file_bytes(folder / "m.png"));
}

TEST_F(CamerasVerb, GoesOnWherePicturesAreMissing) {
  std::filesystem::remove(folder / "left.png");
  const Result result = run({"cameras", "cameras.json", "-o", "out.json", "--json"});
  EXPECT_THAT(result.error, HasSubstr("1 picture is not there: left.png"));
  EXPECT_EQ(result.json()["result"]["missing"], Json::array({"left.png"}));
  EXPECT_EQ(Json::parse(file_bytes(folder / "out.json"))["cameras"].size(), 2U);
}

TEST_F(CamerasVerb, RefusesWhatCannotBeDone) {
  EXPECT_THAT(refusal(folder, {"cameras", "cameras.json", "-o", "c.xml"}, "c.xml"), HasSubstr("names no format"));
  EXPECT_THAT(refusal(folder, {"cameras", "cameras.json", "--picture", "c.png"}, "c.png"),
              AllOf(HasSubstr("--picture"), HasSubstr("--mesh")));
  EXPECT_THAT(refusal(folder, {"cameras", "cameras.json", "--format", "colmap"}, "c"), HasSubstr("--output"));
  EXPECT_THAT(refusal(folder, {"cameras", "cameras.json", "--mesh", "bust.obj", "--up", "z"}, "c"), HasSubstr("--picture"));
  EXPECT_THAT(refusal(folder, {"cameras", "bust.obj"}, "c"), HasSubstr("not JSON"));
  const std::string before = file_bytes(folder / "cameras.json");
  EXPECT_THAT(marquetry(folder, {"cameras", "cameras.json", "-o", "cameras.json"}).error, HasSubstr("cameras.json"));
  EXPECT_EQ(file_bytes(folder / "cameras.json"), before);
}

}  // namespace
}  // namespace mq::test

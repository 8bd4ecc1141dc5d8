// marquetry texture and cameras: photographs as they come, some of which do not fit, and files that cannot be written.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "cli/program.h"
#include "io/foreign_cameras.h"
#include "mq/io/image_file.h"
#include "mq/io/model.h"

namespace mq::test {
namespace {

using testing::HasSubstr;
using testing::Not;

/// A bust and photographs of it from eight sides around.
class MessyPhotographs : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder = new Folder;
    ASSERT_EQ(call({"sample", "bust", "--size", "256", "-o", "bust.obj"}).status, 0);
    for (int k = 0; k < views; ++k)
      ASSERT_EQ(call({"render", "bust.obj", "-o", picture(k), "--view", fmt::format("{},{}", 45 * k, 10), "--size",
                      "200x240", "--unlit", "--cameras", camera(k)})
                    .status,
                0);
  }
  static void TearDownTestSuite() { delete folder; }

  static std::string picture(int k) { return fmt::format("view{}.png", k); }
  static std::string camera(int k) { return fmt::format("view{}.json", k); }
  static Result call(std::vector<std::string> words) {
    words.push_back("--overwrite");
    return marquetry(*folder, words);
  }

  /// Cameras of some of them, whose pictures are called as `name(k)` says.
  static void write_set(const std::string& file, const std::vector<int>& which, const auto& name) {
    nlohmann::json all = {{"cameras", nlohmann::json::array()}};
    for (const int k : which) {
      all["cameras"].push_back(nlohmann::json::parse(file_bytes(*folder / camera(k)))["cameras"][0]);
      all["cameras"].back()["image"] = name(k);
    }
    write_bytes(*folder / file, all.dump());
  }
  static void write_set(const std::string& file, const std::vector<int>& which) { write_set(file, which, picture); }

  /// The third with somebody in front.
  static void write_passer_by() {
    Image<float> spoilt = read_texture(*folder / picture(2)).pixels;
    for (int y = 90; y < 150; ++y)
      for (int x = 80; x < 115; ++x) spoilt(x, y, 0) = 0.8F, spoilt(x, y, 1) = 0.6F, spoilt(x, y, 2) = 0.1F;
    write_image(*folder / "passer_by.png", spoilt);
  }

  /// Bundler's file of some of them, called as `name(k)` says, with its list.
  static void write_bundle(const std::vector<int>& which, const auto& name) {
    ForeignCameras foreign;
    std::string list;
    for (const int k : which) {
      foreign.set.push_back(read_cameras(*folder / camera(k)).at(0));
      list += name(k) + "\n";
    }
    write_bytes(*folder / "bundle.out", foreign.bundler()), write_bytes(*folder / "list.txt", list);
  }

  /// How many hundredths of what is not black differ by more than 40 steps of 8 bits in a channel.
  static double share_that_differs(const std::string& made, const std::string& from) {
    const Image<float> a = read_texture(folder->path() / made).pixels, b = read_texture(folder->path() / from).pixels;
    double far = 0, all = 0;
    for (int y = 0; y < a.height(); ++y)
      for (int x = 0; x < a.width(); ++x) {
        float most = 0, value = 0;
        for (int c = 0; c < 3; ++c) most = std::max(most, std::abs(a(x, y, c) - b(x, y, c))), value += b(x, y, c);
        if (value > 0) all += 1, far += 255 * most > 40;
      }
    return 100 * far / all;
  }

  static constexpr int views = 8;
  static inline Folder* folder = nullptr;
};

/// Most places are shown by two photographs, in one of which somebody is in front.
TEST_F(MessyPhotographs, PassersByAreLeftOutWhereFewShowAPlace) {
  write_passer_by();
  for (const std::vector<int>& which : {std::vector<int>{2, 3, 5, 7}, {0, 2, 3, 5}}) {
    write_set("clean.json", which);
    write_set("spoilt.json", which, [](int k) { return k == 2 ? "passer_by.png" : picture(k); });
    for (const std::string how : {"detail", "mean"}) {
      for (const std::string name : {"clean", "spoilt"})
        ASSERT_EQ(call({"texture", "bust.obj", "--cameras", name + ".json", "-o", name + ".png", "--blend", how}).status,
                  0);
      EXPECT_LT(share_that_differs("spoilt.png", "clean.png"), 0.4) << how << which[0];
    }
  }
}

TEST_F(MessyPhotographs, WhatDoesNotFitIsNamedAndSkippedWhereAsked) {
  const Image<float> whole = read_texture(*folder / picture(1)).pixels;
  write_image(*folder / "other_size.png", Image<float>(150, 150, 3, 0.5F));
  Image<float> lies(whole.height(), whole.width(), 3);
  for (int y = 0; y < lies.height(); ++y)
    for (int x = 0; x < lies.width(); ++x)
      for (int c = 0; c < 3; ++c) lies(x, y, c) = whole(y, x, c);
  write_image(*folder / "lies.png", lies);
  write_set("unfit.json", {0, 1, 2, 3}, [](int k) {
    return k == 1 ? "other_size.png" : k == 2 ? "lies.png" : picture(k);
  });
  const std::vector<std::string> words = {"texture", "bust.obj", "--cameras", "unfit.json", "-o", "unfit.png"};
  const Result refused = call(words);
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.error, HasSubstr("other_size.png: is 150 × 150, and its camera is of pictures of 200 × 240"));
  EXPECT_THAT(refused.error, HasSubstr("lies.png: is 240 × 200"));
  EXPECT_THAT(refused.error, HasSubstr("or go on without them (--missing skip)"));
  std::vector<std::string> skipping = words;
  skipping.insert(skipping.end(), {"--missing", "skip"});
  const Result skipped = call(skipping);
  ASSERT_EQ(skipped.status, 0) << skipped.error;
  EXPECT_THAT(skipped.output, HasSubstr("2 of 4 photographs used, 2 left out: other_size.png (is 150 × 150"));
  skipping.push_back("--json");
  const nlohmann::json left_out = call(skipping).json()["result"]["left_out"];
  ASSERT_EQ(left_out.size(), 2U);
  EXPECT_THAT(left_out[1]["picture"].get<std::string>(), HasSubstr("lies.png"));
  EXPECT_THAT(left_out[1]["why"].get<std::string>(), HasSubstr("it lies on its side"));
  write_set("fit.json", {0, 3});
  ASSERT_EQ(call({"texture", "bust.obj", "--cameras", "fit.json", "-o", "fit.png"}).status, 0);
  EXPECT_EQ(file_bytes(*folder / "unfit.png"), file_bytes(*folder / "fit.png"));
}

TEST_F(MessyPhotographs, CutPicturesAreSkippedWhereCamerasDoNotSayTheirSize) {
  write_bundle({0, 1, 2}, [](int k) { return k == 1 ? "cut.jpg" : picture(k); });
  write_image(*folder / "whole.jpg", read_texture(*folder / picture(1)).pixels);
  const std::string whole = file_bytes(*folder / "whole.jpg");
  write_bytes(*folder / "cut.jpg", whole.substr(0, whole.size() / 2));
  std::vector<std::string> words = {"texture", "bust.obj", "--cameras", "bundle.out", "-o", "cut.png"};
  const Result refused = call(words);
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.error, HasSubstr("cut.jpg: the JPEG file is cut short"));
  EXPECT_THAT(refused.error, HasSubstr("--missing skip"));
  words.insert(words.end(), {"--missing", "skip"});
  const Result skipped = call(words);
  ASSERT_EQ(skipped.status, 0) << skipped.error;
  EXPECT_THAT(skipped.output, HasSubstr("2 of 3 photographs used, 1 left out: cut.jpg (the JPEG file is cut short"));
  const Result listed = call({"cameras", "bundle.out", "--json"});
  ASSERT_EQ(listed.status, 0) << listed.error;
  EXPECT_EQ(listed.json()["result"]["unreadable"].size(), 1U);
}

TEST_F(MessyPhotographs, CroppedPicturesAreNamedWhereCamerasDoNotSayTheirSize) {
  const Image<float> whole = read_texture(*folder / picture(1)).pixels;
  Image<float> part(160, 240, 3);
  for (int y = 0; y < part.height(); ++y)
    for (int x = 0; x < part.width(); ++x)
      for (int c = 0; c < 3; ++c) part(x, y, c) = whole(x, y, c);
  write_image(*folder / "part.png", part);
  write_bundle({0, 1, 2, 3}, [](int k) { return k == 1 ? "part.png" : picture(k); });
  std::vector<std::string> words = {"texture", "bust.obj", "--cameras", "bundle.out", "-o", "cropped.png"};
  const Result refused = call(words);
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.error, HasSubstr("part.png: is 160 × 240, where most pictures of Bundler are 200 × 240"));
  words.insert(words.end(), {"--missing", "skip", "-q", "--report", "r.json"});
  ASSERT_EQ(call(words).status, 0);
  const nlohmann::json left_out = nlohmann::json::parse(file_bytes(*folder / "r.json"))["result"]["left_out"];
  ASSERT_EQ(left_out.size(), 1U);  // also where nothing is said
  EXPECT_THAT(left_out[0]["picture"].get<std::string>(), HasSubstr("part.png"));
  write_bundle({0, 2, 3}, picture);
  ASSERT_EQ(call({"texture", "bust.obj", "--cameras", "bundle.out", "-o", "whole.png"}).status, 0);
  EXPECT_EQ(file_bytes(*folder / "cropped.png"), file_bytes(*folder / "whole.png"));
}

TEST_F(MessyPhotographs, GreyPicturesAmongColouredOnesAreLeftOut) {
  const auto grey = [](int k) { return fmt::format("grey{}.png", k); };
  for (int k = 0; k < 3; ++k) {
    const Image<float> coloured = read_texture(*folder / picture(k)).pixels;
    Image<float> one(coloured.width(), coloured.height(), 1);
    for (int y = 0; y < one.height(); ++y)
      for (int x = 0; x < one.width(); ++x) one(x, y, 0) = coloured(x, y, 1);
    write_image(*folder / grey(k), one);
  }
  const std::vector<std::string> words = {"texture", "bust.obj", "--cameras", "grey.json", "-o", "grey_made.png"};
  write_set("grey.json", {0, 1, 2}, [&](int k) { return k == 1 ? grey(k) : picture(k); });
  const Result some = call(words);
  ASSERT_EQ(some.status, 0) << some.error;
  EXPECT_THAT(some.error, HasSubstr("grey1.png: is grey, and others are not: left out"));
  EXPECT_THAT(some.output, HasSubstr("2 of 3 photographs used, 1 left out: grey1.png (is grey, and others are not)"));
  write_set("rest.json", {0, 2});
  ASSERT_EQ(call({"texture", "bust.obj", "--cameras", "rest.json", "-o", "rest.png"}).status, 0);
  EXPECT_EQ(file_bytes(*folder / "grey_made.png"), file_bytes(*folder / "rest.png"));
  write_set("grey.json", {0, 1, 2}, [&](int k) { return k == 1 ? picture(k) : grey(k); });
  const Result most = call(words);
  EXPECT_THAT(most.error, HasSubstr("2 of 3 photographs are grey"));
  EXPECT_THAT(most.output, HasSubstr("3 of 3 photographs used"));
  write_set("grey.json", {0, 1, 2}, grey);
  EXPECT_THAT(call(words).error, Not(HasSubstr("grey,")));
}

TEST_F(MessyPhotographs, WhatIsMissingInTwoFilesOfCamerasCountsOnce) {
  const auto gone = [](int k) { return k == 1 ? "gone.png" : picture(k); };
  write_set("first.json", {0, 1}, gone), write_set("second.json", {1, 2}, gone);
  const Result result = call({"texture", "bust.obj", "--cameras", "first.json", "--cameras", "second.json", "-o",
                              "twice.png", "--missing", "skip"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_THAT(result.output, HasSubstr("2 of 3 photographs used, 1 left out: gone.png (is not there)"));
}

TEST_F(MessyPhotographs, WhatUsersTryIsAnsweredWithWhatTheyWant) {
  write_bytes(*folder / "no.json", "{\"cameras\": [{\"fx\": NaN}]}"), write_bytes(*folder / "none.json", "{}");
  const std::string both =
      call({"texture", "bust.obj", "--cameras", "no.json", "--cameras", "none.json", "-o", "x.png"}).error;
  EXPECT_THAT(both, HasSubstr("no.json, line 1, column 21: found NaN"));
  EXPECT_THAT(both, HasSubstr("\n  none.json, line 1"));
  write_set("some.json", {0});
  EXPECT_THAT(call({"texture", "bust.obj", "--cameras", "some.json", "-o", "x.png", "--align"}).error,
              HasSubstr("there is no option '--align': cameras are moved by --poses align"));
  EXPECT_THAT(call({"stitch", "bust.obj", "--views", "some.json", "-o", "x.png"}).error,
              HasSubstr("the verb texture takes photographs with their cameras"));
}

/// A bust beside the origin, and cameras that mean another axis upright.
TEST_F(MessyPhotographs, ExchangedAxesAreToldByWhatTurnedCamerasWouldShow) {
  Model aside = read_model(*folder / "bust.obj");
  for (Vector3& place : aside.mesh.positions) place.y() += 10;
  write_model(*folder / "aside.obj", aside);
  ASSERT_EQ(call({"render", "aside.obj", "-o", "aside_view.png", "--size", "200x240", "--unlit", "--cameras", "aside.json"})
                .status,
            0);
  const auto said = [](const std::vector<std::string>& words) { return call(words).error; };
  const std::vector<std::string> texture = {"texture", "aside.obj", "--cameras", "aside.json", "-o", "x.png"},
                                 cameras = {"cameras", "aside.json", "--mesh", "aside.obj"};
  for (const auto& words : {texture, cameras}) EXPECT_THAT(said(words), Not(HasSubstr("turned by 90 degrees")));
  nlohmann::json turned = nlohmann::json::parse(file_bytes(*folder / "aside.json"));
  for (auto& row : turned["cameras"][0]["rotation"]) row = {row[0], -row[2].get<double>(), row[1]};
  write_bytes(*folder / "aside.json", turned.dump());
  for (const auto& words : {texture, cameras})
    EXPECT_THAT(said(words), HasSubstr("turned by 90 degrees about x the mesh would be in the pictures"));
}

TEST_F(MessyPhotographs, ThePageShowsWhereSomebodyWasLeftOut) {
  write_passer_by();
  const auto share_of_one = [](const std::string& third) {
    write_set("paged.json", {0, 1, 2, 3, 4, 5, 6, 7}, [&](int k) { return k == 2 ? third : picture(k); });
    EXPECT_EQ(call({"texture", "bust.obj", "--cameras", "paged.json", "-o", "x.png", "--picture", "page.png"}).status, 0);
    const Image<float> page = read_texture(*folder / "page.png").pixels;
    int count = 0;  // of the colour of one photograph
    for (int y = 0; y < page.height(); ++y)
      for (int x = 0; x < page.width(); ++x) {
        const auto pixel = page.pixel(x, y);
        count += std::abs(pixel[0] - 0.99F) < 0.02F && std::abs(pixel[1] - 0.85F) < 0.02F && std::abs(pixel[2] - 0.35F) < 0.02F;
      }
    return count;
  };
  EXPECT_GT(share_of_one("passer_by.png"), share_of_one(picture(2)) + 500);
}

TEST_F(MessyPhotographs, PicturesThatCannotBeWrittenAreRefusedBeforeAnyWork) {
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {"texture", "no.obj", "--cameras", "no.json", "-o", "x.png", "--picture", "page.pdf"},
           {"cameras", "no.json", "--mesh", "no.obj", "--picture", "page.pdf"},
           {"evolve", "no_%d.obj", "-o", "x.evolving", "--picture", "page.pdf"},
           {"unwrap", "no.evolving", "-o", "x.evolving", "--picture", "page.pdf"},
           {"render", "no.obj", "-o", "page.pdf"}}) {
    const Result result = call(words);
    EXPECT_EQ(result.status, 2) << words[0];
    EXPECT_THAT(result.error, HasSubstr("page.pdf, whose extension names no picture")) << words[0];
    EXPECT_THAT(result.error, Not(HasSubstr("no.obj"))) << words[0];
  }
}

TEST_F(MessyPhotographs, APictureOfTwoFilesOfCamerasCountsOnce) {
  write_set("first.json", {0, 1, 2}), write_set("second.json", {2, 3});
  write_set("all.json", {0, 1, 2, 3});
  const Result result =
      call({"texture", "bust.obj", "--cameras", "first.json", "--cameras", "second.json", "-o", "twice.png"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("first.json: 1 picture is in second.json too: taken once"));
  EXPECT_THAT(result.output, HasSubstr("4 of 4 photographs used"));
  ASSERT_EQ(call({"texture", "bust.obj", "--cameras", "all.json", "-o", "once.png"}).status, 0);
  EXPECT_EQ(file_bytes(*folder / "twice.png"), file_bytes(*folder / "once.png"));
}

TEST_F(MessyPhotographs, PicturesAreFoundInFoldersOfTheirFolder) {
  namespace fs = std::filesystem;
  for (const char* below : {"deep/left/a", "deep/right"}) fs::create_directories(*folder / below);
  fs::copy_file(*folder / picture(0), *folder / "deep/left/a/first.png");
  fs::copy_file(*folder / picture(1), *folder / "deep/right/SECOND.png");
  write_set("deep.json", {0, 1}, [](int k) { return k == 0 ? "first.png" : "second.jpg"; });
  const Result result = call({"cameras", "deep.json", "--images", "deep", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["result"]["found"], 2);

  fs::copy_file(*folder / picture(2), *folder / "deep/right/first.png");
  EXPECT_THAT(call({"cameras", "deep.json", "--images", "deep"}).error,
              HasSubstr("may be deep/left/a/first.png or deep/right/first.png"));
  write_set("deep.json", {0}, [](int) { return "C:\\photos\\right\\first.png"; });
  EXPECT_EQ(call({"cameras", "deep.json", "--images", "deep", "--json"}).json()["result"]["found"], 1);
}

TEST_F(MessyPhotographs, TheModelsOwnTextureStaysWhereNothingIsSeenIfAsked) {
  write_set("one.json", {0});
  const std::vector<std::string> words = {"texture", "bust.obj", "--cameras", "one.json", "-o", "made.png"};
  ASSERT_EQ(call(words).status, 0);
  const double filled = share_that_differs("made.png", "bust.png");
  std::vector<std::string> keeping = words;
  keeping.insert(keeping.end(), {"--unseen", "keep"});
  const Result result = call(keeping);
  ASSERT_EQ(result.status, 0) << result.error;
  const double kept = share_that_differs("made.png", "bust.png");
  EXPECT_GT(filled, 20);
  EXPECT_LT(kept, filled / 4);
  keeping.insert(keeping.end(), {"--size", "128"});
  EXPECT_THAT(call(keeping).error, HasSubstr("--unseen keep: it keeps the texels of the model's own picture"));
}

TEST_F(MessyPhotographs, ThePageHasALegendAndStandsUprightAsAsked) {
  write_set("some.json", {0, 2, 4});
  const std::vector<std::string> words = {"texture", "bust.obj", "--cameras", "some.json", "-o", "x.png", "--picture"};
  const auto page = [&](std::vector<std::string> more) {
    more.insert(more.begin(), words.begin(), words.end());
    const Result result = call(more);
    EXPECT_EQ(result.status, 0) << result.error;
    return read_texture(*folder / "page.png").pixels;
  };
  const Image<float> upright = page({"page.png"}), other = page({"page.png", "--up", "z"});
  EXPECT_FALSE(std::ranges::equal(upright.values(), other.values()));
  // Of each photograph the colour in which its texels are, in the legend too: a row of that colour, wider than a view has.
  std::vector<int> longest(3, 0);
  for (int y = 0; y < upright.height(); ++y)
    for (int x = 0, run = 0; x < upright.width(); ++x) {
      run = x > 0 && std::ranges::equal(upright.pixel(x, y), upright.pixel(x - 1, y)) ? run + 1 : 1;
      const auto pixel = upright.pixel(x, y);
      const bool coloured = std::ranges::max(pixel) - std::ranges::min(pixel) > 0.1F;
      if (coloured && run == 330) ++longest[0];
    }
  EXPECT_GE(longest[0], 24 * (3 + 4 + 3));
  EXPECT_THAT(call({"texture", "bust.obj", "--cameras", "some.json", "-o", "x.png", "--up", "z"}).error,
              HasSubstr("--up: it is of --picture"));
}

TEST_F(MessyPhotographs, WhatIsKeptOfPhotographsThatDidNotChangeIsTaken) {
  for (int k = 0; k < 4; ++k)
    std::filesystem::copy_file(*folder / picture(k), *folder / fmt::format("kept{}.png", k));
  write_set("kept.json", {0, 1, 2, 3}, [](int k) { return fmt::format("kept{}.png", k); });
  const auto go_on = [](const std::string& output) {
    return call({"texture", "bust.obj", "--cameras", "kept.json", "-o", output, "--resume", "work"});
  };
  // The last one is damaged in the middle, which stops the work.
  const std::string whole = file_bytes(*folder / "kept3.png");
  std::string damaged = whole;
  for (std::size_t k = 0; k < 64; ++k) damaged[damaged.size() / 2 + k] = char(damaged[damaged.size() / 2 + k] ^ 0x55);
  write_bytes(*folder / "kept3.png", damaged);
  ASSERT_NE(go_on("stopped.png").status, 0);
  const auto time_of = [](int k) {
    return std::filesystem::last_write_time(*folder / fmt::format("work/align{}.photograph", k));
  };
  const auto before = time_of(0);
  // Then it is another one, and so is the second.
  write_bytes(*folder / "kept3.png", whole);
  write_bytes(*folder / "kept1.png", file_bytes(*folder / picture(5)));
  std::filesystem::remove(*folder / "kept3.png");
  ASSERT_NE(go_on("x.png").status, 0);  // not there: nothing is done
  write_bytes(*folder / "kept3.png", damaged);
  const Result again = go_on("x.png");
  EXPECT_NE(again.status, 0);
  EXPECT_THAT(again.error, HasSubstr("align1.photograph: was found with other photographs"));
  EXPECT_EQ(time_of(0), before) << "found again, though it did not change";
  write_bytes(*folder / "kept3.png", whole);
  ASSERT_EQ(go_on("gone_on.png").status, 0);
  ASSERT_EQ(call({"texture", "bust.obj", "--cameras", "kept.json", "-o", "anew.png"}).status, 0);
  EXPECT_EQ(file_bytes(*folder / "gone_on.png"), file_bytes(*folder / "anew.png"));
}

TEST_F(MessyPhotographs, DefectsAreListedOnce) {
  write_set("two.json", {0, 1});
  std::string obj = file_bytes(*folder / "bust.obj");
  write_bytes(*folder / "double.obj", obj + obj.substr(obj.rfind("\nf ") + 1));
  const nlohmann::json defects =
      call({"texture", "double.obj", "--cameras", "two.json", "-o", "x.png", "--json"}).json()["defects"];
  for (std::size_t k = 0; k < defects.size(); ++k)
    for (std::size_t m = 0; m < k; ++m) EXPECT_NE(defects[k], defects[m]);
  EXPECT_GT(defects.size(), 0U);
}

TEST_F(MessyPhotographs, WhatAFileSaysIsSaidOnce) {
  write_set("two.json", {0, 1});
  write_model(*folder / "moving.gltf", read_model(*folder / "bust.obj"));
  nlohmann::json moving = nlohmann::json::parse(file_bytes(*folder / "moving.gltf"));
  moving["animations"] = {{{"channels", nlohmann::json::array()}, {"samplers", nlohmann::json::array()}}};
  write_bytes(*folder / "moving.gltf", moving.dump());
  const std::vector<std::string> words = {"texture", "moving.gltf", "--cameras", "two.json", "-o", "x.glb", "--poses",
                                          "keep", "--size", "64"};
  for (const bool unwraps : {false, true}) {
    std::vector<std::string> all = words;
    if (unwraps) all.emplace_back("--unwrap");
    const std::string error = call(all).error, note = "animations are not used";
    ASSERT_THAT(error, HasSubstr(note));
    EXPECT_EQ(error.find(note), error.rfind(note)) << error;
  }
}

TEST_F(MessyPhotographs, APictureInsideTheModelIsNamedWithItsFile) {
  write_set("all.json", {0, 1, 2, 3, 4, 5, 6, 7});
  // Stripes of black and white leave values beyond both when they are put together.
  write_set("striped.json", {0, 2, 4, 6}, [](int k) { return fmt::format("striped{}.png", k); });
  for (const int k : {0, 2, 4, 6}) {
    Image<float> stripes = read_texture(*folder / picture(k)).pixels;
    for (int y = 0; y < stripes.height(); ++y)
      for (int x = 0; x < stripes.width(); ++x)
        for (int c = 0; c < 3; ++c) stripes(x, y, c) = float((y / 6 + k) % 2);
    write_image(*folder / fmt::format("striped{}.png", k), stripes);
  }
  const Result result = call({"texture", "bust.obj", "--cameras", "striped.json", "-o", "inside.glb", "--unwrap", "--size",
                              "128", "--poses", "keep", "--exposure", "keep"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_THAT(result.error, testing::ContainsRegex("inside.glb: its picture [a-z]+.png: [0-9]+ values beyond what 8 bits"));
}

/// Every other triangle turned over in the texture.
TEST_F(MessyPhotographs, FoldedTextureCoordinatesAreKeptIfAskedOrMadeAnew) {
  write_set("two.json", {0, 1});
  Model folded = read_model(*folder / "bust.obj");
  Mesh& mesh = folded.mesh;
  mesh.uvs.clear();
  for (const Vector3& place : mesh.positions) mesh.uvs.emplace_back(0.5 + 0.2 * place.x(), 0.5 + 0.2 * place.y());
  mesh.corner_uvs = mesh.triangles;
  write_model(*folder / "folded.obj", folded);
  std::vector<std::string> words = {"texture", "folded.obj", "--cameras", "two.json", "-o", "x.glb", "--poses", "keep", "--size",
                                    "128"};
  const Result refused = call(words);
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.error, HasSubstr("flipped_triangles"));
  EXPECT_THAT(refused.error, HasSubstr("--flipped keep"));
  EXPECT_THAT(refused.error, HasSubstr("--unwrap"));
  words.insert(words.end(), {"--flipped", "keep"});
  EXPECT_EQ(call(words).status, 0);
  words.back() = "few", words.emplace_back("--unwrap");
  EXPECT_EQ(call(words).status, 0);
}

TEST_F(MessyPhotographs, TrianglesOnOnePlaceOfTheTextureAreToBeUnwrapped) {
  write_set("two.json", {0, 1});
  const auto error = [&](const std::vector<Vector2>& uvs) {
    Model heaped = read_model(*folder / "bust.obj");
    heaped.mesh.uvs = uvs;
    heaped.mesh.corner_uvs.assign(heaped.mesh.triangles.size(), {0, 1, 2});
    write_model(*folder / "heaped.obj", heaped);
    const Result result = call({"texture", "heaped.obj", "--cameras", "two.json", "-o", "x.glb", "--size", "512"});
    EXPECT_EQ(result.status, 2);
    EXPECT_THAT(result.error, HasSubstr("new texture coordinates with --unwrap"));
    return result.error;
  };
  const std::string deep = error({{0, 0}, {1, 0}, {0, 1}});
  const std::size_t triangles = read_model(*folder / "bust.obj").mesh.triangles.size();
  EXPECT_THAT(deep, HasSubstr(fmt::format("in its texture {} triangles lie on each other", triangles)));
  EXPECT_THAT(deep, HasSubstr("100 % of the texels in use are covered more than once"));
  EXPECT_THAT(error({{0, 0}, {0, 0}, {0, 0}}), HasSubstr("no triangle has an area in the texture"));
}

/// A ball and a lattice of dots in both of two photographs, at other places.
TEST_F(MessyPhotographs, WhatTwoPhotographsAloneShowEachOtherwiseIsWarnedOf) {
  const auto in_front = [](int k) { return fmt::format("in_front{}.png", k); };
  for (const int k : {0, 1}) {
    Image<float> spoilt = read_texture(*folder / picture(k)).pixels;
    for (int y = 0; y < spoilt.height(); ++y)
      for (int x = 0; x < spoilt.width(); ++x)
        for (int c = 0; c < 3; ++c) {
          if (std::hypot(x - 110 + 25 * k, y - 120 - 30 * k) < 22) spoilt(x, y, c) = 0.43F;
          if (x % 8 < 3 && y % 8 < 3 && x > 80 && x < 120 && y > 60 && y < 100) spoilt(x, y, c) = 1;
        }
    write_image(*folder / in_front(k), spoilt);
  }
  write_set("clean.json", {0, 1}), write_set("spoilt.json", {0, 1}, in_front);
  const auto call_with = [](const std::string& cameras) {
    return call({"texture", "bust.obj", "--cameras", cameras, "-o", "x.png", "--report", "r.json"});
  };
  const std::string warning = "is shown by two photographs alone that disagree";
  EXPECT_THAT(call_with("clean.json").error, Not(HasSubstr(warning)));
  EXPECT_THAT(call_with("spoilt.json").error, HasSubstr(warning));
  EXPECT_GT(nlohmann::json::parse(file_bytes(*folder / "r.json"))["result"]["seen"]["undecided"], 0.03);
}

TEST_F(MessyPhotographs, ProgressLeavesTimeForThePage) {
  write_set("two.json", {0, 1});
  const Result result = call({"texture", "bust.obj", "--cameras", "two.json", "-o", "x.glb", "--unwrap", "--size", "256",
                              "--picture", "page.png", "--progress", "json"});
  ASSERT_EQ(result.status, 0) << result.error;
  const std::size_t end = result.error.rfind(",\"step\":\"solve"), begin = result.error.rfind("\"fraction\":", end) + 11;
  ASSERT_NE(end, std::string::npos) << result.error;
  EXPECT_LT(std::stod(result.error.substr(begin, end - begin)), 0.8);  // the page takes longer than so few texels
}

}  // namespace
}  // namespace mq::test

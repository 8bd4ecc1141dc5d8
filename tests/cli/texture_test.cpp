// marquetry texture: photographs of a sample with a known texture, spoilt in known ways.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "cli/program.h"
#include "io/foreign_cameras.h"
#include "mq/image/colour.h"
#include "mq/io/image_file.h"
#include "mq/io/model.h"

namespace mq::test {
namespace {

using testing::HasSubstr;

/// A bust and photographs of it from twelve sides.
class PhotographedBust : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder = new Folder;
    ASSERT_EQ(call({"sample", "bust", "--size", "256", "-o", "bust.obj"}), 0);
    for (int k = 0; k < views; ++k)
      ASSERT_EQ(call({"render", "bust.obj", "-o", file(k, "png"), "--view",
                      fmt::format("{},{}", 60 * (k % 6) + 30 * (k / 6), 10 + 40 * (k / 6)), "--size", "240x240",
                      "--unlit", "--cameras", file(k, "json")}),
                0);
  }
  static void TearDownTestSuite() { delete folder; }

  static std::string file(int k, const std::string& extension) { return fmt::format("view{}.{}", k, extension); }
  static int call(std::vector<std::string> words) {
    words.push_back("--overwrite");
    return marquetry(*folder, words).status;
  }
  static std::vector<std::string> with_cameras(std::vector<std::string> words) {
    for (int k = 0; k < views; ++k) words.insert(words.end(), {"--cameras", file(k, "json")});
    return words;
  }

  /// Root mean square of the difference from the bust's own texture, in steps of 8 bits, where the made
  /// one is not black.
  static double difference(const std::string& made) {
    const Image<float> truth = read_texture(folder->path() / "bust.png").pixels;
    const Image<float> result = read_texture(folder->path() / made).pixels;
    double sum = 0, count = 0;
    for (int y = 0; y < truth.height(); ++y)
      for (int x = 0; x < truth.width(); ++x) {
        if (result(x, y, 0) + result(x, y, 1) + result(x, y, 2) == 0) continue;
        for (int c = 0; c < 3; ++c) sum += std::pow(255 * (truth(x, y, c) - result(x, y, c)), 2), count += 1;
      }
    return std::sqrt(sum / count);
  }

  /// Each photograph's pixels changed, until the test ends.
  template <class Change>
  static void spoil(const Change& change) {
    for (int k = 0; k < views; ++k) {
      Texture picture = read_texture(folder->path() / file(k, "png"));
      std::filesystem::copy_file(folder->path() / file(k, "png"), folder->path() / ("kept_" + file(k, "png")));
      change(k, picture.pixels);
      write_image(folder->path() / file(k, "png"), picture.pixels);
    }
  }
  void TearDown() override {
    for (int k = 0; k < views; ++k)
      if (const auto kept = folder->path() / ("kept_" + file(k, "png")); std::filesystem::exists(kept))
        std::filesystem::rename(kept, folder->path() / file(k, "png"));
  }

  static constexpr int views = 12;
  static inline Folder* folder = nullptr;
};

TEST_F(PhotographedBust, ComesBackAndExposuresPassersByAndBlurCostLittle) {
  ASSERT_EQ(call(with_cameras({"texture", "bust.obj", "-o", "made.png"})), 0);
  const double plain = difference("made.png");
  EXPECT_LT(plain, 15);  // small photographs, and what none shows

  spoil([](int k, Image<float>& picture) {
    const float gain = 0.8F + 0.1F * float(k % 5);
    for (int y = 0; y < picture.height(); ++y)
      for (int x = 0; x < picture.width(); ++x) {
        for (int c = 0; c < 3; ++c) picture(x, y, c) = std::min(1.0F, gain * picture(x, y, c));
        if (k % 4 == 0 && std::hypot(x - 120, y - 130) < 28) picture(x, y, 1) = 1, picture(x, y, 0) = 0;
      }
  });
  ASSERT_EQ(call(with_cameras({"texture", "bust.obj", "-o", "spoilt.png"})), 0);
  EXPECT_LT(difference("spoilt.png"), 1.2 * 15);
  ASSERT_EQ(call(with_cameras({"texture", "bust.obj", "-o", "kept.png", "--exposure", "keep", "--outliers", "keep",
                               "--blend", "best"})),
            0);
  EXPECT_GT(difference("kept.png"), difference("spoilt.png"));
}

TEST_F(PhotographedBust, BareMeshesBecomeModelsOfTheSizePhotographsResolve) {
  Model bare = read_model(*folder / "bust.obj");
  bare.mesh.uvs.clear(), bare.mesh.corner_uvs.clear(), bare.mesh.textures.clear(), bare.textures.clear();
  write_model(*folder / "bare.ply", bare);
  const Result result = marquetry(*folder, with_cameras({"texture", "bare.ply", "-o", "made.glb", "--picture",
                                                         "page.png", "--report", "r.json", "--overwrite"}));
  ASSERT_EQ(result.status, 0) << result.error;
  const Model made = read_model(folder->path() / "made.glb");
  ASSERT_EQ(made.textures.size(), 1U);
  EXPECT_EQ(made.textures[0].pixels.width(), 512);
  EXPECT_TRUE(std::filesystem::exists(folder->path() / "page.png"));
  std::ifstream report(folder->path() / "r.json");
  const nlohmann::json found = nlohmann::json::parse(report)["result"];
  EXPECT_EQ(found["views"].size(), std::size_t(views));
  std::int64_t texels = 0;
  for (const auto& view : found["views"]) texels += view["texels"].get<std::int64_t>();
  EXPECT_EQ(texels + found["unseen"].get<std::int64_t>(), found["unknowns"].get<std::int64_t>());
  EXPECT_NEAR(found["seen"]["by_none"].get<double>() + found["seen"]["by_one"].get<double>() +
                  found["seen"]["by_two"].get<double>() + found["seen"]["by_more"].get<double>(),
              1, 1e-9);
}

TEST_F(PhotographedBust, PhotographsAreNotReplacedByTheTexture) {
  std::filesystem::create_directory(*folder / "beside");
  std::filesystem::copy_file(*folder / "view0.png", *folder / "beside/bust.png");
  Model bare = read_model(*folder / "bust.obj");
  bare.textures.clear();
  write_model(*folder / "beside/bust.ply", bare);
  nlohmann::json cameras = nlohmann::json::parse(file_bytes(*folder / "view0.json"));
  cameras["cameras"][0]["image"] = "bust.png";
  write_bytes(*folder / "beside/one.json", cameras.dump());
  // The picture of bust.obj would be bust.png.
  marquetry(*folder, {"texture", "beside/bust.ply", "--cameras", "beside/one.json", "-o", "beside/bust.obj"});
  EXPECT_EQ(file_bytes(*folder / "beside/bust.png"), file_bytes(*folder / "view0.png"));
}

TEST_F(PhotographedBust, ThreadsDoNotMatter) {
  std::vector<std::string> words = with_cameras({"texture", "bust.obj"});
  std::vector<std::string> one = words, two = words;
  one.insert(one.end(), {"-o", "one.png", "--threads", "1"});
  two.insert(two.end(), {"-o", "two.png", "--threads", "2"});
  ASSERT_EQ(call(one), 0);
  ASSERT_EQ(call(two), 0);
  EXPECT_EQ(file_bytes(folder->path() / "one.png"), file_bytes(folder->path() / "two.png"));
}

TEST_F(PhotographedBust, BlendsAreWhatTheySay) {
  for (const std::string how : {"best", "mean", "detail"})
    ASSERT_EQ(call(with_cameras({"texture", "bust.obj", "-o", how + ".png", "--blend", how})), 0);
  ASSERT_EQ(call(with_cameras({"texture", "bust.obj", "-o", "usual.png"})), 0);
  EXPECT_EQ(file_bytes(*folder / "usual.png"), file_bytes(*folder / "detail.png"));
  EXPECT_LT(difference("mean.png"), 1.1 * difference("best.png"));

  // Noise goes where it is averaged.
  spoil([](int k, Image<float>& picture) {
    std::uint32_t random = 17 + std::uint32_t(k);
    for (float& value : picture.values()) {
      random = 1664525 * random + 1013904223;
      value = std::clamp(value + 0.2F * (float(random >> 8) / float(1 << 24) - 0.5F), 0.0F, 1.0F);
    }
  });
  std::vector<double> noisy;
  for (const std::string how : {"best", "mean", "detail"}) {
    ASSERT_EQ(call(with_cameras({"texture", "bust.obj", "-o", "noisy.png", "--poses", "keep", "--blend", how})), 0);
    noisy.push_back(difference("noisy.png"));
  }
  EXPECT_LT(noisy[1], noisy[0]);
  EXPECT_LT(noisy[1], noisy[2]);
}

/// Labels that say one photograph everywhere: it is taken where it shows the bust, the mean of all elsewhere.
TEST_F(PhotographedBust, MeansGiveWayToLabels) {
  write_image(folder->path() / "labels.png", Image<float>(256, 256, 1, 0.0F));
  spoil([](int k, Image<float>& picture) {
    if (k == 0)
      for (float& value : picture.values()) value = std::min(1.0F, 0.6F * value);
  });
  const std::vector<std::string> as_they_are = {"--poses", "keep", "--exposure", "keep", "--outliers", "keep"};
  int filled = 0;
  const auto made = [&](const std::string& file, std::vector<std::string> words) {
    words.insert(words.end(), as_they_are.begin(), as_they_are.end());
    words.insert(words.begin(), {"texture", "bust.obj", "-o", file, "--json", "--overwrite"});
    const Result result = marquetry(*folder, with_cameras(words));
    EXPECT_EQ(result.status, 0) << result.error;
    filled = result.json()["result"]["unseen"].get<int>();
    return read_texture(folder->path() / file).pixels;
  };
  const Image<float> mean = made("mean.png", {"--blend", "mean", "--alpha", "0"});
  const Image<float> best = made("best.png", {"--blend", "best", "--labels", "labels.png", "--alpha", "0"});
  const Image<float> both = made("both.png", {"--blend", "mean", "--labels", "labels.png", "--alpha", "0"});
  int of_best = 0, of_mean = 0, of_neither = 0;
  for (int y = 0; y < mean.height(); ++y)
    for (int x = 0; x < mean.width(); ++x) {
      const auto is = [&](const Image<float>& other) { return std::ranges::equal(both.pixel(x, y), other.pixel(x, y)); };
      if (is(best) != is(mean)) ++(is(best) ? of_best : of_mean);
      of_neither += !is(best) && !is(mean);
    }
  EXPECT_GT(of_best, 5000);
  EXPECT_GT(of_mean, 5000);
  EXPECT_LE(of_neither, filled);  // from what is around
}

TEST_F(PhotographedBust, WorkThatWasStoppedGoesOn) {
  ASSERT_EQ(call(with_cameras({"texture", "bust.obj", "-o", "whole.png"})), 0);
  const auto go_on = [] {
    return marquetry(*folder,
                     with_cameras({"texture", "bust.obj", "-o", "gone_on.png", "--resume", "kept", "--overwrite"}));
  };
  // A last photograph that is damaged in the middle, which its head does not tell: the others are kept.
  const std::string last = file_bytes(*folder / file(views - 1, "png"));
  const auto time = std::filesystem::last_write_time(*folder / file(views - 1, "png"));
  std::string damaged = last;
  for (std::size_t k = 0; k < 64; ++k) damaged[damaged.size() / 2 + k] = char(damaged[damaged.size() / 2 + k] ^ 0x55);
  write_bytes(*folder / file(views - 1, "png"), damaged);
  std::filesystem::last_write_time(*folder / file(views - 1, "png"), time);
  EXPECT_NE(go_on().status, 0);
  EXPECT_FALSE(std::filesystem::exists(*folder / "gone_on.png"));
  ASSERT_TRUE(std::filesystem::exists(*folder / "kept/align0.photograph"));
  EXPECT_FALSE(std::filesystem::exists(*folder / "kept" / fmt::format("align{}.photograph", views - 1)));
  write_bytes(*folder / file(views - 1, "png"), last);
  std::filesystem::last_write_time(*folder / file(views - 1, "png"), time);

  // One of those kept is damaged, one cut short.
  std::string kept = file_bytes(*folder / "kept/align1.photograph");
  kept[kept.size() / 2] = char(kept[kept.size() / 2] ^ 1);
  write_bytes(*folder / "kept/align1.photograph", kept);
  std::filesystem::resize_file(*folder / "kept/align2.photograph", 20);
  const Result result = go_on();
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("align1.photograph: is cut short or damaged"));
  EXPECT_THAT(result.error, HasSubstr("align2.photograph: is cut short or damaged"));
  EXPECT_THAT(result.error, testing::Not(HasSubstr("align3.photograph")));
  EXPECT_EQ(file_bytes(*folder / "gone_on.png"), file_bytes(*folder / "whole.png"));
  EXPECT_FALSE(std::filesystem::exists(*folder / "kept"));
}

TEST_F(PhotographedBust, WhatWasKeptOfOthersIsNotTaken) {
  std::filesystem::create_directory(*folder / "others");
  write_bytes(*folder / "others/look0.photograph", "mqphot01 of something else");
  write_bytes(*folder / "others/mine.txt", "stays");
  ASSERT_EQ(call(with_cameras({"texture", "bust.obj", "-o", "plain.png"})), 0);
  const Result result =
      marquetry(*folder, with_cameras({"texture", "bust.obj", "-o", "beside.png", "--resume", "others"}));
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(file_bytes(*folder / "beside.png"), file_bytes(*folder / "plain.png"));
  EXPECT_EQ(file_bytes(*folder / "others/mine.txt"), "stays");
  EXPECT_THAT(marquetry(*folder, with_cameras({"texture", "bust.obj", "-o", "x.png", "--resume", "bust.obj"})).error,
              HasSubstr("bust.obj: cannot be made a folder to keep work in"));
}

/// One set of cameras, written as others write them, is the same cameras.
TEST_F(PhotographedBust, FormatsOfCamerasDoNotMatter) {
  ASSERT_EQ(call(with_cameras({"texture", "bust.obj", "-o", "own.png", "--poses", "keep"})), 0);
  const Image<float> own = read_texture(*folder / "own.png").pixels;
  ForeignCameras foreign;
  for (int k = 0; k < views; ++k) {
    foreign.set.push_back(read_cameras(*folder / file(k, "json")).at(0));
    foreign.set.back().picture = file(k, "png");
  }
  write_cameras(*folder / "all.json", foreign.set);
  for (const std::string path : {"transforms.json", "colmap"})
    ASSERT_EQ(call({"cameras", "all.json", "-o", path}), 0) << path;
  ASSERT_EQ(call({"cameras", "all.json", "-o", "colmap_binary", "--format", "colmap-binary"}), 0);
  std::string pictures;
  for (const Photograph& photograph : foreign.set) pictures += photograph.picture.string() + "\n";
  write_bytes(*folder / "bundle.out", foreign.bundler()), write_bytes(*folder / "list.txt", pictures);
  write_bytes(*folder / "metashape.xml", foreign.metashape());
  std::filesystem::create_directory(*folder / "xmp");
  for (std::size_t k = 0; k < foreign.set.size(); ++k)
    write_bytes(*folder / fmt::format("xmp/view{}.xmp", k), foreign.xmp(k, "brown3"));
  write_bytes(*folder / "scene.gltf", foreign.gltf());
  write_bytes(*folder / "scene.mvs", std::string(text_of(foreign.openmvs(7))));

  for (const std::string format : {"transforms.json", "colmap", "colmap_binary", "bundle.out", "metashape.xml", "xmp",
                                   "scene.gltf", "scene.mvs"}) {
    const Result result = marquetry(*folder, {"texture", "bust.obj", "--cameras", format, "--images", ".", "-o",
                                              "other.png", "--poses", "keep", "--overwrite"});
    ASSERT_EQ(result.status, 0) << format << result.error;
    const Image<float> other = read_texture(*folder / "other.png").pixels;
    float most = 0;
    for (std::size_t i = 0; i < own.values().size(); ++i)
      most = std::max(most, std::abs(own.values()[i] - other.values()[i]));
    EXPECT_LE(255 * most, 1.001F) << format;
  }
}

TEST_F(PhotographedBust, GoesOnWithoutWhatIsMissingWhereAsked) {
  nlohmann::json all = nlohmann::json::parse(file_bytes(*folder / file(0, "json")));
  for (const char* name : {"gone.png", "empty.png"}) {
    all["cameras"].push_back(all["cameras"][0]);
    all["cameras"].back()["image"] = name;
  }
  write_bytes(*folder / "gaps.json", all.dump());
  write_bytes(*folder / "empty.png", "");
  std::vector<std::string> words = {"texture", "bust.obj", "--cameras", "gaps.json", "-o", "gaps.png", "--overwrite"};
  EXPECT_THAT(marquetry(*folder, words).error, HasSubstr("or go on without them (--missing skip)"));
  words.insert(words.end(), {"--missing", "skip", "--json"});
  const Result result = marquetry(*folder, words);
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["result"]["views"].size(), 1U);
  EXPECT_THAT(result.error, HasSubstr("gaps.json: 1 picture is not there and left out: gone.png"));
  EXPECT_THAT(result.error, HasSubstr("empty.png: the file is empty; a picture was expected: left out"));
  ASSERT_EQ(call({"texture", "bust.obj", "--cameras", file(0, "json"), "-o", "one.png"}), 0);
  EXPECT_EQ(file_bytes(*folder / "gaps.png"), file_bytes(*folder / "one.png"));
  std::filesystem::create_directory(*folder / "nothing");
  EXPECT_THAT(marquetry(*folder, {"texture", "bust.obj", "--cameras", "gaps.json", "--images", "nothing", "-o", "x.png",
                                  "--missing", "skip"})
                  .error,
              HasSubstr("none of the photographs is there"));
}

/// Damage in the middle, which heads do not tell, is found when a photograph is read: at first, or after others.
TEST_F(PhotographedBust, GoesOnWithoutWhatIsDamagedInTheMiddleWhereAsked) {
  std::string damaged = file_bytes(*folder / file(1, "png"));
  for (std::size_t k = 0; k < 64; ++k) damaged[damaged.size() / 2 + k] = char(damaged[damaged.size() / 2 + k] ^ 0x55);
  write_bytes(*folder / "damaged.png", damaged);
  const auto cameras_of = [](const std::vector<int>& which) {
    nlohmann::json all = {{"cameras", nlohmann::json::array()}};
    for (const int k : which) {
      all["cameras"].push_back(nlohmann::json::parse(file_bytes(*folder / file(k, "json")))["cameras"][0]);
      if (k == 1) all["cameras"].back()["image"] = "damaged.png";
    }
    return all.dump();
  };
  write_bytes(*folder / "whole.json", cameras_of({0, 2, 7}));
  write_bytes(*folder / "damaged.json", cameras_of({0, 1, 2, 7}));
  for (const std::string poses : {"align", "keep"}) {
    std::vector<std::string> words = {"texture", "bust.obj", "--cameras", "damaged.json", "-o", "damaged_made.png",
                                      "--poses", poses, "--overwrite"};
    EXPECT_THAT(marquetry(*folder, words).error, HasSubstr("or go on without it (--missing skip)"));
    words.insert(words.end(), {"--missing", "skip", "--json"});
    const Result result = marquetry(*folder, words);
    ASSERT_EQ(result.status, 0) << result.error;
    EXPECT_THAT(result.error, HasSubstr("damaged.png: cut short or damaged at rows"));
    const nlohmann::json views = result.json()["result"]["views"];
    ASSERT_EQ(views.size(), 4U);
    EXPECT_THAT(views[1]["left_out"].get<std::string>(), HasSubstr("damaged.png: cut short or damaged at rows"));
    EXPECT_EQ(views[1]["patches"], 0);
    EXPECT_FALSE(views[0].contains("left_out"));
    ASSERT_EQ(call({"texture", "bust.obj", "--cameras", "whole.json", "-o", "whole_made.png", "--poses", poses}), 0);
    EXPECT_EQ(file_bytes(*folder / "damaged_made.png"), file_bytes(*folder / "whole_made.png"));
  }
}

TEST_F(PhotographedBust, AllThatCannotBeReadAreNamedAtOnce) {
  const std::string whole = file_bytes(*folder / file(1, "png"));
  write_bytes(*folder / "short.png", whole.substr(0, whole.size() / 2));
  write_bytes(*folder / "none.png", "no picture");
  nlohmann::json all = nlohmann::json::parse(file_bytes(*folder / file(0, "json")));
  for (const char* name : {"short.png", "none.png"}) {
    all["cameras"].push_back(all["cameras"][0]);
    all["cameras"].back()["image"] = name;
  }
  write_bytes(*folder / "two_bad.json", all.dump());
  const std::string error =
      marquetry(*folder, {"texture", "bust.obj", "--cameras", "two_bad.json", "-o", "x.png"}).error;
  EXPECT_THAT(error, HasSubstr("short.png: the PNG file is cut short"));
  EXPECT_THAT(error, HasSubstr("none.png: not a picture"));
  EXPECT_THAT(error, HasSubstr("or go on without them (--missing skip)"));
}

TEST_F(PhotographedBust, WhatCannotBeIsRefused) {
  const auto error = [](std::vector<std::string> words) {
    return marquetry(*folder, words).error;
  };
  EXPECT_THAT(error({"texture", "bust.png", "--cameras", "view0.json", "-o", "x.png"}), HasSubstr("picture"));
  EXPECT_THAT(error({"texture", "bust.obj", "--cameras", "no.json", "-o", "x.png"}), HasSubstr("no.json"));
  EXPECT_THAT(error(with_cameras({"texture", "bust.obj", "--unwrap", "-o", "x.png"})),
              HasSubstr("cannot hold the texture coordinates"));
  std::ofstream(folder->path() / "away.json")
      << R"({"cameras": [{"image": "view0.png", "width": 240, "height": 240, "fx": 300,
             "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "translation": [0, 0, -1e6]}]})";
  EXPECT_THAT(error({"texture", "bust.obj", "--cameras", "away.json", "-o", "x.png"}),
              HasSubstr("no photograph shows any of it: most cameras stand"));
  EXPECT_FALSE(std::filesystem::exists(folder->path() / "x.png"));
}

/// Means of two by two pixels.
Image<float> halved(const Image<float>& image) {
  Image<float> half(image.width() / 2, image.height() / 2, image.channels());
  for (int y = 0; y < half.height(); ++y)
    for (int x = 0; x < half.width(); ++x)
      for (int c = 0; c < half.channels(); ++c)
        half(x, y, c) = (image(2 * x, 2 * y, c) + image(2 * x + 1, 2 * y, c) +
                         image(2 * x, 2 * y + 1, c) + image(2 * x + 1, 2 * y + 1, c)) /
                        4;
  return half;
}

/// A model without a picture, and pictures of it from all sides.
TEST(Texture, OfABallIsWhatWasPhotographed) {
  const Folder folder;
  ASSERT_EQ(marquetry(folder, {"sample", "sphere", "--size", "128", "-o", "ball.obj"}).status, 0);
  std::vector<std::string> words = {"texture", "bare.obj", "-o", "out.png", "--json", "--overwrite"};
  for (const std::string view : {"0,0", "90,0", "180,0", "270,0", "1,85", "2,-85"}) {
    const std::string name = "view" + view.substr(0, view.find(','));
    ASSERT_EQ(marquetry(folder,
                        {"render", "ball.obj", "--unlit", "--size", "500", "--background", "black",
                         "--view", view, "-o", name + ".png", "--cameras", name + ".json"})
                  .status,
              0);
    words.insert(words.end(), {"--cameras", name + ".json"});
  }
  std::string obj = file_bytes(folder / "ball.obj");
  for (const std::string line : {"mtllib ball.mtl\n", "usemtl ball\n"})
    if (const auto at = obj.find(line); at != std::string::npos) obj.erase(at, line.size());
  write_bytes(folder / "bare.obj", obj);
  const Result result = marquetry(folder, words);
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["result"]["views"].size(), 6U);
  EXPECT_EQ(read_texture(folder / "out.png").pixels.width(), 1024);

  // A picture made smaller since is taken for what it is, one of other proportions refused.
  const Image<float> whole = read_texture(folder / "view0.png").pixels;
  write_image(folder / "view0.png", halved(whole));
  const Result remarked = marquetry(folder, words);
  EXPECT_EQ(remarked.status, 0) << remarked.error;
  EXPECT_THAT(remarked.error, HasSubstr("view0.png: is 250 × 250, and its camera is of pictures of "
                                        "500 × 500: it is taken for the same picture"));
  write_image(folder / "view0.png", Image<float>(500, 400, 3, 0.5F));
  EXPECT_THAT(marquetry(folder, {"texture", "bare.obj", "-o", "other.png", "--cameras", "view0.json"}).error,
              HasSubstr("view0.png: is 500 × 400, and its camera is of pictures of 500 × 500"));
  write_image(folder / "view0.png", whole);

  // With the model's own picture in its place: near to what was photographed.
  words[1] = "ball.obj";
  ASSERT_EQ(marquetry(folder, words).status, 0);
  const Image<float> truth = read_texture(folder / "ball.png").pixels;
  const Image<float> found = read_texture(folder / "out.png").pixels;
  ASSERT_EQ(marquetry(folder, {"mask", "ball.obj", "-o", "used.png", "-w", "depth"}).status, 0);
  const Image<float> used = read_texture(folder / "used.png").pixels;
  double sum = 0;
  int count = 0;
  for (int y = 0; y < 128; ++y)
    for (int x = 0; x < 128; ++x)
      for (int c = 0; c < 3 && used(x, y) > 0; ++c, ++count)
        sum += std::pow(found(x, y, c) - truth(x, y, c), 2);
  EXPECT_GT(count, 10000);
  EXPECT_LT(std::sqrt(sum / count), 0.06);

  // With a picture of light in its place: the same, as light.
  Image<float> light = truth;
  for (float& value : light.values()) value = float(linear_from_srgb(value));
  write_image(folder / "light.exr", light, Depth::f32);
  words.insert(words.begin() + 2, "light.exr");
  for (const std::string space : {"stored", "log"}) {
    std::vector<std::string> more = words;
    more.insert(more.end(), {"--space", space});
    ASSERT_EQ(marquetry(folder, more).status, 0);
    const Image<float> seen = read_texture(folder / "out.png").pixels;
    sum = 0;
    for (int y = 0; y < 128; ++y)
      for (int x = 0; x < 128; ++x)
        for (int c = 0; c < 3 && used(x, y) > 0; ++c)
          sum += std::pow(srgb_from_linear(seen(x, y, c)) - found(x, y, c), 2);
    EXPECT_LT(std::sqrt(sum / count), 0.02) << space;
  }
}

}  // namespace
}  // namespace mq::test

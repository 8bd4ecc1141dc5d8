#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "cli/browser.h"
#include "cli/file_server.h"
#include "cli/program.h"
#include "cli/refusal.h"
#include "mq/io/image_file.h"
#include "mq/io/video.h"

namespace mq::test {
namespace {

using testing::HasSubstr;
using testing::Not;

/// Two balls that touch, followed and laid out once for all tests.
class Play : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = std::make_unique<Folder>();
    ASSERT_EQ(marquetry(*shared_, {"sample", "merging", "-o", "balls/", "--triangles", "1200",
                                   "--frames", "28-31"})
                  .status,
              0);
    const Result made = marquetry(
        *shared_, {"evolve", "balls", "-o", "balls.evolving", "--size", "128", "--trials", "2"});
    ASSERT_EQ(made.status, 0) << made.error;
  }
  static void TearDownTestSuite() { shared_.reset(); }

  void SetUp() override {
    std::filesystem::copy(shared_->path(), folder.path(), std::filesystem::copy_options::recursive);
  }

  const Folder folder;

 private:
  static std::unique_ptr<Folder> shared_;
};
std::unique_ptr<Folder> Play::shared_;

/// The share of pixels with colour in a part of a picture, left ≤ x < right in shares of its width.
double coloured(const Image<float>& picture, double left, double right) {
  int count = 0, all = 0;
  for (int y = 0; y < picture.height() * 4 / 5; ++y)
    for (int x = int(left * picture.width()); x < int(right * picture.width()); ++x) {
      const auto [low, high] = std::minmax({picture(x, y, 0), picture(x, y, 1), picture(x, y, 2)});
      count += high - low > 0.12F;
      ++all;
    }
  return double(count) / all;
}

TEST_F(Play, PlaysInABrowser) {
  if (!Browser::installed()) GTEST_SKIP() << "no chromium";
  const Result result = marquetry(folder, {"play", "balls.evolving", "-o", "page", "--from",
                                           "balls", "--size", "128", "--rate", "2", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["result"]["frames"], 4);
  EXPECT_GT(result.json()["result"]["video_bytes"], 1000);
  EXPECT_LT(result.json()["result"]["film_bytes"], std::filesystem::file_size(folder / "balls.blocks"));

  Browser browser(folder / "profile");
  const std::string page = "file://" + (folder / "page/index.html").string();
  const auto says = [&] {
    return browser.evaluate("document.getElementById('message').innerText");
  };
  browser.open(page + "#frame=30&atlas");
  ASSERT_TRUE(browser.becomes_true("document.body.dataset.frame == '30'")) << says();
  EXPECT_EQ(says(), "");
  const auto shot = [&] {
    browser.screenshot(folder / "shot.png");
    return read_texture(folder / "shot.png").pixels;
  };
  const Image<float> captured = shot();
  EXPECT_GT(coloured(captured, 0, 0.5), 0.05);
  EXPECT_GT(coloured(captured, 0.5, 1), 0.2);
  const auto choose = [&](const std::string& colours) {
    browser.evaluate("{const e = document.getElementById('colours'); e.value = '" + colours +
                     "'; e.dispatchEvent(new Event('change'));}");
  };
  choose("plain");
  EXPECT_LT(coloured(shot(), 0, 1), 0.01);
  choose("lives");  // they touch, and what is born or dies then has a colour
  EXPECT_GT(coloured(shot(), 0, 1), 0.002);

  browser.evaluate(
      "{const t = document.getElementById('time'); t.value = 1; "
      "t.dispatchEvent(new Event('input'));}");
  EXPECT_TRUE(browser.becomes_true("document.body.dataset.frame == '29'"));
  browser.evaluate(
      "window.seen = new Set(); setInterval(() => "
      "seen.add(document.body.dataset.frame), 5); "
      "document.getElementById('play').click();");
  EXPECT_TRUE(browser.becomes_true("seen.size == 4")) << "all frames are played";
}

TEST_F(Play, PlaysShapesAlone) {
  if (!Browser::installed()) GTEST_SKIP() << "no chromium";
  ASSERT_EQ(
      marquetry(folder, {"play", "balls.evolving", "-o", "page.html", "--frames", "29-31"}).status,
      0);
  Browser browser(folder / "profile");
  browser.open("file://" + (folder / "page.html").string());
  EXPECT_TRUE(browser.becomes_true("document.body.dataset.frame == '31'"));
  EXPECT_EQ(browser.evaluate("document.getElementById('colours').options.length"), 2);
  EXPECT_EQ(browser.evaluate("document.getElementById('message').innerText"), "");
}

/// A video of as many pictures, each of one colour.
void write_video(const std::filesystem::path& path, int pictures, const VideoOptions& options) {
  VideoWriter video(path, 64, 64, options);
  for (int f = 0; f < pictures; ++f) {
    Image<float> picture(64, 64, 3);
    for (std::size_t i = 0; i < picture.values().size(); i += 3) picture.values()[i] = 0.8F;
    video.write(picture);
  }
  video.finish();
}

TEST_F(Play, TakesTheRateOfAVideo) {
  write_video(folder / "four.mp4", 4, {.rate = 24});
  const std::vector<std::string> words = {"play",    "balls.evolving", "-o",    "page.html",
                                          "--video", "four.mp4",       "--json"};
  const Result result = marquetry(folder, words);
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["result"]["rate"], 24);
  EXPECT_THAT(file_bytes(folder / "page.html"), HasSubstr("\"rate\":24"));
  std::vector<std::string> other = words;
  other.insert(other.end(), {"-o", "other.html", "--rate", "60"});
  other.erase(other.begin() + 2, other.begin() + 4);
  EXPECT_THAT(refusal(folder, other, "other.html"),
              testing::AllOf(HasSubstr("60"), HasSubstr("24"), HasSubstr("four.mp4")));
  // What is nearly its own is its own, and that is said.
  other.back() = "23.976";
  std::vector<std::string> nearly = other;
  *std::ranges::find(nearly, "other.html") = "near.html";
  const Result near = marquetry(folder, nearly);
  ASSERT_EQ(near.status, 0) << near.error;
  EXPECT_EQ(near.json()["result"]["rate"], 24);
  EXPECT_THAT(near.error,
              testing::AllOf(HasSubstr("23.976"), HasSubstr("four.mp4 has 24"), HasSubstr("that of the video")));
  EXPECT_THAT(result.error, Not(HasSubstr("that of the video")));
  write_video(folder / "five.mp4", 5, {.rate = 24});
  other = {"play", "balls.evolving", "-o", "other.html", "--video", "five.mp4"};
  EXPECT_THAT(refusal(folder, other, "other.html"),
              testing::AllOf(HasSubstr("5 pictures"), HasSubstr("4 frames")));
  other.insert(other.end(), {"--frames", "28-30"});
  EXPECT_THAT(refusal(folder, other, "other.html"), HasSubstr("3 frames"));
}

TEST_F(Play, ShowsShapesWhereAVideoCannotBePlayed) {
  write_video(folder / "h265.mp4", 4, {.rate = 24, .codec = VideoCodec::h265});
  const Result result =
      marquetry(folder, {"play", "balls.evolving", "-o", "page.html", "--video", "h265.mp4"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_THAT(result.error,
              testing::AllOf(HasSubstr("warning"), HasSubstr("H.265"), HasSubstr("--codec h264")));
  if (!Browser::installed()) GTEST_SKIP() << "no chromium";
  // No browser plays what is no video behind its first bytes.
  write_bytes(folder / "none.webm", "\x1a\x45\xdf\xa3" + std::string(500, 'x'));
  ASSERT_EQ(marquetry(folder, {"play", "balls.evolving", "-o", "none.html", "--video", "none.webm"})
                .status,
            0);
  Browser browser(folder / "profile");
  browser.open("file://" + (folder / "none.html").string() + "#frame=30&colours=lives&seams");
  ASSERT_TRUE(browser.becomes_true("document.body.dataset.frame == '30'"));
  const std::string said =
      browser.evaluate("document.getElementById('message').innerText").get<std::string>();
  EXPECT_THAT(said, testing::AllOf(HasSubstr("cannot play"), HasSubstr("without textures")));
  EXPECT_EQ(browser.evaluate("document.getElementById('colours').options.length"), 2);
  browser.screenshot(folder / "shot.png");
  const Image<float> shot = read_texture(folder / "shot.png").pixels;
  EXPECT_GT(coloured(shot, 0, 1), 0.002);
}

TEST_F(Play, SaysOnlyWhatIsTrueOfAVideo) {
  if (!Browser::installed()) GTEST_SKIP() << "no chromium";
  write_video(folder / "four.webm", 4, {.rate = 2});
  ASSERT_EQ(marquetry(folder, {"play", "balls.evolving", "-o", "page.html", "--video", "four.webm",
                               "--rate", "4"})
                .status,
            0);
  Browser browser(folder / "profile");
  browser.open("file://" + (folder / "page.html").string() + "#frame=28");
  ASSERT_TRUE(browser.becomes_true("document.body.dataset.frame == '28'"));
  const std::string said =
      browser.evaluate("document.getElementById('message').innerText").get<std::string>();
  EXPECT_THAT(said, testing::AllOf(HasSubstr("2.00 s"), HasSubstr("1.00 s"), HasSubstr("--rate")));
}

TEST_F(Play, FetchesTheVideoBesideThePage) {
  if (!Browser::installed()) GTEST_SKIP() << "no chromium";
  write_video(folder / "four.webm", 4, {.rate = 2});
  const Result made = marquetry(folder, {"play", "balls.evolving", "-o", "page/", "--video", "four.webm", "--rate",
                                         "2", "--beside"});
  ASSERT_EQ(made.status, 0) << made.error;
  EXPECT_THAT(folder.names(),
              testing::IsSupersetOf({"page/film.blocks", "page/film.evolving", "page/film.webm", "page/index.html"}));
  for (const FileServer::Ranges ranges : {FileServer::Ranges::sent, FileServer::Ranges::ignored}) {
    const FileServer server(folder / "page", ranges);
    Browser browser(folder / (ranges == FileServer::Ranges::sent ? "profile" : "other"));
    browser.open(server.address() + "index.html#frame=30");
    ASSERT_TRUE(browser.becomes_true("document.body.dataset.frame == '30'"));
    EXPECT_EQ(browser.evaluate("document.getElementById('message').innerText"), "");
    browser.screenshot(folder / "shot.png");
    EXPECT_GT(coloured(read_texture(folder / "shot.png").pixels, 0, 1), 0.02);
    browser.evaluate("location.hash = 'frame=28'");
    EXPECT_TRUE(browser.becomes_true("document.body.dataset.frame == '28'"));
  }
}

TEST_F(Play, FollowsItsAddress) {
  if (!Browser::installed()) GTEST_SKIP() << "no chromium";
  ASSERT_EQ(marquetry(folder, {"play", "balls.evolving", "-o", "page.html"}).status, 0);
  Browser browser(folder / "profile");
  browser.open("file://" + (folder / "page.html").string() + "#frame=99");
  ASSERT_TRUE(browser.becomes_true("document.body.dataset.frame == '31'"));
  const auto says = [&] {
    return browser.evaluate("document.getElementById('message').innerText").get<std::string>();
  };
  EXPECT_THAT(says(), testing::AllOf(HasSubstr("no frame 99"), HasSubstr("28 to 31")));
  browser.evaluate("location.hash = 'frame=30&seams&colours=plain'");
  EXPECT_TRUE(browser.becomes_true("document.body.dataset.frame == '30'"));
  EXPECT_EQ(says(), "");
  EXPECT_EQ(browser.evaluate("document.getElementById('seams').checked"), true);
  EXPECT_EQ(browser.evaluate("document.getElementById('colours').value"), "plain");
  browser.evaluate("location.hash = 'frame=29'");
  EXPECT_TRUE(browser.becomes_true("document.body.dataset.frame == '29'"));
  EXPECT_EQ(browser.evaluate("document.getElementById('seams').checked"), false);
}

/// What a page says of its film, without its blocks.
nlohmann::json film_of(const std::filesystem::path& page) {
  const std::string text = file_bytes(page), mark = "const film = ";
  const std::size_t begin = text.find(mark) + mark.size();
  std::string script = text.substr(begin, text.find("</script>", begin) - begin);
  nlohmann::json film = nlohmann::json::parse(script.substr(0, script.rfind(';')));
  for (const char* data : {"title", "manifest", "blocks", "lives"}) film.erase(data);
  return film;
}

TEST_F(Play, PlaysWhatExportWrote) {
  ASSERT_EQ(marquetry(folder, {"play", "balls.evolving", "-o", "store.html"}).status, 0);
  const nlohmann::json wanted = film_of(folder / "store.html");
  for (const std::string name : {"balls.usda", "balls.usdz", "balls.glb"}) {
    SCOPED_TRACE(name);
    ASSERT_EQ(marquetry(folder, {"export", "balls.evolving", "-o", name, "--from", "balls", "--size", "128", "--rate", "12"}).status, 0);
    const Result result = marquetry(folder, {"play", name, "-o", "page.html", "--overwrite", "--json"});
    ASSERT_EQ(result.status, 0) << result.error;
    EXPECT_EQ(result.json()["result"]["rate"], 12);
    EXPECT_GT(result.json()["result"]["video_bytes"], 1000);
    const nlohmann::json film = film_of(folder / "page.html");
    EXPECT_EQ(film["frames"], wanted["frames"]);
    // To a step of the store.
    const double step = marquetry(folder, {"export", "balls.evolving", "--json"}).json()["result"]["step"];
    for (const char* corner : {"low", "high"})
      for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(film[corner][k].get<double>(), wanted[corner][k].get<double>(), step);
    for (std::size_t s = 0; s < wanted["segments"].size(); ++s)
      for (const char* count : {"first", "frames", "triangles", "has_uvs"})
        EXPECT_EQ(film["segments"][s][count], wanted["segments"][s][count]) << count << " of segment " << s;
  }
}

TEST_F(Play, ShowsThePicturesOfWhatExportWrote) {
  if (!Browser::installed()) GTEST_SKIP() << "no chromium";
  ASSERT_EQ(marquetry(folder, {"export", "balls.evolving", "-o", "balls.usdz", "--from", "balls", "--size", "128"}).status, 0);
  ASSERT_EQ(marquetry(folder, {"play", "balls.usdz", "-o", "page.html"}).status, 0);
  Browser browser(folder / "profile");
  browser.open("file://" + (folder / "page.html").string() + "#frame=30&atlas");
  ASSERT_TRUE(browser.becomes_true("document.body.dataset.frame == '30'"));
  EXPECT_EQ(browser.evaluate("document.getElementById('message').innerText"), "");
  browser.screenshot(folder / "shot.png");
  const Image<float> shown = read_texture(folder / "shot.png").pixels;
  EXPECT_GT(coloured(shown, 0, 0.5), 0.05);
  EXPECT_GT(coloured(shown, 0.5, 1), 0.2);
}

TEST_F(Play, TakesFilesThatMoveAsItTakesStores) {
  ASSERT_EQ(marquetry(folder, {"export", "balls.evolving", "-o", "balls.usda"}).status, 0);
  const Result part = marquetry(folder, {"play", "balls.usda", "-o", "page.html", "--frames", "29-30", "--rate", "5",
                                         "--from", "balls", "--size", "128", "--json"});
  ASSERT_EQ(part.status, 0) << part.error;
  EXPECT_EQ(part.json()["result"]["frames"], 2);
  EXPECT_EQ(part.json()["result"]["rate"], 5);
  EXPECT_GT(part.json()["result"]["video_bytes"], 1000);
  EXPECT_THAT(refusal(folder, {"play", "balls.usda", "-o", "other.html", "--codec", "av1"}, "other.html"),
              HasSubstr("--codec"));
  EXPECT_THAT(refusal(folder, {"play", "balls.usda", "-o", "other.html", "--frames", "99"}, "other.html"),
              HasSubstr("no frame 99"));
  ASSERT_EQ(marquetry(folder, {"export", "balls.usda", "-o", "frame_%04d.ply"}).status, 0);
  EXPECT_TRUE(std::filesystem::exists(folder / "frame_0031.ply"));
  const std::string text = file_bytes(folder / "balls.usda");
  write_bytes(folder / "cut.usda", text.substr(0, text.size() / 2));
  EXPECT_THAT(refusal(folder, {"play", "cut.usda", "-o", "other.html"}, "other.html"),
              testing::AllOf(HasSubstr("cut.usda, line"), HasSubstr("cut short")));
}

TEST_F(Play, RefusesTexturesWithoutAnAtlas) {
  ASSERT_EQ(marquetry(folder, {"track", "balls", "-o", "bare.evolving"}).status, 0);
  write_video(folder / "four.mp4", 4, {});
  for (const char* option : {"--video", "--from"})
    EXPECT_THAT(refusal(folder,
                        {"play", "bare.evolving", "-o", "page.html", option,
                         option == std::string("--from") ? "balls" : "four.mp4"},
                        "page.html"),
                testing::AllOf(HasSubstr("bare.evolving"), HasSubstr("unwrap")))
        << option;
}

TEST_F(Play, PutsEverythingIntoOneFile) {
  const Result result = marquetry(folder, {"play", "balls.evolving", "-o", "balls.html"});
  ASSERT_EQ(result.status, 0) << result.error;
  const std::string page = file_bytes(folder / "balls.html");
  EXPECT_THAT(page, testing::AllOf(Not(HasSubstr("<script src")), Not(HasSubstr("worker src"))));
  EXPECT_THAT(page, HasSubstr("\"video\":null"));
  EXPECT_THAT(page, HasSubstr("\"title\":\"balls\""));
}

TEST_F(Play, RefusesWhatItCannotShow) {
  write_bytes(folder / "film.avi", "RIFF");
  EXPECT_THAT(refusal(folder, {"play", "balls.evolving", "-o", "page", "--video", "film.avi"},
                      "page/index.html"),
              HasSubstr(".mp4"));
  EXPECT_THAT(refusal(folder, {"play", "balls.evolving", "-o", "page", "--video", "none.mp4"},
                      "page/index.html"),
              HasSubstr("none.mp4"));
  write_bytes(folder / "empty.mp4", "");
  EXPECT_THAT(refusal(folder, {"play", "balls.evolving", "-o", "page", "--video", "empty.mp4"},
                      "page/index.html"),
              HasSubstr("no MP4"));
  EXPECT_THAT(refusal(folder, {"play", "balls.evolving", "-o", "page", "--codec", "av1"},
                      "page/index.html"),
              HasSubstr("--codec"));
  EXPECT_THAT(refusal(folder, {"play", "balls/", "-o", "page"}, "page/index.html"),
              HasSubstr("balls"));
}

}  // namespace
}  // namespace mq::test

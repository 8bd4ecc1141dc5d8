#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "cli/browser.h"
#include "cli/program.h"
#include "cli/refusal.h"
#include "mq/io/image_file.h"

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

TEST_F(Play, PutsEverythingIntoOneFile) {
  const Result result = marquetry(folder, {"play", "balls.evolving", "-o", "balls.html"});
  ASSERT_EQ(result.status, 0) << result.error;
  const std::string page = file_bytes(folder / "balls.html");
  EXPECT_THAT(page, Not(HasSubstr("<script src")));
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

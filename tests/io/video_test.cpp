#include "mq/io/video.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <tuple>
#include <vector>

#include "io/folder.h"

namespace mq {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

class Video : public FolderTest {
 protected:
  void SetUp() override {
    if (std::system("ffmpeg -version > /dev/null 2>&1") != 0) GTEST_SKIP() << "ffmpeg is not here";
  }

  /// The bytes of all frames, red, green and blue.
  std::vector<std::uint8_t> frames(const std::string& name) const {
    const std::string raw = (folder / "raw.rgb").string();
    const std::string call = "ffmpeg -nostdin -loglevel error -y -i " + (folder / name).string() +
                             " -f rawvideo -pix_fmt rgb24 " + raw;
    EXPECT_EQ(std::system(call.c_str()), 0);
    const std::string text = get("raw.rgb");
    return {text.begin(), text.end()};
  }
};

/// A ramp that moves from frame to frame.
Image<float> ramp(int width, int height, int frame) {
  Image<float> picture(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      picture(x, y, 0) = float((x + frame) % width) / float(width);
      picture(x, y, 1) = float(y) / float(height);
      picture(x, y, 2) = 0.5F;
    }
  return picture;
}

TEST_F(Video, KeepsEightBitsInMatroska) {
  VideoWriter video(folder / "all bits.mkv", 33, 17);
  for (int f = 0; f < 3; ++f) video.write(ramp(33, 17, f));
  video.finish();
  std::filesystem::rename(folder / "all bits.mkv", folder / "v.mkv");
  const std::vector<std::uint8_t> bytes = frames("v.mkv");
  ASSERT_EQ(bytes.size(), 3U * 33 * 17 * 3);
  std::size_t at = 0;
  for (int f = 0; f < 3; ++f) {
    const Image<float> wanted = ramp(33, 17, f);
    for (const float v : wanted.values())
      ASSERT_EQ(bytes[at++], std::uint8_t(std::lround(v * 255)));
  }
}

TEST_F(Video, HoldsWhatTheCodecIsAskedFor) {
  for (const auto& [codec, file, name] : {std::tuple{VideoCodec::h265, "v.mp4", "hevc"},
                                          {VideoCodec::av1, "v.webm", "av1"},
                                          {VideoCodec::vp9, "v.mkv", "vp9"},
                                          {VideoCodec::automatic, "v.mov", "h264"}}) {
    VideoWriter video(folder / file, 64, 48, {.codec = codec});
    for (int f = 0; f < 3; ++f) video.write(ramp(64, 48, f));
    video.finish();
    const std::string call = "ffprobe -v error -show_entries stream=codec_name -of csv=p=0 " +
                             (folder / file).string() + " > " + (folder / "codec").string();
    ASSERT_EQ(std::system(call.c_str()), 0);
    EXPECT_THAT(get("codec"), HasSubstr(name));
    EXPECT_EQ(frames(file).size(), 3U * 64 * 48 * 3) << name;
  }
  EXPECT_THROW(VideoWriter(folder / "v.mp4", 64, 64, {.codec = VideoCodec::ffv1}), InvalidInput);
  EXPECT_THROW(video_codec("divx"), InvalidInput);
  EXPECT_EQ(video_codec("av1"), VideoCodec::av1);
}

TEST_F(Video, ShowsColoursAsTheyAre) {
  for (const std::string name : {"v.mp4", "v.webm"}) {
    VideoWriter video(folder / name, 64, 48, {.rate = 30});
    for (int f = 0; f < 4; ++f) {
      Image<float> flat(64, 48, 3);
      for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 64; ++x) {
          flat(x, y, 0) = 0.8F;
          flat(x, y, 1) = 0.4F;
          flat(x, y, 2) = 0.2F;
        }
      video.write(flat);
    }
    video.finish();
    const std::vector<std::uint8_t> bytes = frames(name);
    ASSERT_EQ(bytes.size(), 4U * 64 * 48 * 3) << name;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
      ASSERT_NEAR(bytes[i], 204, 3) << name;
      ASSERT_NEAR(bytes[i + 1], 102, 3) << name;
      ASSERT_NEAR(bytes[i + 2], 51, 3) << name;
    }
  }
}

TEST_F(Video, LosesTheLastRowAndColumnOfOddSidesOnly) {
  VideoWriter video(folder / "v.mp4", 33, 17);
  video.write(ramp(33, 17, 0));
  video.finish();
  EXPECT_EQ(frames("v.mp4").size(), 32U * 16 * 3);
  ASSERT_EQ(video.notes().size(), 1U);
  EXPECT_THAT(video.notes()[0], HasSubstr("33 x 17 pixels are cut to 32 x 16"));
  EXPECT_EQ(VideoWriter(folder / "v.mkv", 33, 17).notes().size(), 0U);
  EXPECT_EQ(VideoWriter(folder / "even.mp4", 32, 16).notes().size(), 0U);
}

TEST_F(Video, IsNotThereUntilItIsFinished) {
  {
    VideoWriter video(folder / "v.mp4", 64, 64);
    video.write(ramp(64, 64, 0));
    EXPECT_FALSE(there("v.mp4"));
  }
  EXPECT_EQ(files(), 0);
}

TEST_F(Video, SaysWhatIsWrong) {
  EXPECT_THROW(VideoWriter(folder / "v.avi", 64, 64), InvalidInput);
  EXPECT_THROW(VideoWriter(folder / "v.mp4", 0, 64), InvalidInput);
  EXPECT_THROW(VideoWriter(folder / "v.mp4", 64, 64, {.rate = NAN}), InvalidInput);
  EXPECT_THAT(io_error_of([&] { VideoWriter(folder / "no" / "ne" / "v.mp4", 64, 64); }),
              HasSubstr("make the folder around its folder first"));
  VideoWriter video(folder / "v.mp4", 64, 64);
  EXPECT_THROW(video.write(ramp(32, 64, 0)), InvalidInput);
}

TEST_F(Video, PassesOnWhatTheEncoderSays) {
  // A path without the program is one without videos.
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", folder.c_str(), 1);
  const std::string without = io_error_of([&] { VideoWriter(folder / "v.mp4", 64, 64); });
  EXPECT_EQ(io_error_of([&] { require_video_program(folder / "v.mp4"); }), without);
  // One that refuses everything is an encoder that fails.
  std::filesystem::create_symlink("/bin/sh", folder / "sh");
  put("ffmpeg", "#!/bin/sh\necho 'no room left' >&2\nexit 1\n");
  std::filesystem::permissions(folder / "ffmpeg", std::filesystem::perms::owner_all);
  EXPECT_NO_THROW(require_video_program(folder / "v.mp4"));
  const std::string failing = io_error_of([&] {
    VideoWriter video(folder / "v.mp4", 640, 480);
    for (int f = 0; f < 50; ++f) video.write(ramp(640, 480, f));
    video.finish();
  });
  ::setenv("PATH", path.c_str(), 1);
  EXPECT_THAT(without, HasSubstr("apt install ffmpeg"));
  EXPECT_THAT(failing, HasSubstr("ffmpeg says: no room left"));
  EXPECT_FALSE(there("v.mp4"));
}

TEST_F(Video, DoesNotWaitForAnEncoderThatHangs) {
  put("ffmpeg", "#!/bin/sh\nexec sleep 1000\n");
  std::filesystem::permissions(folder / "ffmpeg", std::filesystem::perms::owner_all);
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", (folder.string() + ":" + path).c_str(), 1);
  for (const bool is_sending : {true, false}) {
    std::atomic<bool> stop = false;
    std::thread person;
    const Progress progress([](const ProgressEvent&) {}, &stop);
    EXPECT_THROW(
        {
          VideoWriter video(folder / "v.mp4", 640, 480, {}, progress);
          person = std::thread([&] {
            std::this_thread::sleep_for(std::chrono::milliseconds(100));
            stop = true;
          });
          if (is_sending)
            for (;;) video.write(ramp(640, 480, 0));
          video.finish();
        },
        Cancelled);
    person.join();
  }
  ::setenv("PATH", path.c_str(), 1);
  EXPECT_FALSE(there("v.mp4"));
}

}  // namespace
}  // namespace mq

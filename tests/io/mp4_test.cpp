#include "mq/io/mp4.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/folder.h"

namespace mq {
namespace {

using ::testing::HasSubstr;

std::string number(std::uint64_t value, int size = 4) {
  std::string text;
  for (int i = size - 1; i >= 0; --i) text += i < 8 ? char(value >> (8 * i) & 0xff) : '\0';
  return text;
}
std::string box(const std::string& kind, const std::string& content) {
  return number(8 + content.size()) + kind + content;
}

/// A file of one track, whose parts a test may change.
struct Parts {
  std::string handler = "vide", codec = "avc1";
  std::uint64_t pictures = 30;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> runs = {{30, 512}};
  std::string edits = {}, more = {};

  std::string text() const {
    std::string times = number(0) + number(runs.size());
    for (const auto& [count, each] : runs) times += number(count) + number(each);
    const std::string table =
        box("stsd", number(0) + number(1) + box(codec, std::string(70, '\0'))) +
        box("stts", times) + box("stsz", number(0) + number(7) + number(pictures));
    const std::string media = box("mdhd", number(0, 12) + number(15360) + number(0, 8)) +
                              box("hdlr", number(0, 8) + handler + number(0, 12)) +
                              box("minf", box("stbl", table));
    return box("ftyp", "isom") +
           box("moov", box("mvhd", number(0, 12) + number(1000) + number(0, 8)) +
                           box("trak", edits + box("mdia", media)) + more) +
           box("mdat", std::string(210, 'x'));
  }
  Mp4Video read() const { return mp4_video(bytes_of(text()), "v.mp4"); }
};

std::string edit(std::uint64_t milliseconds, std::uint64_t from) {
  return box("edts", box("elst", number(0) + number(1) + number(milliseconds) + number(from) +
                                     number(0x10000)));
}

TEST(Mp4, SaysCodecPicturesAndRate) {
  const Mp4Video video = Parts{}.read();
  EXPECT_EQ(video.codec, "avc1");
  EXPECT_EQ(video.pictures, 30);
  EXPECT_EQ(video.rate, 30);
  // The last picture may last as long as it likes; so do milliseconds, which are rounded.
  EXPECT_EQ((Parts{.runs = {{29, 256}, {1, 0}}}.read().rate), 60);
  EXPECT_NEAR(*(Parts{.pictures = 4, .runs = {{2, 33}, {1, 34}, {1, 33}}}.read().rate),
              15360 / (100.0 / 3), 1e-9);
}

TEST(Mp4, SaysNoRateOfPicturesThatDoNotComeEvenly) {
  const Mp4Video video = Parts{.runs = {{15, 512}, {15, 1024}}}.read();
  EXPECT_EQ(video.pictures, 30);
  EXPECT_FALSE(video.rate);
}

TEST(Mp4, SaysNoPicturesWhereTheIndexAloneDoesNot) {
  EXPECT_EQ(Parts{.edits = edit(1000, 1024)}.read().pictures, 30);
  EXPECT_FALSE(Parts{.edits = edit(600, 6144)}.read().pictures);
  EXPECT_FALSE(Parts{.edits = edit(1000, 0xffffffff)}.read().pictures);
  EXPECT_FALSE(Parts{.more = box("mvex", "")}.read().pictures);
  EXPECT_FALSE(Parts{.pictures = 29}.read().pictures);
  EXPECT_EQ(Parts{.pictures = 29}.read().codec, "avc1");
}

std::string refused(const std::string& text) {
  return io_error_of([&] { mp4_video(bytes_of(text), "v.mp4"); });
}

TEST(Mp4, RefusesWhatIsNoVideo) {
  EXPECT_THAT(refused(""), HasSubstr("v.mp4: it is no MP4"));
  EXPECT_THAT(refused(std::string(100, 'x')), HasSubstr("no MP4"));
  EXPECT_THAT(refused(Parts{.handler = "soun"}.text()), HasSubstr("no video track"));
  EXPECT_THAT(refused(box("ftyp", "isom") + box("mdat", "x")), HasSubstr("no index"));
}

TEST(Mp4, ReadsOrRefusesWhateverWasCutOrChanged) {
  const std::string whole = Parts{.edits = edit(1000, 0)}.text();
  for (std::size_t size = 0; size < whole.size(); ++size)
    if (size != 12 && size != whole.size() - 218) {  // between boxes
      EXPECT_NE(refused(whole.substr(0, size)), "") << size;
    }
  for (std::size_t at = 0; at < whole.size() - 218; ++at)
    for (const int value : {0, 1, 0x7f, 0xff}) {
      std::string changed = whole;
      changed[at] = char(value);
      refused(changed);  // throws nothing else, reads nothing that is not there
    }
  EXPECT_THAT(refused(Parts{.runs = {}}.text() + number(4000) + "free"), HasSubstr("4000"));
}

TEST(Mp4, TakesTablesNoLargerThanTheirBox) {
  std::string text = Parts{}.text();
  const std::size_t at = text.find("stts") + 8;
  text.replace(at, 4, number(0xffffffff));
  EXPECT_THAT(refused(text), HasSubstr("cut short"));
}

}  // namespace
}  // namespace mq

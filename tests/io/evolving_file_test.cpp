#include "mq/io/evolving_file.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "io/evolving_strip.h"
#include "io/evolving_version_1.h"
#include "mq/base/error.h"
#include "mq/io/atomic_file.h"
#include "mq/io/detail/evolving_blocks.h"
#include "mq/io/detail/evolving_change.h"
#include "mq/io/detail/evolving_uvs.h"

namespace mq {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

void expect_equal(const EvolvingMesh& a, const EvolvingMesh& b) {
  ASSERT_EQ(a.segments.size(), b.segments.size());
  for (std::size_t s = 0; s < a.segments.size(); ++s) {
    EXPECT_EQ(a.segments[s].vertex_ids, b.segments[s].vertex_ids);
    EXPECT_EQ(a.segments[s].triangle_ids, b.segments[s].triangle_ids);
    EXPECT_EQ(a.segments[s].triangles, b.segments[s].triangles);
    EXPECT_EQ(a.segments[s].uvs, b.segments[s].uvs);
    EXPECT_EQ(a.segments[s].corner_uvs, b.segments[s].corner_uvs);
  }
  ASSERT_EQ(a.frames.size(), b.frames.size());
  for (std::size_t f = 0; f < a.frames.size(); ++f) {
    EXPECT_EQ(a.frames[f].number, b.frames[f].number);
    EXPECT_EQ(a.frames[f].segment, b.frames[f].segment);
    EXPECT_EQ(a.frames[f].positions, b.frames[f].positions);
  }
}

class EvolvingFile : public testing::Test {
 protected:
  void SetUp() override { fs::create_directories(folder_); }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path folder_ =
      fs::path(testing::TempDir()) / testing::UnitTest::GetInstance()->current_test_info()->name();
  fs::path manifest_ = folder_ / "strip.evolving";
  fs::path blocks_ = folder_ / "strip.blocks";
};

TEST_F(EvolvingFile, GivesBackWhatWasWritten) {
  const EvolvingMesh strip = stored_strip(20, 8);
  write_evolving(manifest_, strip, test_step);
  const EvolvingReader reader(manifest_);
  EXPECT_EQ(reader.broken(), "");
  expect_equal(reader.read(), strip);
}

TEST_F(EvolvingFile, ReadsFramesInAnyOrder) {
  const EvolvingMesh strip = stored_strip(20, 8);
  write_evolving(manifest_, strip, test_step);
  const EvolvingReader reader(manifest_);
  for (const int f : {7, 0, 5, 1}) EXPECT_EQ(reader.positions(f), strip.frames[f].positions);
}

TEST_F(EvolvingFile, BeginsAGroupInTimeAndReadsFramesOfGroupsInAnyOrder) {
  const int count = 2 * store_group_frames + 3;
  const EvolvingMesh strip = stored_strip(20, count);
  write_evolving(manifest_, strip, test_step);
  const EvolvingReader reader(manifest_);
  for (const int f : {count - 1, 0, store_group_frames, store_group_frames - 1, 5, count / 2, count / 2 - 1})
    EXPECT_EQ(reader.positions(f), strip.frames[f].positions) << f;
  EXPECT_EQ(reader.segment(1).triangle_ids, strip.segments[1].triangle_ids);
  EXPECT_EQ(reader.segment(0).triangle_ids, strip.segments[0].triangle_ids);
  const std::string text(text_of(read_file(manifest_)));
  EXPECT_THAT(text, HasSubstr("\"group\":2"));
  EXPECT_THAT(text, testing::Not(HasSubstr("\"group\":3")));
  // The last frame needs nothing before its group.
  Bytes bytes = read_file(blocks_);
  std::fill_n(bytes.begin(), reader.frames()[2 * store_group_frames - 1].offset, std::byte(0));
  write_file(blocks_, bytes);
  EXPECT_EQ(EvolvingReader(manifest_).positions(count - 1), strip.frames[std::size_t(count) - 1].positions);
}

TEST_F(EvolvingFile, HasGroupsAsLongAsIsAskedFor) {
  const EvolvingMesh strip = stored_strip(20, 10);
  write_evolving(manifest_, strip, test_step, "{}", {}, 0, 3);
  const EvolvingReader reader(manifest_);
  EXPECT_EQ(reader.group_frames(), 3);
  const std::string text(text_of(read_file(manifest_)));
  EXPECT_THAT(text, testing::AllOf(HasSubstr("\"group\":3"), testing::Not(HasSubstr("\"group\":4"))));
  expect_equal(reader.read(), strip);
  for (const int f : {9, 0, 4, 3, 8}) EXPECT_EQ(reader.positions(f), strip.frames[std::size_t(f)].positions);
  // And so it goes on.
  const Bytes blocks = read_file(blocks_);
  {
    EvolvingWriter writer(EvolvingReader(manifest_), 4);
    writer.add_frame(strip.frames[4].number, strip.frames[4].positions);
    writer.add_segment(strip.segments[1]);
    for (std::size_t f = 5; f < 10; ++f) writer.add_frame(strip.frames[f].number, strip.frames[f].positions);
  }
  EXPECT_EQ(read_file(blocks_), blocks);
  EXPECT_THROW(write_evolving(manifest_, strip, test_step, "{}", {}, 0, 0), InvalidInput);
}

TEST_F(EvolvingFile, OfOneFrameAGroupNeedsNoOther) {
  const EvolvingMesh strip = stored_strip(20, 4);
  write_evolving(manifest_, strip, test_step, "{}", {}, 0, 1);
  expect_equal(EvolvingReader(manifest_).read(), strip);
  Bytes bytes = read_file(blocks_);
  std::fill_n(bytes.begin(), EvolvingReader(manifest_).frames()[2].offset, std::byte(0));
  write_file(blocks_, bytes);
  EXPECT_EQ(EvolvingReader(manifest_).damaged(), (std::vector<int>{0, 1, 2}));
}

TEST_F(EvolvingFile, RoundsToHalfAStep) {
  const std::vector<Vector3> positions = {{1 / 3.0, -1 / 3.0, 1e-9}, {1000, -1e-3, 0}};
  const std::vector<Vector3> stored = rounded(positions, test_step);
  for (std::size_t v = 0; v < positions.size(); ++v)
    EXPECT_LE((positions[v] - stored[v]).cwiseAbs().maxCoeff(), test_step / 2);
  EXPECT_EQ(rounded(stored, test_step), stored);
  EXPECT_GE(store_step(1.8), 1.8e-6);
  EXPECT_LT(store_step(1.8), 3.6e-6);
}

TEST_F(EvolvingFile, TakesLessThanHalfOfFloats) {
  const EvolvingMesh strip = stored_strip(2000, 4);
  write_evolving(manifest_, strip, test_step);
  const EvolvingReader reader(manifest_);
  EXPECT_LT(reader.frames()[1].bytes, 4002 * 12 / 2);
}

TEST_F(EvolvingFile, IsOffByNoMoreThanIsAskedFor) {
  EvolvingMesh strip = stored_strip(50, 3);
  const Random random(7);
  std::uint64_t draw = 0;
  for (EvolvingFrame& frame : strip.frames)
    for (Vector3& p : frame.positions)
      for (double& x : p) x += random.uniform(draw++);
  for (const double error : {1e-6, 0.0123, 1.0, 77.0}) {
    const double step = step_within(error);
    EXPECT_GT(step * std::sqrt(3.0) / 2, error * 0.99);
    write_evolving(manifest_, strip, step);
    const EvolvingMesh found = EvolvingReader(manifest_).read();
    for (std::size_t f = 0; f < 3; ++f) {
      for (std::size_t v = 0; v < found.frames[f].positions.size(); ++v)
        EXPECT_LE((found.frames[f].positions[v] - strip.frames[f].positions[v]).norm(), error);
      EXPECT_EQ(found.frames[f].positions, rounded(strip.frames[f].positions, step));
    }
  }
  EXPECT_THROW(step_within(0), InvalidInput);
}

TEST_F(EvolvingFile, RoundsTextureCoordinatesWhereItIsAskedTo) {
  EvolvingMesh strip = stored_strip(50, 4);
  strip.segments[1].uvs = strip.segments[0].uvs;
  strip.segments[1].corner_uvs = strip.segments[0].corner_uvs;
  strip.segments[1].uvs.emplace_back(1 / 3.0, -1 / 7.0);
  write_evolving(manifest_, strip, test_step, "{}", {}, 0x1p-12);
  const EvolvingReader rounded_store(manifest_);
  EXPECT_EQ(rounded_store.uv_step(), 0x1p-12);
  for (int s = 0; s < 2; ++s) {
    const EvolvingSegment found = rounded_store.segment(s), &wanted = strip.segments[std::size_t(s)];
    EXPECT_EQ(found.corner_uvs, wanted.corner_uvs);
    EXPECT_EQ(found.uvs, rounded_uvs(wanted.uvs, 0x1p-12));
    for (std::size_t i = 0; i < wanted.uvs.size(); ++i)
      EXPECT_LE((found.uvs[i] - wanted.uvs[i]).cwiseAbs().maxCoeff(), 0x1p-13);
  }
  // To the bit without: doubles, and floats, and where they are too far for steps.
  write_evolving(manifest_, strip, test_step);
  expect_equal(EvolvingReader(manifest_).read(), strip);
  for (EvolvingSegment& segment : strip.segments)
    for (Vector2& uv : segment.uvs) uv = uv.cast<float>().cast<double>();
  write_evolving(manifest_, strip, test_step);
  expect_equal(EvolvingReader(manifest_).read(), strip);
  strip.segments[0].uvs[3] = {1e300, -1e300};
  write_evolving(manifest_, strip, test_step, "{}", {}, 0x1p-12);
  EXPECT_EQ(EvolvingReader(manifest_).segment(0).uvs, strip.segments[0].uvs);
  EXPECT_THROW(write_evolving(manifest_, strip, test_step, "{}", {}, 0.3), InvalidInput);
}

/// Triangles and vertices that go, come, change their order and their corners.
TEST_F(EvolvingFile, TellsSegmentsByWhatIsNewInThem) {
  EvolvingMesh strip = stored_strip(400, 6);
  EvolvingSegment& first = strip.segments[0];
  EvolvingSegment& second = strip.segments[1];
  second = first;
  second.vertex_ids[7] = 5000;
  second.vertex_ids.push_back(5001);
  std::rotate(second.triangles.begin(), second.triangles.begin() + 300, second.triangles.end());
  std::rotate(second.triangle_ids.begin(), second.triangle_ids.begin() + 300, second.triangle_ids.end());
  std::rotate(second.corner_uvs.begin(), second.corner_uvs.begin() + 300, second.corner_uvs.end());
  second.triangles[10] = {second.triangles[10][1], second.triangles[10][2], second.triangles[10][0]};
  second.triangles.push_back({0, 1, 802});
  second.triangle_ids.push_back(9000);
  second.uvs.emplace_back(0.123, 0.456);
  second.corner_uvs.push_back({-1, 3, 802});
  second.corner_uvs[20][1] = -1;
  for (std::size_t f = 3; f < 6; ++f) strip.frames[f].positions.emplace_back(1, 2, 3);
  write_evolving(manifest_, strip, test_step);
  const EvolvingReader reader(manifest_);
  expect_equal(reader.read(), strip);
  EXPECT_LT(reader.segments()[1].bytes, reader.segments()[0].bytes / 4);
}

TEST_F(EvolvingFile, OfVersion1IsRead) {
  const EvolvingMesh strip = stored_strip(20, 8);
  version_1::write_store(manifest_, strip, -20);
  const EvolvingReader reader(manifest_);
  EXPECT_EQ(reader.broken(), "");
  EXPECT_EQ(reader.step(), test_step);
  EXPECT_EQ(reader.about(), R"({"by":"version 1"})");
  EXPECT_TRUE(reader.damaged().empty());
  expect_equal(reader.read(), strip);
  for (const int f : {7, 0, 5, 1}) EXPECT_EQ(reader.positions(f), strip.frames[f].positions);
  Bytes bytes = read_file(blocks_);
  bytes[std::size_t(reader.frames()[2].offset)] ^= std::byte(1);
  write_file(blocks_, bytes);
  EXPECT_EQ(EvolvingReader(manifest_).damaged(), std::vector<int>{2});
  EXPECT_EQ(EvolvingReader(manifest_).positions(3), strip.frames[3].positions);
}

TEST_F(EvolvingFile, OfVersion1IsGoneOnWithInThatOfToday) {
  const EvolvingMesh strip = stored_strip(20, 8);
  version_1::write_store(manifest_, strip, -20);
  {
    EvolvingWriter writer(EvolvingReader(manifest_), 5);
    for (std::size_t f = 5; f < 8; ++f) writer.add_frame(strip.frames[f].number, strip.frames[f].positions);
  }
  const EvolvingReader reader(manifest_);
  expect_equal(reader.read(), strip);
  EXPECT_EQ(reader.about(), R"({"by":"version 1"})");
  EXPECT_EQ(reader.frames()[4].measured, fmt::format("{{\"seen\":{}}}", strip.frames[4].number));
  EXPECT_THAT(std::string(text_of(read_file(manifest_))), HasSubstr("\"version\":2"));
}

TEST_F(EvolvingFile, CutAnywhereGivesWhatIsBeforeTheCut) {
  const EvolvingMesh strip = stored_strip(6, 6);
  write_evolving(manifest_, strip, test_step);
  const Bytes sound = read_file(blocks_);
  const EvolvingReader whole(manifest_);
  for (std::size_t size = 0; size <= sound.size(); ++size) {
    write_file(blocks_, ByteView(sound).first(size));
    const EvolvingReader reader(manifest_);
    std::size_t frames = 0;
    for (const StoredFrame& frame : whole.frames())
      frames += frame.offset + frame.bytes <= std::int64_t(size);
    ASSERT_EQ(reader.frames().size(), frames) << size;
    EXPECT_EQ(reader.broken().empty(), size == sound.size());
    for (std::size_t f = 0; f < frames; ++f)
      ASSERT_EQ(reader.positions(int(f)), strip.frames[f].positions);
  }
}

TEST_F(EvolvingFile, WithAManifestCutAnywhereGivesWhatIsBeforeTheCut) {
  const EvolvingMesh strip = stored_strip(6, 6);
  write_evolving(manifest_, strip, test_step);
  const Bytes sound = read_file(manifest_);
  const std::string text(text_of(sound));
  const std::size_t first_line = text.find('\n') + 1;
  for (std::size_t size = 0; size < text.size(); ++size) {
    write_file(manifest_, ByteView(sound).first(size));
    if (size < first_line) {
      EXPECT_THROW(EvolvingReader{manifest_}, IoError);
      continue;
    }
    const EvolvingReader reader(manifest_);
    const auto lines = std::ranges::count(text.substr(0, size), '\n');
    ASSERT_EQ(1 + reader.segments().size() + reader.frames().size(), std::size_t(lines));
    EXPECT_EQ(reader.broken().empty(), text[size - 1] == '\n');
  }
}

TEST_F(EvolvingFile, SaysWhichBlockHasOtherBytes) {
  const EvolvingMesh strip = stored_strip(6, store_group_frames + 6);
  write_evolving(manifest_, strip, test_step);
  const EvolvingReader whole(manifest_);
  Bytes bytes = read_file(blocks_);
  bytes[std::size_t(whole.frames()[2].offset)] ^= std::byte(1);
  write_file(blocks_, bytes);
  const EvolvingReader reader(manifest_);
  EXPECT_EQ(reader.positions(1), strip.frames[1].positions);
  EXPECT_EQ(reader.positions(store_group_frames), strip.frames[store_group_frames].positions);
  std::vector<int> rest_of_group;
  for (int f = 2; f < store_group_frames; ++f) rest_of_group.push_back(f);
  EXPECT_EQ(reader.damaged(), rest_of_group);
  for (const int f : {2, 3}) {
    try {
      reader.positions(f);
      FAIL();
    } catch (const IoError& error) {
      EXPECT_THAT(error.what(), HasSubstr("frame 14"));
    }
  }
  EXPECT_EQ(reader.positions(0), strip.frames[0].positions);
}

TEST_F(EvolvingFile, WithNoiseInTheManifestIsRefusedOrCutShort) {
  const EvolvingMesh strip = stored_strip(6, 6);
  write_evolving(manifest_, strip, test_step);
  const Bytes sound = read_file(manifest_);
  const Random random(3);
  std::uint64_t draw = 0;
  for (int round = 0; round < 1500; ++round) {
    Bytes bytes = sound;
    for (int change = 0; change < 1 + round % 3; ++change) spoil(bytes, random, draw);
    write_file(manifest_, bytes);
    try {
      const EvolvingReader reader(manifest_);
      for (int f = 0; f < int(reader.frames().size()); ++f) (void)reader.positions(f);
    } catch (const IoError&) {
    } catch (const InvalidInput&) {
    }
  }
}

/// The manifest of a whole store with one of its numbers replaced.
std::string with_number(std::string_view text, std::size_t which, const std::string& value) {
  std::size_t at = 0, end = 0;
  for (std::size_t i = 0; i <= which; ++i) {
    at = text.find_first_of("-0123456789", end);
    if (at == text.npos) return {};
    end = text.find_first_not_of("-+.eE0123456789", at);
  }
  return std::string(text.substr(0, at)) + value + std::string(text.substr(end));
}

TEST_F(EvolvingFile, WithAnyNumberAbsurdIsRefusedOrCutShort) {
  const EvolvingMesh strip = stored_strip(6, 6);
  write_evolving(manifest_, strip, test_step);
  const Bytes sound = read_file(manifest_);
  const Random random(5);
  int tried = 0;
  for (std::size_t which = 0;; ++which) {
    if (with_number(text_of(sound), which, "0").empty()) break;
    const std::string random_value = std::to_string(int(1000 * random.uniform(which)));
    for (const char* value :
         {"4000000000", "-1", "NaN", "1e300", "99999999999999999999", "9223372036854775807", "0.5",
          "null", "\"7\"", random_value.c_str()}) {
      ++tried;
      const std::string text = with_number(text_of(sound), which, value);
      write_file(manifest_, bytes_of(text));
      try {
        const EvolvingReader reader(manifest_);
        std::int64_t counted = 0;
        for (const StoredSegment& segment : reader.segments()) {
          EXPECT_GE(std::min(segment.vertices, segment.triangles), 0) << value;
          counted += segment.vertices + segment.triangles;
        }
        EXPECT_LT(counted, 1000) << value;  // of a file of blocks of some hundred bytes
        (void)reader.damaged();
        for (int f = 0; f < int(reader.frames().size()); ++f) (void)reader.positions(f);
      } catch (const IoError&) {
      } catch (const InvalidInput&) {
      }
    }
  }
  EXPECT_GT(tried, 300);
}

TEST_F(EvolvingFile, SaysWhichCountIsAbsurd) {
  const EvolvingMesh strip = stored_strip(6, 6);
  write_evolving(manifest_, strip, test_step);
  std::string text(text_of(read_file(manifest_)));
  const std::string count = "\"vertices\":14";
  text.replace(text.find(count), count.size(), "\"vertices\":4000000000");
  write_file(manifest_, bytes_of(text));
  const EvolvingReader reader(manifest_);
  EXPECT_THAT(reader.broken(), HasSubstr("strip.evolving"));
  EXPECT_THAT(reader.broken(), HasSubstr("line 2 says 4000000000 vertices, wanted a number from"));
  EXPECT_TRUE(reader.frames().empty());
}

TEST_F(EvolvingFile, GoesOnAfterABreakAsIfThereHadBeenNone) {
  const EvolvingMesh strip = stored_strip(6, 6);
  write_evolving(manifest_, strip, test_step);
  const Bytes blocks = read_file(blocks_), lines = read_file(manifest_);
  const std::int64_t cut = EvolvingReader(manifest_).frames()[4].offset + 3;
  write_file(blocks_, ByteView(blocks).first(std::size_t(cut)));
  const EvolvingReader reader(manifest_);
  ASSERT_EQ(reader.frames().size(), 4U);
  {
    EvolvingWriter writer(reader, 4);
    for (int f = 4; f < 6; ++f) writer.add_frame(strip.frames[f].number, strip.frames[f].positions);
  }
  EXPECT_EQ(read_file(blocks_), blocks);
  EXPECT_EQ(read_file(manifest_), lines);
}

TEST_F(EvolvingFile, CanGoOnFromAnEarlierFrameOrFromNone) {
  const EvolvingMesh strip = stored_strip(6, 6);
  write_evolving(manifest_, strip, test_step);
  const Bytes blocks = read_file(blocks_);
  {
    EvolvingWriter writer(EvolvingReader(manifest_), 2);
    writer.add_frame(strip.frames[2].number, strip.frames[2].positions);
    writer.add_segment(strip.segments[1]);
    for (int f = 3; f < 6; ++f) writer.add_frame(strip.frames[f].number, strip.frames[f].positions);
  }
  EXPECT_EQ(read_file(blocks_), blocks);
  const EvolvingWriter writer(EvolvingReader(manifest_), 0);
  EXPECT_TRUE(EvolvingReader(manifest_).segments().empty());
  EXPECT_EQ(EvolvingReader(manifest_).broken(), "");
}

TEST_F(EvolvingFile, GoesOnWithinAGroupAndWhereOneEnds) {
  const int count = 2 * store_group_frames + 2;
  const EvolvingMesh strip = stored_strip(6, count);
  write_evolving(manifest_, strip, test_step);
  const Bytes blocks = read_file(blocks_), lines = read_file(manifest_);
  for (const int kept : {store_group_frames - 1, store_group_frames, store_group_frames + 1, count - 3, count - 1}) {
    {
      EvolvingWriter writer(EvolvingReader(manifest_), kept);
      int open = strip.frames[std::size_t(kept) - 1].segment;
      for (int f = kept; f < count; ++f) {
        const EvolvingFrame& frame = strip.frames[std::size_t(f)];
        if (frame.segment != open) writer.add_segment(strip.segments[std::size_t(open = frame.segment)]);
        writer.add_frame(frame.number, frame.positions);
      }
    }
    EXPECT_EQ(read_file(blocks_), blocks) << kept;
    EXPECT_EQ(read_file(manifest_), lines) << kept;
  }
}

TEST_F(EvolvingFile, StaysUntilTheNextHasAFrame) {
  const EvolvingMesh strip = stored_strip(2, 2);
  write_evolving(manifest_, strip, test_step);
  const Bytes lines = read_file(manifest_), blocks = read_file(blocks_);
  {
    EvolvingWriter writer(manifest_, test_step);
    writer.add_segment(strip.segments[0]);
    EXPECT_EQ(read_file(manifest_), lines);
  }
  EXPECT_EQ(read_file(manifest_), lines);
  EXPECT_EQ(read_file(blocks_), blocks);
  EvolvingWriter writer(manifest_, test_step);
  writer.add_segment(strip.segments[0]);
  writer.add_frame(7, strip.frames[0].positions);
  ASSERT_EQ(EvolvingReader(manifest_).frames().size(), 1U);
  writer.add_frame(8, strip.frames[1].positions);
  EXPECT_EQ(EvolvingReader(manifest_).read().frames[1].number, 8);
}

TEST_F(EvolvingFile, KeepsWhatItsMakerMeasured) {
  const EvolvingMesh strip = stored_strip(2, 2);
  EvolvingWriter writer(manifest_, test_step, R"({"by":"a test"})");
  writer.add_segment(strip.segments[0]);
  writer.add_frame(1, strip.frames[0].positions, R"({"distance_mean":0.5})");
  const EvolvingReader reader(manifest_);
  EXPECT_EQ(reader.about(), R"({"by":"a test"})");
  EXPECT_EQ(reader.frames()[0].measured, R"({"distance_mean":0.5})");
}

TEST_F(EvolvingFile, RefusesOtherFilesAndLaterVersions) {
  write_file(manifest_, bytes_of("{\"format\": 1}\n"));
  EXPECT_THROW(EvolvingReader{manifest_}, IoError);
  write_file(manifest_, bytes_of("{\"format\":\"marquetry evolving mesh\",\"version\":3}\n"));
  EXPECT_THROW(EvolvingReader{manifest_}, IoError);
  write_file(manifest_, bytes_of("{\"format\":\"marquetry evolving mesh\",\"version\":1,\"blocks\":"
                                 "\"../../etc/passwd\",\"step_exponent\":-20}\n"));
  EXPECT_THROW(EvolvingReader{manifest_}, IoError);
  EXPECT_THROW(EvolvingReader{folder_ / "none.evolving"}, IoError);
  EXPECT_THROW(EvolvingWriter(manifest_, 0.3), InvalidInput);
}

}  // namespace
}  // namespace mq

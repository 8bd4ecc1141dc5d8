#include "mq/io/evolving_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "mq/base/error.h"
#include "mq/base/random.h"
#include "mq/io/atomic_file.h"
#include "mq/io/detail/evolving_blocks.h"

namespace mq {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr double test_step = 0x1p-20;

/// A strip of n quads that waves over `count` frames; in the middle its last quad is made anew.
EvolvingMesh waving_strip(int n, int count) {
  Mesh mesh;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j < 2; ++j) {
      mesh.positions.emplace_back(i, j, 0);
      mesh.uvs.emplace_back(double(i) / n, j);
    }
  for (int i = 0; i < n; ++i) {
    mesh.triangles.push_back({2 * i, 2 * i + 2, 2 * i + 3});
    mesh.triangles.push_back({2 * i, 2 * i + 3, 2 * i + 1});
  }
  mesh.corner_uvs = mesh.triangles;
  EvolvingMesh evolving;
  evolving.segments = {segment_of(mesh), segment_of(mesh)};
  evolving.segments[1].triangle_ids[2 * n - 2] = 2 * n;
  evolving.segments[1].triangle_ids[2 * n - 1] = 2 * n + 1;
  evolving.segments[1].uvs.clear();
  evolving.segments[1].corner_uvs.clear();
  for (int f = 0; f < count; ++f) {
    EvolvingFrame frame{10 + 2 * f, f < count / 2 ? 0 : 1, mesh.positions};
    for (Vector3& p : frame.positions) p.z() = std::sin(p.x() + 0.3 * f);
    frame.positions = rounded(frame.positions, test_step);
    evolving.frames.push_back(std::move(frame));
  }
  return evolving;
}

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

/// Another value for one byte somewhere.
void spoil(Bytes& bytes, const Random& random, std::uint64_t& draw) {
  const double place = random.uniform(draw++), value = random.uniform(draw++);
  bytes[std::size_t(double(bytes.size()) * place)] = std::byte(int(256 * value));
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

TEST(EvolvingBlocks, HaveTheChecksumOfTheStandard) {
  EXPECT_EQ(crc32(bytes_of("123456789")), 0xCBF43926U);
}

TEST(EvolvingBlocks, OfASegmentRefuseRandomBytes) {
  const Random random(1);
  std::uint64_t draw = 0;
  int refused = 0;
  for (int round = 0; round < 2000; ++round) {
    Bytes bytes(std::size_t(64 * random.uniform(draw++)));
    for (std::byte& byte : bytes) byte = std::byte(int(256 * random.uniform(draw++)));
    try {
      check(decode_segment(bytes, "noise").segment);
    } catch (const IoError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 1900);
}

TEST(EvolvingBlocks, WithChangedBytesAreRefusedOrSayASegment) {
  const EvolvingMesh strip = waving_strip(5, 2);
  const Bytes sound =
      encode_segment(strip.segments[0], in_steps(strip.frames[0].positions, test_step));
  const Random random(2);
  std::uint64_t draw = 0;
  for (int round = 0; round < 3000; ++round) {
    Bytes bytes = sound;
    spoil(bytes, random, draw);
    try {
      check(decode_segment(bytes, "noise").segment);
    } catch (const IoError&) {
    }
  }
  for (std::size_t size = 0; size < sound.size(); ++size)
    EXPECT_THROW(decode_segment(ByteView(sound).first(size), "cut"), IoError);
}

TEST_F(EvolvingFile, GivesBackWhatWasWritten) {
  const EvolvingMesh strip = waving_strip(20, 8);
  write_evolving(manifest_, strip, test_step);
  const EvolvingReader reader(manifest_);
  EXPECT_EQ(reader.broken(), "");
  expect_equal(reader.read(), strip);
}

TEST_F(EvolvingFile, ReadsFramesInAnyOrder) {
  const EvolvingMesh strip = waving_strip(20, 8);
  write_evolving(manifest_, strip, test_step);
  const EvolvingReader reader(manifest_);
  for (const int f : {7, 0, 5, 1}) EXPECT_EQ(reader.positions(f), strip.frames[f].positions);
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
  const EvolvingMesh strip = waving_strip(2000, 4);
  write_evolving(manifest_, strip, test_step);
  const EvolvingReader reader(manifest_);
  EXPECT_LT(reader.frames()[1].bytes, 4002 * 12 / 2);
}

TEST_F(EvolvingFile, CutAnywhereGivesWhatIsBeforeTheCut) {
  const EvolvingMesh strip = waving_strip(6, 6);
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
  const EvolvingMesh strip = waving_strip(6, 6);
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
  const EvolvingMesh strip = waving_strip(6, 6);
  write_evolving(manifest_, strip, test_step);
  const EvolvingReader whole(manifest_);
  Bytes bytes = read_file(blocks_);
  bytes[std::size_t(whole.frames()[2].offset)] ^= std::byte(1);
  write_file(blocks_, bytes);
  const EvolvingReader reader(manifest_);
  EXPECT_EQ(reader.positions(1), strip.frames[1].positions);
  EXPECT_EQ(reader.positions(3), strip.frames[3].positions);
  try {
    reader.positions(2);
    FAIL();
  } catch (const IoError& error) {
    EXPECT_THAT(error.what(), HasSubstr("frame 14"));
  }
}

TEST_F(EvolvingFile, WithNoiseInTheManifestIsRefusedOrCutShort) {
  const EvolvingMesh strip = waving_strip(6, 6);
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
  const EvolvingMesh strip = waving_strip(6, 6);
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
  const EvolvingMesh strip = waving_strip(6, 6);
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
  const EvolvingMesh strip = waving_strip(6, 6);
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
  const EvolvingMesh strip = waving_strip(6, 6);
  write_evolving(manifest_, strip, test_step);
  const Bytes blocks = read_file(blocks_);
  {
    EvolvingWriter writer(EvolvingReader(manifest_), 2);
    writer.add_frame(strip.frames[2].number, strip.frames[2].positions);
    writer.add_segment(strip.segments[1], strip.frames[3].positions);
    for (int f = 3; f < 6; ++f) writer.add_frame(strip.frames[f].number, strip.frames[f].positions);
  }
  EXPECT_EQ(read_file(blocks_), blocks);
  const EvolvingWriter writer(EvolvingReader(manifest_), 0);
  EXPECT_TRUE(EvolvingReader(manifest_).segments().empty());
  EXPECT_EQ(EvolvingReader(manifest_).broken(), "");
}

TEST_F(EvolvingFile, StaysUntilTheNextHasAFrame) {
  const EvolvingMesh strip = waving_strip(2, 2);
  write_evolving(manifest_, strip, test_step);
  const Bytes lines = read_file(manifest_), blocks = read_file(blocks_);
  {
    EvolvingWriter writer(manifest_, test_step);
    writer.add_segment(strip.segments[0], strip.frames[0].positions);
    EXPECT_EQ(read_file(manifest_), lines);
  }
  EXPECT_EQ(read_file(manifest_), lines);
  EXPECT_EQ(read_file(blocks_), blocks);
  EvolvingWriter writer(manifest_, test_step);
  writer.add_segment(strip.segments[0], strip.frames[0].positions);
  writer.add_frame(7, strip.frames[0].positions);
  ASSERT_EQ(EvolvingReader(manifest_).frames().size(), 1U);
  writer.add_frame(8, strip.frames[1].positions);
  EXPECT_EQ(EvolvingReader(manifest_).read().frames[1].number, 8);
}

TEST_F(EvolvingFile, KeepsWhatItsMakerMeasured) {
  const EvolvingMesh strip = waving_strip(2, 2);
  EvolvingWriter writer(manifest_, test_step, R"({"by":"a test"})");
  writer.add_segment(strip.segments[0], strip.frames[0].positions);
  writer.add_frame(1, strip.frames[0].positions, R"({"distance_mean":0.5})");
  const EvolvingReader reader(manifest_);
  EXPECT_EQ(reader.about(), R"({"by":"a test"})");
  EXPECT_EQ(reader.frames()[0].measured, R"({"distance_mean":0.5})");
}

TEST_F(EvolvingFile, RefusesOtherFilesAndLaterVersions) {
  write_file(manifest_, bytes_of("{\"format\": 1}\n"));
  EXPECT_THROW(EvolvingReader{manifest_}, IoError);
  write_file(manifest_, bytes_of("{\"format\":\"marquetry evolving mesh\",\"version\":2}\n"));
  EXPECT_THROW(EvolvingReader{manifest_}, IoError);
  write_file(manifest_, bytes_of("{\"format\":\"marquetry evolving mesh\",\"version\":1,\"blocks\":"
                                 "\"../../etc/passwd\",\"step_exponent\":-20}\n"));
  EXPECT_THROW(EvolvingReader{manifest_}, IoError);
  EXPECT_THROW(EvolvingReader{folder_ / "none.evolving"}, IoError);
  EXPECT_THROW(EvolvingWriter(manifest_, 0.3), InvalidInput);
}

}  // namespace
}  // namespace mq

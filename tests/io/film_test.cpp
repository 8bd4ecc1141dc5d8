#include "mq/io/film.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "io/evolving_strip.h"
#include "io/folder.h"
#include "mq/base/error.h"

namespace mq {
namespace {

class FilmTest : public FolderTest {};

/// A block as the page takes it apart.
class Block {
 public:
  explicit Block(const Bytes& packed) : bytes_(1 << 20) {
    uLongf size = bytes_.size();
    EXPECT_EQ(uncompress(bytes_.data(), &size, reinterpret_cast<const Bytef*>(packed.data()),
                         packed.size()),
              Z_OK);
    bytes_.resize(size);
  }

  template <typename T>
  std::vector<T> take(std::size_t count) {
    std::vector<T> values(count);
    if (at_ + count * sizeof(T) > bytes_.size()) {
      ADD_FAILURE() << "the block ends early";
      return values;
    }
    std::memcpy(values.data(), bytes_.data() + at_, count * sizeof(T));
    at_ += count * sizeof(T);
    return values;
  }

  bool at_end() const { return at_ == bytes_.size(); }

 private:
  std::vector<unsigned char> bytes_;
  std::size_t at_ = 0;
};

constexpr int quads = 5, frame_count = 6;

std::array<float, 3> share_of_life(int first, int last, int count) {
  return {float(last - first + 1) / float(count), 0, 1};
}

TEST_F(FilmTest, HoldsFramesToAStepOfTheBox) {
  const EvolvingMesh evolving = waving_strip(quads, frame_count);
  write_evolving(folder / "strip.evolving", evolving, 0x1p-30);
  const EvolvingReader reader(folder / "strip.evolving");
  const Film film = make_film(reader, {0, 1, 2, 3, 4, 5}, share_of_life);
  const auto description = nlohmann::json::parse(film.description);
  EXPECT_EQ(description["frames"], (std::vector<int>{10, 12, 14, 16, 18, 20}));
  ASSERT_EQ(film.blocks.size(), 2U);
  for (int s = 0; s < 2; ++s) {
    const EvolvingSegment& segment = evolving.segments[s];
    const auto counts = description["segments"][s];
    EXPECT_EQ(counts["first"], 3 * s);
    EXPECT_EQ(counts["frames"], 3);
    Block block(film.blocks[s]);
    const std::size_t points = counts["points"];
    EXPECT_EQ(points, 2U * (quads + 1) + 2);  // two are in both charts
    const auto vertex_of = block.take<std::uint32_t>(points);
    const auto uvs = block.take<float>(2 * points);
    const auto colours = block.take<std::uint8_t>(3 * points);
    const auto corners = block.take<std::uint32_t>(6 * quads);
    for (int t = 0; t < segment.triangle_count(); ++t)
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t point = corners[3 * t + k];
        ASSERT_EQ(int(vertex_of[point]), segment.triangles[t][k]);
        const Vector2& uv = segment.uvs[segment.corner_uvs[t][k]];
        EXPECT_EQ(uvs[2 * point], float(uv.x()));
        EXPECT_EQ(uvs[2 * point + 1], float(uv.y()));
        const bool is_last_quad = t >= 2 * quads - 2;
        EXPECT_EQ(int(colours[3 * point]), is_last_quad ? 128 : 255);
      }
    // The outline, and the line between what lives throughout and what does not.
    EXPECT_EQ(counts["edges"], 2 * quads + 3);
    block.take<std::uint32_t>(2 * counts["edges"].get<std::size_t>());
    std::vector<std::uint16_t> value(3 * segment.vertex_count());
    for (int f = 0; f < 3; ++f) {
      const auto low = block.take<std::uint8_t>(value.size());
      const auto high = block.take<std::uint8_t>(value.size());
      for (std::size_t i = 0; i < value.size(); ++i) {
        const int folded = low[i] | high[i] << 8;
        value[i] = std::uint16_t(value[i] + ((folded >> 1) ^ -(folded & 1)));
        const int k = int(i) / segment.vertex_count(), v = int(i) % segment.vertex_count();
        const double from = description["low"][k], to = description["high"][k];
        const double step = (to - from) / 65535;
        EXPECT_NEAR(from + value[i] * step, evolving.frames[3 * s + f].positions[v][k],
                    0.51 * step);
      }
    }
    EXPECT_TRUE(block.at_end());
  }
}

TEST_F(FilmTest, HasOnlyTheSegmentsOfItsFrames) {
  write_evolving(folder / "strip.evolving", waving_strip(quads, frame_count), 0x1p-30);
  const EvolvingReader reader(folder / "strip.evolving");
  const Film film = make_film(reader, {4}, share_of_life);
  EXPECT_EQ(film.blocks.size(), 1U);
  const auto description = nlohmann::json::parse(film.description);
  EXPECT_EQ(description["frames"], std::vector<int>{18});
  EXPECT_EQ(description["segments"][0]["first"], 0);
  EXPECT_THROW(make_film(reader, {}, share_of_life), InvalidInput);
}

TEST(CoordinateLifespans, EndWhereTextureCoordinatesChange) {
  EvolvingMesh evolving = waving_strip(quads, frame_count);
  evolving.segments[1].uvs[0].x() += 0x1p-40;  // of the first two triangles
  const auto lives = coordinate_lifespans(evolving);
  ASSERT_EQ(lives.size(), 2U);
  for (int s = 0; s < 2; ++s)
    for (int t = 0; t < 2 * quads; ++t) {
      const bool stays = t >= 2 && t < 2 * quads - 2;
      EXPECT_EQ(lives[s][t].first, stays || s == 0 ? 0 : 3) << t;
      EXPECT_EQ(lives[s][t].last, stays || s == 1 ? 5 : 2) << t;
      EXPECT_EQ(lives[s][t].id, evolving.segments[s].triangle_ids[t]);
    }
}

}  // namespace
}  // namespace mq

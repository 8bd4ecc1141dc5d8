#include "mq/io/film.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "io/evolving_strip.h"
#include "io/folder.h"
#include "mq/base/error.h"

namespace mq {
namespace {

constexpr int quads = 5, frame_count = 6;

class FilmTest : public FolderTest {
 protected:
  FilmTest() { write_evolving(folder / "strip.evolving", evolving, 0x1p-30); }

  /// The store that a film has.
  EvolvingReader store_of(const Film& film) const {
    Bytes blocks;
    for (const Bytes& group : film.blocks) blocks.insert(blocks.end(), group.begin(), group.end());
    write_file(folder / "film.blocks", blocks);
    write_file(folder / "film.evolving", bytes_of(film.manifest));
    return EvolvingReader(folder / "film.evolving");
  }

  EvolvingMesh evolving = waving_strip(quads, frame_count);
};

std::array<float, 3> share_of_life(int first, int last, int count) {
  return {float(last - first + 1) / float(count), 0, 1};
}

/// Numbers as the page takes them from `lives`.
std::vector<int> numbers_of(const Bytes& bytes) {
  std::vector<int> numbers;
  int value = 0, shift = 0;
  for (const std::byte byte : bytes) {
    value |= (std::to_integer<int>(byte) & 127) << shift;
    shift += 7;
    if (std::to_integer<int>(byte) >= 128) continue;
    numbers.push_back(std::exchange(value, 0));
    shift = 0;
  }
  return numbers;
}

TEST_F(FilmTest, IsAStoreOfItsFrames) {
  const EvolvingReader reader(folder / "strip.evolving");
  const Film film = make_film(reader, {0, 1, 2, 3, 4, 5}, share_of_life);
  const auto description = nlohmann::json::parse(film.description);
  EXPECT_EQ(description["frames"], (std::vector<int>{10, 12, 14, 16, 18, 20}));
  ASSERT_EQ(film.blocks.size(), 1U);
  const EvolvingReader store = store_of(film);
  EXPECT_EQ(store.broken(), "");
  const EvolvingMesh found = store.read();
  ASSERT_EQ(found.segments.size(), 2U);
  for (std::size_t s = 0; s < 2; ++s) {
    const EvolvingSegment &segment = found.segments[s], &wanted = evolving.segments[s];
    EXPECT_EQ(segment.triangles, wanted.triangles);
    EXPECT_EQ(segment.triangle_ids, wanted.triangle_ids);
    EXPECT_EQ(segment.corner_uvs, wanted.corner_uvs);
    for (std::size_t i = 0; i < wanted.uvs.size(); ++i)
      EXPECT_LE((segment.uvs[i] - wanted.uvs[i]).cwiseAbs().maxCoeff(), 0x1p-20);
    EXPECT_EQ(description["segments"][s]["first"], 3 * s);
    EXPECT_EQ(description["segments"][s]["frames"], 3);
    EXPECT_EQ(description["segments"][s]["triangles"], 2 * quads);
  }
  const double most = quads / 65536.0;  // of the largest extent
  for (std::size_t f = 0; f < frame_count; ++f) {
    EXPECT_EQ(found.frames[f].number, evolving.frames[f].number);
    for (std::size_t v = 0; v < found.frames[f].positions.size(); ++v)
      EXPECT_LE((found.frames[f].positions[v] - evolving.frames[f].positions[v]).norm(), most);
  }
}

TEST_F(FilmTest, SaysHowLongTrianglesLive) {
  const Film film = make_film(EvolvingReader(folder / "strip.evolving"), {0, 1, 2, 3, 4, 5}, share_of_life);
  // Three colours; all but the last quad of ten triangles have the first.
  EXPECT_EQ(numbers_of(film.lives), (std::vector<int>{3, 255, 0, 255, 128, 0, 255, 128, 0, 255,  //
                                                      8, 0, 2, 1, 8, 0, 2, 2}));
}

TEST_F(FilmTest, IsOffByNoMoreThanIsAskedFor) {
  const EvolvingReader reader(folder / "strip.evolving");
  const auto description = nlohmann::json::parse(make_film(reader, {0, 5}, share_of_life).description);
  double squares = 0;
  for (std::size_t k = 0; k < 3; ++k)
    squares += std::pow(description["high"][k].get<double>() - description["low"][k].get<double>(), 2);
  for (const double error : {1e-6, 1e-3, 0.1}) {
    const EvolvingReader store = store_of(make_film(reader, {0, 5}, share_of_life, {.error = error}));
    for (int f = 0; f < 2; ++f) {
      const std::vector<Vector3> found = store.positions(f), &wanted = evolving.frames[f == 0 ? 0 : 5].positions;
      for (std::size_t v = 0; v < found.size(); ++v)
        EXPECT_LE((found[v] - wanted[v]).norm(), error * std::sqrt(squares)) << error;
    }
  }
}

TEST_F(FilmTest, KeepsPlacesThatTheStoreRounded) {
  write_evolving(folder / "coarse.evolving", evolving, 0x1p-4, "{}", {}, 0x1p-6);
  const EvolvingReader reader(folder / "coarse.evolving");
  const EvolvingReader store = store_of(make_film(reader, {0, 1, 2, 3, 4, 5}, share_of_life));
  for (int f = 0; f < frame_count; ++f) EXPECT_EQ(store.positions(f), reader.positions(f));
  EXPECT_EQ(store.segment(0).uvs, reader.segment(0).uvs);
}

TEST_F(FilmTest, TakesShapesFarFromTheOriginAsFloatsDo) {
  for (EvolvingFrame& frame : evolving.frames)
    for (Vector3& p : frame.positions) p.x() += 1e15;
  for (EvolvingSegment& segment : evolving.segments)
    for (Vector2& uv : segment.uvs) uv *= 1e12;
  write_evolving(folder / "far.evolving", evolving, 1);
  const EvolvingReader store = store_of(make_film(EvolvingReader(folder / "far.evolving"), {0, 5}, share_of_life));
  EXPECT_NEAR(store.positions(0)[0].x(), 1e15, 1e15 / 0x1p23);
  EXPECT_LE(1e15 / store.step(), 0x1p25);  // whole numbers that a browser computes with
  EXPECT_LE(1e12 / store.uv_step(), 0x1p25);
}

TEST_F(FilmTest, HasOnlyTheSegmentsOfItsFrames) {
  const EvolvingReader reader(folder / "strip.evolving");
  const Film film = make_film(reader, {4}, share_of_life);
  EXPECT_EQ(film.blocks.size(), 1U);
  const auto description = nlohmann::json::parse(film.description);
  EXPECT_EQ(description["frames"], std::vector<int>{18});
  EXPECT_EQ(description["segments"].size(), 1U);
  EXPECT_EQ(description["segments"][0]["first"], 0);
  EXPECT_EQ(store_of(film).segment(0).triangle_ids, evolving.segments[1].triangle_ids);
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

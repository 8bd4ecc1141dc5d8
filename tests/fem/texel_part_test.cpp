// A part of a texel space has the rows of the whole.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <tuple>

#include "fixtures.h"
#include "mq/fem/texel_part.h"
#include "mq/sample/sample.h"
#include "mq/sample/wall.h"

namespace mq {
namespace {

using Key = std::tuple<int, int, int>;

Key key_of(const Texels::Place& at) { return {at.texture, at.y, at.x}; }

struct Parted {
  int own = 0;            ///< texels that belong to a part, of all parts
  double difference = 0;  ///< largest of an entry, relative to the diagonal
  double of_right_side = 0;
  int largest_space = 0;
};

/// All parts of a space, compared with it row by row.
Parted compared(const Surface& surface, const Atlas& atlas, int parts, int side) {
  const TexelSpace whole(surface, atlas);
  std::map<Key, int> number;
  for (int i = 0; i < whole.size(); ++i) number[key_of(whole.texels().places[std::size_t(i)])] = i;
  const double weight = 1e-3 * atlas.surface_area;
  const SparseMatrix A = whole.regularised_system(1, weight);
  Signal psi(whole.size(), 2);
  for (int i = 0; i < whole.size(); ++i) psi.row(i) << std::sin(0.1 * i), i % 7;
  const Signal S_psi = whole.stiffness_times(psi);

  const Seams seams(surface, atlas);
  const TexelBlocks blocks(surface, atlas, seams, side);
  const BlockOwners owners{blocks, parted(blocks, parts)};
  Parted result;
  for (int p = 0; p < parts; ++p) {
    const TexelPart part(surface, atlas, seams, owners, p);
    if (part.empty()) continue;
    const SparseMatrix B = part.space().regularised_system(1, weight);
    Signal values(part.space().size(), 2);
    for (int i = 0; i < part.space().size(); ++i)
      values.row(i) = psi.row(number.at(key_of(part.places()[std::size_t(i)])));
    const Signal moments = part.space().stiffness_rows(part.own(), values);
    result.largest_space = std::max(result.largest_space, part.space().size());
    for (std::size_t n = 0; n < part.own().size(); ++n) {
      const int i = part.own()[n], row = number.at(key_of(part.places()[std::size_t(i)]));
      ++result.own;
      std::map<int, double> entries;
      for (SparseMatrix::InnerIterator at(B, i); at; ++at)
        entries[number.at(key_of(part.places()[std::size_t(at.col())]))] = at.value();
      const double diagonal = A.coeff(row, row);
      int count = 0;
      for (SparseMatrix::InnerIterator at(A, row); at; ++at, ++count) {
        const auto found = entries.find(int(at.col()));
        EXPECT_NE(found, entries.end()) << "row " << row << ", column " << at.col();
        if (found == entries.end()) continue;
        result.difference = std::max(result.difference, std::abs(found->second - at.value()) / diagonal);
      }
      EXPECT_EQ(count, int(entries.size())) << "row " << row;
      result.of_right_side =
          std::max(result.of_right_side, (moments.row(Eigen::Index(n)) - S_psi.row(row)).cwiseAbs().maxCoeff());
    }
  }
  EXPECT_EQ(result.own, whole.size());
  return result;
}

Parted compared_sample(const std::string& name, int size, int parts, int side) {
  const Sample sample = make_sample(name, {.texture_size = size, .triangles = 3000});
  const Surface surface = make_surface(sample.mesh);
  const Atlas atlas = make_atlas(surface, {sample.texture});
  return compared(surface, atlas, parts, side);
}

TEST(TexelPart, HasTheRowsOfTheWhole) {
  for (const auto& [name, size, parts, side] :
       {std::tuple("bust", 160, 4, 16), {"genus4", 96, 3, 32}, {"torus", 96, 5, 8}, {"cube", 64, 7, 8}}) {
    const Parted found = compared_sample(name, size, parts, side);
    EXPECT_LT(found.difference, 1e-9) << name;
    EXPECT_LT(found.of_right_side, 1e-9) << name;
  }
}

TEST(TexelPart, HasTheRowsOfTheWholeWhereTexturesRepeat) {
  Mesh mesh = fixtures::flat_square(6, 0.2);
  for (Vector2& uv : mesh.uvs) uv = 1.3 * uv + Vector2(0.4, -0.2);
  const Surface surface = make_surface(mesh);
  const Atlas atlas = make_atlas(surface, {{48, 40, Wrap::repeat}});
  const Parted found = compared(surface, atlas, 3, 8);
  EXPECT_LT(found.difference, 1e-9);
  EXPECT_LT(found.of_right_side, 1e-9);
}

/// A wall: tiles are handed out whole, and only rims of the others are looked at.
TEST(TexelPart, HasLittleBesideItsOwnTiles) {
  const Wall wall = make_wall({.tiles = 3, .texture_size = 64, .squares = 1});
  const Surface surface = make_surface(wall.mesh);
  const Atlas atlas = make_atlas(surface, wall.textures);
  const Parted found = compared(surface, atlas, 9, 16);
  EXPECT_LT(found.difference, 1e-9);
  EXPECT_LT(found.of_right_side, 1e-9);
  EXPECT_LT(found.largest_space, 1.6 * found.own / 9);
}

TEST(TexelPart, OfOnePartIsTheWhole) {
  const Parted found = compared_sample("sphere", 96, 1, 16);
  EXPECT_LT(found.difference, 1e-12);
  EXPECT_EQ(found.own, found.largest_space);
}

}  // namespace
}  // namespace mq

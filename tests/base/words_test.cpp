#include "mq/base/words.h"

#include <gtest/gtest.h>

namespace mq {
namespace {

TEST(Words, CountThings) {
  EXPECT_EQ(counted(1, "triangle"), "1 triangle");
  EXPECT_EQ(counted(0, "triangle"), "0 triangles");
  EXPECT_EQ(counted(2, "vertex"), "2 vertices");
  EXPECT_EQ(counted(3, "index"), "3 indices");
  EXPECT_EQ(counted(2, "half-edge"), "2 half-edges");
  EXPECT_EQ(counted(2, "matrix"), "2 matrices");
  EXPECT_EQ(counted(2, "patch"), "2 patches");
  EXPECT_EQ(counted(2, "body"), "2 bodies");
  EXPECT_EQ(counted(2, "ray"), "2 rays");
  EXPECT_EQ(counted(2, "texture coordinate"), "2 texture coordinates");
}

TEST(Words, SayWhichElementsADefectHas) {
  Defect defect{"kind", Defect::Severity::warning, "edge", 1, {7}, "they are odd"};
  EXPECT_EQ(sentence(defect), "they are odd (1 of them: id 7)");
  defect.count = 9;
  defect.ids = {7, 8, 9, 10, 11, 12, 13, 14, 15};
  EXPECT_EQ(sentence(defect), "they are odd (9 of them: ids 7, 8, 9, 10, 11, ...)");
  defect.ids.clear();
  EXPECT_EQ(sentence(defect), "they are odd (9 of them)");
}

TEST(Words, SayWhereTexelsAre) {
  Defect defect{"kind", Defect::Severity::warning, "texel", 9, {7}, "they are odd", "odd: left so"};
  EXPECT_EQ(short_sentence(defect), "9 texels odd: left so");
  defect.places = {{0, 3, 5, 9}};
  defect.place_count = 1;
  EXPECT_EQ(sentence(defect), "they are odd (9 of them, in 1 place, at column 3, row 5)");
  defect.places = {{1, 3, 5, 4}, {0, 70, 2, 3}, {0, 1, 1, 1}, {0, 8, 8, 1}};
  defect.place_count = 4;
  const std::vector<std::string> names = {"a.png", "b.png"};
  EXPECT_EQ(places_text(defect.places, 4, names, 2),
            "in 4 places; the largest: 4 at column 3, row 5 of b.png; 3 at column 70, row 2 of a.png");
  EXPECT_EQ(places_text(defect.places, 4, {}, 1), "in 4 places; the largest: 4 at column 3, row 5 of texture 1");
  EXPECT_EQ(places_text({}, 0), "");
  defect.brief.clear();
  EXPECT_EQ(short_sentence(defect), sentence(defect));
}

}  // namespace
}  // namespace mq

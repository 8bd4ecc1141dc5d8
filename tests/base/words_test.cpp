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

}  // namespace
}  // namespace mq

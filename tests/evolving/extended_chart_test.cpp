#include "mq/evolving/detail/extended_chart.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "fixtures.h"

namespace mq {
namespace {

/// A flat square in space, whose vertices for which `is_fixed` lie where `map` says.
template <class Fixed, class Map>
HolePatch open_patch(const Fixed& is_fixed, const Map& map) {
  const Mesh mesh = fixtures::flat_square(6, 0.3);
  HolePatch patch{mesh.triangles, {}, {}, {}};
  for (const Vector3& p : mesh.positions) {
    patch.positions.emplace_back(p.x(), 0.6 * p.y(), 0.8 * p.y());  // turned about the x axis
    patch.fixed.push_back(is_fixed(p));
    patch.places.push_back(is_fixed(p) ? map(p) : Vector2(7, -3));
  }
  return patch;
}

TEST(ExtendedChart, IsAsInSpaceBesideWhatIsFixed) {
  const auto map = [](const Vector3& p) {
    const double c = std::cos(0.7), s = std::sin(0.7);
    return Vector2(3 + c * p.x() - s * p.y(), 5 + s * p.x() + c * p.y());
  };
  const Mesh mesh = fixtures::flat_square(6, 0.3);
  const auto left = [](const Vector3& p) { return p.x() < 0.01; };
  const auto found = extended_chart(open_patch(left, map));
  ASSERT_TRUE(found);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    EXPECT_LT((found->places[v] - map(mesh.positions[v])).norm(), 1e-6) << v;
  for (const char sound : found->sound) EXPECT_TRUE(sound);
}

TEST(ExtendedChart, SaysWhatIsTurnedOverOrDistorted) {
  const auto sides = [](const Vector3& p) { return p.x() < 0.01 || p.x() > 0.99; };
  const auto at = [&](double width) {
    const auto found = extended_chart(open_patch(sides, [&](const Vector3& p) { return Vector2(width * p.x(), p.y()); }));
    EXPECT_TRUE(found);
    return std::ranges::count(found->sound, char(1));
  };
  const auto all = std::ssize(fixtures::flat_square(6, 0.3).triangles);
  EXPECT_EQ(at(1.5), all);
  EXPECT_LT(at(4), all);   // four times as wide
  EXPECT_LT(at(-1), all);  // the sides have changed places
}

TEST(ExtendedChart, NeedsTwoVerticesThatAreFixed) {
  const auto map = [](const Vector3& p) { return Vector2(p.x(), p.y()); };
  HolePatch patch = open_patch([](const Vector3&) { return false; }, map);
  EXPECT_FALSE(extended_chart(patch));
  patch.fixed[0] = 1;
  EXPECT_FALSE(extended_chart(patch));
}

}  // namespace
}  // namespace mq

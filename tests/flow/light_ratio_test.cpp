// Two pictures in another light: its ratio, and motions that are found all the same.
#include "mq/flow/light_ratio.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "flow/waves.h"
#include "mq/base/error.h"
#include "mq/flow/image_flow.h"

namespace mq::test {
namespace {

/// A scene with dark and light parts that moves to the right and down.
struct Scene {
  double u = 7, v = -4;
  Waves broad{20, 120, 5, 60}, fine{4, 20, 8, 60};

  Image<float> at(double t, const std::function<double(double, double)>& light) const {
    return drawn(240, 200, [&](double x, double y) {
      const double value = 0.4 + 0.15 * std::tanh(2 * broad(x - t * u, y - t * v)) + 0.08 * fine(x - t * u, y - t * v);
      return std::max(0.02, value) * light(x, y);
    });
  }
  /// The mean of the distance from the motion, away from borders.
  double error(const ImageFlow& flow) const {
    return endpoint_error(forward_displacement(flow), 24, [&](double, double) { return std::array{u, v}; });
  }
};

const auto plain = [](double, double) { return 1.0; };
/// Darker towards the sides, and a warmer tint would be such in one channel.
double falling_off(double x, double y) {
  return 1 - 0.35 * (std::pow((x - 120) / 120, 2) + std::pow((y - 100) / 100, 2)) / 2;
}

TEST(LightRatio, IsWhatTheOneHasMoreAlongTheMotion) {
  const Scene scene;
  const Image<float> source = scene.at(0, plain), target = scene.at(1, falling_off);
  Image<float> X(240, 200, 2);
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < 240; ++x) X(x, y, 0) = float(scene.u), X(x, y, 1) = float(scene.v);
  const LightRatio found = light_ratio(source, target, X), swapped = light_ratio(target, source, [&] {
    Image<float> back = X;
    for (float& value : back.values()) value = -value;
    return back;
  }());
  for (int y = 30; y < 170; y += 7)
    for (int x = 30; x < 210; x += 7) {
      EXPECT_NEAR(std::exp(found.of_target(x, y)), falling_off(x, y), 0.03) << x << ' ' << y;
      EXPECT_FLOAT_EQ(found.of_target(x, y), -swapped.of_source(x, y));
    }
  EXPECT_NEAR(found.size, swapped.size, 1e-9);
  EXPECT_LT(light_ratio(source, scene.at(1, plain), X).size, 0.004);
}

/// But for what is added to means, a hundredth.
TEST(LightRatio, BringsEachToTheLightOfTheOther) {
  const Image<float> source(40, 30, 1, 0.4F), target(40, 30, 1, 0.6F), still(40, 30, 2);
  const LightRatio ratio = light_ratio(source, target, still);
  EXPECT_EQ(ratio.size, 0);  // all of it may be cut off
  const auto stepped = [](float low, float high) {
    return drawn(40, 30, [&](double x, double y) { return (int(x) + int(y)) % 2 == 0 ? low : high; });
  };
  const Image<float> dark = stepped(0.2F, 0.3F), light = stepped(0.4F, 0.6F);
  Image<float> bright = light;
  bright(0, 0) = 0.7F;  // nothing else is cut off
  Image<float> dim = dark;
  dim(0, 0) = 0.35F;
  const LightRatio twice = light_ratio(dim, bright, still);
  const LitImages first = in_light(twice, dim, bright, 0), half = in_light(twice, dim, bright, 0.5),
                  mean = in_mean_light(twice, dim, bright);
  for (int x = 5; x < 35; ++x) {
    EXPECT_NEAR(first.source(x, 15), dim(x, 15), 1e-6);
    EXPECT_NEAR(first.target(x, 15), dim(x, 15), 0.01);
    EXPECT_NEAR(half.source(x, 15), 1.5 * dim(x, 15), 0.01);
    EXPECT_NEAR(half.source(x, 15), half.target(x, 15), 0.01);
    EXPECT_NEAR(mean.source(x, 15), mean.target(x, 15), 0.01);
  }
}

TEST(LightRatio, LetsMotionsBeFoundInAnyLight) {
  const Scene scene;
  const Image<float> source = scene.at(0, plain);
  ImageFlowOptions kept;
  kept.light = ImageLight::kept;
  for (const auto& light : {std::function<double(double, double)>([](double, double) { return 1.1; }),
                            std::function<double(double, double)>([](double, double) { return 0.6; }),
                            std::function<double(double, double)>(falling_off)}) {
    const Image<float> target = scene.at(1, light);
    const ImageFlow flow = image_flow(source, target);
    ASSERT_TRUE(flow.fit);
    EXPECT_EQ(flow.fit->light, ImageLight::evened);
    EXPECT_LT(scene.error(flow), 0.3);
    EXPECT_LT(scene.error(flow), 0.3 * scene.error(image_flow(source, target, kept)));
    // What lies between has the light of both.
    const Image<float> between = interpolated(flow, source, target, 0.5);
    const Image<float> truth = scene.at(0.5, [&](double x, double y) { return (1 + light(x, y)) / 2; });
    for (int y = 30; y < 170; y += 7)
      for (int x = 30; x < 210; x += 7) EXPECT_NEAR(between(x, y), truth(x, y), 0.03) << x << ' ' << y;
  }
  EXPECT_EQ(image_flow(source, scene.at(1, plain)).fit->light, ImageLight::kept);
}

/// It is what `doubted` finds by itself where light is another, and hardly a ratio where it is not.
TEST(LightRatio, IsMadeGoodWhereThatIsAskedFor) {
  const Scene scene;
  const Image<float> source = scene.at(0, plain);
  ImageFlowOptions asked;
  asked.light = ImageLight::evened;
  const Image<float> darker = scene.at(1, falling_off);
  const ImageFlow flow = image_flow(source, darker, asked), swapped = image_flow(darker, source, asked);
  ASSERT_TRUE(flow.fit && swapped.fit);
  EXPECT_EQ(flow.fit->light, ImageLight::evened);
  EXPECT_EQ(flow.field.values().front(), image_flow(source, darker).field.values().front());
  EXPECT_LT(scene.error(flow), 0.3);
  EXPECT_GT(flow.fit->ratio.size, 0.1);
  for (std::size_t i = 0; i < flow.field.values().size(); i += 97)
    EXPECT_NEAR(swapped.field.values()[i], -flow.field.values()[i], 1e-3);
  const ImageFlow same = image_flow(source, scene.at(1, plain), asked);
  EXPECT_EQ(same.fit->light, ImageLight::evened);
  EXPECT_LT(same.fit->ratio.size, 0.01);
  EXPECT_LT(scene.error(same), 0.3);
}

TEST(LightRatio, IsRefusedOfNegativeValuesAndWithoutASearch) {
  const Scene scene;
  Image<float> source = scene.at(0, plain);
  const Image<float> target = scene.at(1, plain);
  ImageFlowOptions asked;
  asked.light = ImageLight::evened;
  for (const FlowSearch search : {FlowSearch::none, FlowSearch::far}) {
    asked.search = search;
    if (search == FlowSearch::far) source(3, 4) = -0.1F;
    EXPECT_THROW(image_flow(source, target, asked), InvalidInput);
  }
}

/// A shadow on a third of the second: the ratio jumps at its edge, and the motion is found under it all the same.
TEST(LightRatio, BreaksAtTheEdgeOfAShadow) {
  const Scene scene;
  const auto shadow = [](double x, double) { return x > 150 ? 0.5 : 1.0; };
  const Image<float> source = scene.at(0, plain), target = scene.at(1, shadow);
  Image<float> X(240, 200, 2);
  for (std::size_t i = 0; i < X.values().size(); ++i) X.values()[i] = float(i % 2 == 0 ? scene.u : scene.v);
  const LightRatio smooth = light_ratio(source, target, X), broken = light_ratio(source, target, X, LightBreaks::found);
  for (int y = 30; y < 170; y += 7)
    for (const int x : {120, 142, 158, 180}) {
      EXPECT_NEAR(std::exp(broken.of_target(x, y)), shadow(x, y), 0.06) << x << ' ' << y;
    }
  EXPECT_GT(std::exp(smooth.of_target(158, 100)), 0.6);
  const Image<float> falling = scene.at(1, falling_off);
  EXPECT_EQ(light_ratio(source, falling, X, LightBreaks::found).size, light_ratio(source, falling, X).size);
  const ImageFlow flow = image_flow(source, target);
  EXPECT_EQ(flow.fit->light, ImageLight::evened);
  EXPECT_LT(scene.error(flow), 0.6);
}

TEST(LightRatio, SeesThroughWhatIsCutOff) {
  const Scene scene;
  const auto cut = [](Image<float> image) {
    for (float& value : image.values()) value = std::min(value, 0.6F);
    return image;
  };
  const Image<float> source = cut(scene.at(0, plain)), target = cut(scene.at(1, [](double, double) { return 1.3; }));
  const ImageFlow flow = image_flow(source, target);
  EXPECT_EQ(flow.fit->light, ImageLight::evened);
  EXPECT_LT(scene.error(flow), 0.6);
}

}  // namespace
}  // namespace mq::test

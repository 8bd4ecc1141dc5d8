// What filters in time say of how far they have come: frames that take long to load are most of the work.
#include <gtest/gtest.h>

#include "fixtures.h"
#include "linear/matrices.h"
#include "mq/fem/vertex_space.h"
#include "mq/video/light_removal.h"

namespace mq {
namespace {

/// Fractions of the whole as they were said, of a film of frames each of which says when it is half read.
struct Said {
  double fraction = 0;
  std::vector<double> half_read, stored;
  bool falls = false;

  Progress progress() {
    return Progress([this](const ProgressEvent& event) {
      falls = falls || event.fraction < fraction;
      fraction = event.fraction;
    });
  }

  FrameSource film() {
    const auto space = std::make_shared<VertexSpace>(make_surface(fixtures::torus(12, 8)));
    return [this, space](int f, const Progress& reading) {
      reading.step("follow", 0.9).at(5.0 / 9);
      half_read.push_back(fraction);
      return TemporalFrame{space, nullptr, test::random_signal(space->size(), 1, f + 1),
                           f == 0 ? TimeLinks() : identical_links(space->size())};
    };
  }

  std::function<void(int, const TemporalFrame&, Signal)> output() {
    return [this](int, const TemporalFrame&, const Signal&) { stored.push_back(fraction); };
  }
};

void expect_near(const std::vector<double>& found, const std::vector<double>& wanted) {
  ASSERT_EQ(found.size(), wanted.size());
  for (std::size_t i = 0; i < wanted.size(); ++i) EXPECT_NEAR(found[i], wanted[i], 1e-12) << i;
}

TEST(FilterProgress, OfMeansCountsFramesThatAreReadAndFiltered) {
  Said said;
  remove_lighting(4, said.film(), said.output(),
                  {.weight = 0.01, .radius = 1, .costs = {.load = 4, .store = 1}}, said.progress());
  const double all = 4 * (4 + 1 + 1);
  expect_near(said.half_read, {2 / all, 6 / all, 12 / all, 18 / all});
  expect_near(said.stored, {9 / all, 15 / all, 21 / all, 23 / all});
  EXPECT_FALSE(said.falls);
}

TEST(FilterProgress, OfPartsOfMeansCountsTheFramesAroundThem) {
  Said said;
  remove_lighting(9, said.film(), said.output(),
                  {.weight = 0.01, .radius = 2, .first = 3, .end = 5, .costs = {.load = 4, .store = 1}}, said.progress());
  const double all = 6 * 4 + 2 * (1 + 1);
  expect_near(said.half_read, {2 / all, 6 / all, 10 / all, 14 / all, 18 / all, 24 / all});
  EXPECT_FALSE(said.falls);
}

TEST(FilterProgress, OfAllFramesAtOnceCountsEveryWindow) {
  Said said;
  const TemporalOptions options{.gamma = 1, .window = 7, .accuracy = 0.1, .costs = {.load = 4, .store = 1}};
  const int ahead = look_ahead(options), frames = 10, kept = 7 - ahead;
  ASSERT_EQ(ahead, 3);
  temporal_poisson(frames, said.film(), said.output(), options, said.progress());
  // Windows of frames 0 to 6, of which four are kept, and 4 to 9.
  const double all = frames * (4 + 1) + 7 + 6, first = 7 * 4 + 7 + kept;
  std::vector<double> read, stored;
  for (int f = 0; f < 7; ++f) read.push_back((4 * f + 2) / all);
  for (int f = 0; f < 3; ++f) read.push_back((first + 4 * f + 2) / all);
  for (int f = 0; f < kept; ++f) stored.push_back((7 * 4 + 7 + f) / all);
  for (int f = 0; f < 6; ++f) stored.push_back((first + 3 * 4 + 6 + f) / all);
  expect_near(said.half_read, read);
  expect_near(said.stored, stored);
  EXPECT_FALSE(said.falls);
}

}  // namespace
}  // namespace mq

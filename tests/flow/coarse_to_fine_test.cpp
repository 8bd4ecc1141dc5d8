// The loop over levels, on a domain of one number: X is right where it is 1.

#include "mq/flow/detail/coarse_to_fine.h"

#include <gtest/gtest.h>

#include <cmath>

namespace mq {
namespace {

/// The error is (1 − X)², and a correction too long by `overshoot`. `harm` is what the end of a
/// level adds to X, by the level's number.
class Number final : public FlowDomain {
 public:
  explicit Number(double overshoot = 1, std::vector<double> harm = {})
      : overshoot_(overshoot), harm_(std::move(harm)) {}

  std::string name(const FlowScale&) const override { return "level"; }
  double work(const FlowScale&) const override { return 1; }
  double blend_error() const override { return 1; }
  FlowLevel& enter(const FlowScale&) override { return levels.emplace_back(); }
  void look_up() override { starts.push_back(x); }
  double level_error() const override { return (1 - x) * (1 - x); }
  int most_steps() const override { return 3; }
  double correct(const Progress&, double) override {
    y_ = 1 - x;
    return overshoot_;
  }
  FlowErrorChange attempt(double factor) override {
    ++attempts;
    next_ = x + factor * y_;
    return {level_error(), (1 - next_) * (1 - next_)};
  }
  void take() override { x = next_; }
  void leave() override {}
  double measure() override {
    if (levels.size() <= harm_.size()) x += harm_[levels.size() - 1];
    return level_error();
  }
  void keep() override { best = x; }
  void forget() override { best = 0; }
  void go_back_if_better() override { x = best; }
  std::optional<double> settled_error() override {
    return std::exchange(truth, std::optional<double>());
  }

  double x = 0, best = 0;
  int attempts = 0;
  std::optional<double> truth;
  std::vector<FlowLevel> levels;
  std::vector<double> starts;

 private:
  double overshoot_, y_ = 0, next_ = 0;
  std::vector<double> harm_;
};

std::vector<double> run(Number& domain, const FlowOptions& options, const FlowPolicy& policy) {
  return coarse_to_fine(domain, halved_scales(8, 1.5), options, policy, {});
}

TEST(CoarseToFine, HalvesLengthsDownToABound) {
  const std::vector<FlowScale> scales = halved_scales(8, 1.5);
  ASSERT_EQ(scales.size(), 3U);
  EXPECT_EQ(scales.back().length, 2);
  EXPECT_TRUE(scales.back().smoothed());
  EXPECT_EQ(halved_scales(8, 0, 5).size(), 5U);
}

TEST(CoarseToFine, HalvesACorrectionUntilTheErrorFalls) {
  Number domain(3.9);  // 3.9 and 1.95 times: only the latter is nearer to 1 than 0 is
  EXPECT_NEAR(run(domain, {}, {.halvings = 2}).back(), std::pow(0.95, 18), 1e-12);
  Number hopeless(3.9);
  EXPECT_EQ(run(hopeless, {}, {.halvings = 0}).back(), 1);
  EXPECT_EQ(hopeless.attempts, 3);
  EXPECT_EQ(hopeless.levels.front().steps, 0);
}

TEST(CoarseToFine, CutsLongCorrectionsAndTakesThemWholeWhereAsked) {
  Number cut(100);
  run(cut, {}, {.halvings = 2});
  EXPECT_EQ(cut.x, 1);  // 4, 2 and then 1
  Number whole(3);
  const std::vector<double> errors =
      run(whole, {.step_length = FlowStepLength::scaled}, {});
  EXPECT_GT(errors.back(), errors.front());
  EXPECT_EQ(whole.best, whole.x);
}

TEST(CoarseToFine, EndsALevelWhereAStepGainsLittle) {
  Number domain(0.1);  // 19 % of the squared error
  run(domain, {.least_gain = 0.2}, {});
  EXPECT_EQ(domain.levels.front().steps, 1);
  Number patient(0.1);
  run(patient, {.least_gain = 0.1}, {});
  EXPECT_EQ(patient.levels.front().steps, 3);
}

TEST(CoarseToFine, KeepsTheBestFieldAndNeverListsARise) {
  for (const auto after : {FlowPolicy::AfterWorse::last, FlowPolicy::AfterWorse::better}) {
    Number domain(0.5, {0, 1, 0});
    const std::vector<double> errors = run(domain, {}, {.after_worse = after});
    ASSERT_EQ(errors.size(), 4U);
    for (std::size_t i = 1; i < errors.size(); ++i) EXPECT_LE(errors[i], errors[i - 1]);
    EXPECT_EQ(errors[2], errors[1]);
    EXPECT_EQ(errors.back(), (1 - domain.best) * (1 - domain.best));
    // What was kept is that of the first level.
    EXPECT_EQ(domain.starts[2] < 1, after == FlowPolicy::AfterWorse::better);
  }
}

TEST(CoarseToFine, ListsNoErrorBelowTheOneThatIsTrue) {
  Number domain(0.5, {0, 0, -1});  // the last level does harm
  domain.truth = 2;                // worse than nothing
  const std::vector<double> errors = run(domain, {}, {});
  EXPECT_EQ(errors.front(), 1);
  for (std::size_t i = 1; i < errors.size(); ++i) EXPECT_LE(errors[i], errors[i - 1]);
}

}  // namespace
}  // namespace mq

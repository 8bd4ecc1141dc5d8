#include "mq/base/apart.h"

#include <atomic>
#include <future>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "mq/base/error.h"
#include "mq/base/stopwatch.h"

namespace mq {
namespace {

TEST(RunApart, WaitsForTheWorkAndPassesOnWhatItThrows) {
  int done = 0;
  run_apart([&] { done = 7; }, {}, 1);
  EXPECT_EQ(done, 7);
  EXPECT_THROW(run_apart([] { throw SolverError("no"); }, {}, 1), SolverError);
}

TEST(RunApart, ComesAsFarAsTheClockSays) {
  std::vector<double> fractions;
  std::promise<void> enough;
  const auto work = [wait = enough.get_future().share()] { wait.wait(); };
  const Stopwatch watch;
  const Progress counting([&](const ProgressEvent& event) {
    fractions.push_back(event.fraction);
    if (fractions.size() == 12) enough.set_value();
  });
  run_apart(work, counting, 0.5);  // of which it takes twice as long
  ASSERT_EQ(fractions.size(), 12U);
  for (std::size_t i = 1; i < fractions.size(); ++i) EXPECT_GT(fractions[i], fractions[i - 1]);
  EXPECT_LE(fractions[0], watch.seconds() / 0.5);
  EXPECT_GT(fractions.back(), 0.9);
  EXPECT_LT(fractions.back(), 1);
}

TEST(RunApart, DoesNotWaitWhenAskedToStop) {
  std::atomic<bool> cancel = false;
  const Progress progress([&](const ProgressEvent&) { cancel = true; }, &cancel);
  std::promise<void> release;
  const auto ended = std::make_shared<std::promise<void>>();
  std::future<void> end = ended->get_future();
  EXPECT_THROW(run_apart(
                   [wait = release.get_future().share(), ended] {
                     wait.wait();  // would last for ever
                     ended->set_value();
                   },
                   progress, 1000),
               Cancelled);
  release.set_value();
  end.wait();  // the work went on meanwhile
}

}  // namespace
}  // namespace mq

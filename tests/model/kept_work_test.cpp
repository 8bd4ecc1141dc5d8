// What one run prepared is taken by the next on the same charts, and by no other.
#include "mq/model/kept_work.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "linear/matrices.h"
#include "model/program_files.h"
#include "mq/base/error.h"

namespace mq {
namespace {

class Keeping : public testing::Test {
 protected:
  TwoCharts charts;
  KeptWork kept;

  std::shared_ptr<const TexelSpace> space(const TexturedModel& model, const TexelSpaceOptions& options = {}) {
    return kept.space(model.surface, *model.atlas, options);
  }
};

TEST_F(Keeping, GivesTheSpaceOfEqualChartsAgain) {
  const auto first = space(charts.model);
  {
    const TwoCharts others;
    EXPECT_EQ(space(others.model), first);
  }
  const TexelSpace fresh(charts.model.surface, *charts.model.atlas);
  const Signal psi = test::random_signal(fresh.size(), 2);
  EXPECT_EQ(first->stiffness_times(psi), fresh.stiffness_times(psi));
  kept.forget();
  EXPECT_EQ(first->size(), fresh.size());  // who holds it still may
}

TEST_F(Keeping, MakesAnotherWhereAnythingDiffers) {
  const auto first = space(charts.model);
  const auto other = [&](auto change) {
    TexturedModel model = load_textured_model(charts.folder / "strip.obj", {}, charts.messages);
    change(model);
    const auto found = space(model);
    EXPECT_NE(found, first);
    EXPECT_EQ(space(model), found);
    EXPECT_NE(space(charts.model), found);
  };
  other([](TexturedModel& model) { model.surface.mesh.positions[0].x() += 1e-9; });
  other([](TexturedModel& model) { model.atlas->corners[0][0].x += 1; });
  other([](TexturedModel& model) { model.atlas->textures[0].height += 8; });
  EXPECT_NE(space(charts.model, {.seams = TexelSpaceOptions::Seams::soft, .seam_penalty = 1, .metrics = {}}), space(charts.model));
  TexelSpaceOptions own;
  own.metrics.assign(std::size_t(charts.model.surface.triangle_count()), TexelMetric{1, 1, 0, 1, 1});
  EXPECT_NE(space(charts.model, own), space(charts.model, own));
}

TEST_F(Keeping, GivesTheEquationOfTheSameWeightAndSolverAgain) {
  const auto at = space(charts.model);
  const SolverChoice direct{.kind = SolverChoice::Kind::direct}, any;
  const auto equation = [&](const SignalSpace& on, double weight, const SolverChoice& choice) {
    return kept.equation(on, weight, choice, on.solver());
  };
  const auto first = equation(*at, 0.01, direct);
  EXPECT_FALSE(first.kept);
  const auto again = equation(*at, 0.01, direct);
  EXPECT_TRUE(again.kept);
  EXPECT_EQ(again.of, first.of);
  EXPECT_FALSE(equation(*at, 0.02, direct).kept);
  EXPECT_FALSE(equation(*at, 0.02, any).kept);
  EXPECT_FALSE(equation(*at, 0.02, {.stop = {.tolerance = 1e-3}}).kept);
  EXPECT_TRUE(equation(*at, 0.02, {.stop = {.tolerance = 1e-3}}).kept);
  kept.forget_equation();
  EXPECT_FALSE(equation(*at, 0.02, {.stop = {.tolerance = 1e-3}}).kept);
  EXPECT_EQ(space(charts.model), at);
  const TexelSpace elsewhere(charts.model.surface, *charts.model.atlas);
  EXPECT_FALSE(equation(elsewhere, 0.02, direct).kept);
  EXPECT_FALSE(equation(elsewhere, 0.02, direct).kept);
}

TEST_F(Keeping, HoldsNothingOfWhatFailed) {
  const auto first = space(charts.model);
  TexturedModel none = load_textured_model(charts.folder / "strip.obj", {}, charts.messages);
  std::ranges::fill(none.atlas->chart, -1);
  EXPECT_THROW(space(none), InvalidInput);
  EXPECT_NE(space(charts.model), first);
}

/// Frames, slots and jobs of one model: the files of each alone.
TEST(KeptForOthers, GivesTheSamePicturesInFramesAndBatches) {
  const test::Folder folder;
  test::write_strip(folder);
  for (const char* beta : {"0", "0.4"})
    run(folder, {"filter", "strip.obj", "--beta", beta, "-o", beta[1] ? "t_2.png" : "t_1.png"});
  const std::vector<std::string> options{"--beta", "3", "--alpha", "0.01", "--solver", "multigrid"};
  const auto filter = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"filter", "strip.obj"});
    words.insert(words.end(), options.begin(), options.end());
    return words;
  };
  for (const std::string n : {"1", "2"}) run(folder, filter({"t_" + n + ".png", "-o", "alone_" + n + ".png"}));
  const test::Result frames = test::marquetry(folder, filter({"t_%d.png", "-o", "frame_%d.png", "--frames", "1-2", "--json"}));
  ASSERT_EQ(frames.status, 0) << frames.error;
  EXPECT_EQ(frames.json()["frames"][0]["kept"], false);
  EXPECT_EQ(frames.json()["frames"][1]["kept"], true);

  nlohmann::json jobs = {filter({"t_1.png", "-o", "job_1.png"}), filter({"t_2.png", "-o", "job_2.png"}),
                         {"fill", "strip.obj", "-o", "filled.png"},
                         filter({"t_2.png", "-o", "job_3.png", "--overwrite"})};
  test::write_bytes(folder / "jobs.json", jobs.dump());
  const test::Result batch = test::marquetry(folder, {"batch", "jobs.json", "--json"});
  ASSERT_EQ(batch.status, 0) << batch.error;
  EXPECT_EQ(batch.json()["result"]["jobs"][1]["kept"], true);
  for (const std::string n : {"1", "2"}) {
    EXPECT_EQ(bytes(folder, "frame_" + n + ".png"), bytes(folder, "alone_" + n + ".png"));
    EXPECT_EQ(bytes(folder, "job_" + n + ".png"), bytes(folder, "alone_" + n + ".png"));
  }
  EXPECT_EQ(bytes(folder, "job_3.png"), bytes(folder, "alone_2.png"));
  EXPECT_NE(bytes(folder, "alone_1.png"), bytes(folder, "alone_2.png"));
}

}  // namespace
}  // namespace mq

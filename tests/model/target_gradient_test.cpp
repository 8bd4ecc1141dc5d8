// Gradients of one's own: fields and tables of a signal's own differences say that signal; tables are refused by line.
#include "mq/model/target_gradient.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fem/cut_squares.h"
#include "linear/matrices.h"
#include "model/program_files.h"
#include "mq/fem/texel_vector_space.h"
#include "mq/base/error.h"

namespace mq {
namespace {


using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// All pairs of texels of one picture that have functions in common, with ψ's differences.
EdgeDifferences differences_of(const TexelSpace& space, const Signal& psi) {
  EdgeDifferences table{.at = EdgeDifferences::At::texels, .pairs = {}, .channels = int(psi.cols()), .values = {}};
  const auto place = [&](int i) {
    const Texels::Place& p = space.texels().places[std::size_t(i)];
    return EdgeDifferences::Place{p.texture, p.x, p.y};
  };
  for (const auto& [i, j] : space.edges()) {
    // From the second to the first in every third pair.
    const bool turned = (i + j) % 3 == 0;
    table.pairs.push_back({.from = place(turned ? j : i), .to = place(turned ? i : j), .line = int(table.pairs.size()) + 2});
    for (Eigen::Index c = 0; c < psi.cols(); ++c) table.values.push_back((turned ? -1 : 1) * (psi(j, c) - psi(i, c)));
  }
  return table;
}

class TargetGradient : public testing::Test {
 protected:
  TwoCharts charts;
  TextureSignal signal{charts.model, {}, charts.messages};
  const TexelSpace& space = signal.space();
};

TEST_F(TargetGradient, OfATableOfAllDifferencesIsThatOfTheirSignal) {
  const Signal wanted = test::random_signal(space.size(), 3), psi = test::random_signal(space.size(), 3, 2);
  const Signal found = gradient_moments(charts.model, signal, psi, 1, differences_of(space, wanted));
  const Signal expected = space.stiffness_times(wanted);
  EXPECT_LT((found - expected).norm(), 1e-12 * expected.norm());
}

TEST_F(TargetGradient, OfATableKeepsWhatItDoesNotName) {
  const Signal psi = test::random_signal(space.size(), 3);
  EdgeDifferences table = differences_of(space, psi);
  table.pairs.resize(1);
  table.values.resize(3);
  const Signal same = gradient_moments(charts.model, signal, psi, 1, table), all = space.stiffness_times(psi);
  EXPECT_LT((same - all).norm(), 1e-12 * all.norm());
  table.channels = 1;  // the first value for all
  table.values[0] += 0.5;
  const Signal one = gradient_moments(charts.model, signal, psi, 1, table) - all;
  EXPECT_GT(one.norm(), 0.1);
  // Half of its own everywhere else.
  const Signal half = gradient_moments(charts.model, signal, psi, 0.5, table);
  EXPECT_GT((half - 0.5 * all).norm(), 0.01);
  int changed = 0;
  for (Eigen::Index i = 0; i < half.rows(); ++i) changed += (half - 0.5 * all).row(i).norm() > 1e-12;
  EXPECT_LT(changed, 40);
}

/// Of a function that is linear on the flat strip, per triangle and per texel, whose places are known to single precision.
TEST_F(TargetGradient, OfFieldsIsTheirDivergence) {
  const Vector3 slope(0.3, -0.2, 0);
  Signal linear(space.size(), 1);
  for (int i = 0; i < space.size(); ++i) linear(i, 0) = slope.dot(space.texels().position(i));
  const Vector expected = space.stiffness_times(linear);
  ModelField field{TangentField(std::size_t(charts.model.surface.triangle_count()), slope), {}, {}};
  EXPECT_LT((gradient_moments(charts.model, signal, field) - expected).norm(), 1e-5 * expected.norm());
  field.texels = TexelVectorSpace(charts.model.surface, *signal.texel_atlas(), space).from_triangles(field.field);
  EXPECT_LT((gradient_moments(charts.model, signal, field) - expected).norm(), 0.02 * expected.norm());
}

TEST_F(TargetGradient, OfAFieldAtVerticesIsExact) {
  Messages messages;
  test::Folder folder;
  test::write_bytes(folder / "fan.ply", test::coloured_ply);
  const TexturedModel fan = load_textured_model(folder / "fan.ply", {}, messages);
  const VertexColourSignal colours(fan);
  const Vector f = test::random_signal(colours.space().size(), 1);
  const ModelField field{gradient_field(fan.surface, f), {}, {}};
  EXPECT_LT((gradient_moments(fan, colours, field) - colours.space().stiffness_times(f)).norm(), 1e-14);
  EdgeDifferences table{.at = EdgeDifferences::At::vertices, .pairs = {{.from = {1, 0, 0}, .to = {3, 0, 0}, .line = 2}}, .channels = 1, .values = {0.1}};
  EXPECT_THAT([&] { gradient_moments(fan, colours, colours.values(), 1, table); },
              ThrowsMessage<InvalidInput>(HasSubstr("line 2: vertex 1 and vertex 3 are not next to each other")));
  table.pairs[0].to = {7, 0, 0};
  EXPECT_THAT([&] { gradient_moments(fan, colours, colours.values(), 1, table); },
              ThrowsMessage<InvalidInput>(HasSubstr("found vertex 7, wanted one that the surface uses")));
  EXPECT_THAT([&] { gradient_moments(charts.model, signal, signal.values(), 1, table); },
              ThrowsMessage<InvalidInput>(HasSubstr("names vertices, and what is worked on are texels")));
}

TEST_F(TargetGradient, OfATableThatDoesNotFitIsRefusedByLine) {
  const auto refused = [&](std::vector<EdgeDifferences::Pair> pairs) {
    EdgeDifferences table{.at = EdgeDifferences::At::texels, .pairs = std::move(pairs), .channels = 1, .values = {}};
    table.values.resize(table.pairs.size());
    try {
      gradient_moments(charts.model, signal, signal.values(), 1, table);
    } catch (const InvalidInput& error) {
      return std::string(error.what());
    }
    return std::string("not refused");
  };
  EXPECT_THAT(refused({{.from = {0, 0, 0}, .to = {0, 1, 0}, .line = 2}}), HasSubstr("line 2: found column 0, row 0, wanted one that"));
  EXPECT_THAT(refused({{.from = {0, 900, 7}, .to = {0, 1, 0}, .line = 3}}), HasSubstr("line 3: found column 900, row 7"));
  EXPECT_THAT(refused({{.from = {2, 10, 10}, .to = {0, 10, 11}, .line = 4}}), HasSubstr("found texture 2, column 10, row 10"));
  EXPECT_THAT(refused({{.from = {0, 10, 10}, .to = {0, 13, 10}, .line = 5}}),
              HasSubstr("line 5: column 10, row 10 and column 13, row 10 are not next to each other"));
  EXPECT_THAT(refused({{.from = {0, 10, 10}, .to = {0, 11, 10}, .line = 6}, {.from = {0, 11, 10}, .to = {0, 10, 10}, .line = 8}}),
              HasSubstr("line 8: the same two as in line 6"));
  EdgeDifferences two{.at = EdgeDifferences::At::texels, .pairs = {{.from = {0, 10, 10}, .to = {0, 11, 10}, .line = 2}}, .channels = 2, .values = {0, 0}};
  EXPECT_THAT([&] { gradient_moments(charts.model, signal, signal.values(), 1, two); },
              ThrowsMessage<InvalidInput>(HasSubstr("has 2 values, wanted one, or one for each of 3 channels")));
}

}  // namespace
}  // namespace mq

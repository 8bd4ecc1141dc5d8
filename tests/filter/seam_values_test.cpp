// Texels at seams for which both sides agree.
#include "mq/filter/seam_values.h"

#include <gtest/gtest.h>

#include <cmath>

#include "fem/cut_squares.h"
#include "linear/matrices.h"

namespace mq {
namespace {

using fixtures::Cut;
using fixtures::cut_squares;

/// √∫ d² over all seams, in the units of the penalty: ψᵀ (A − S) ψ with A and S with and without
/// it.
double seam_energy(const Cut& cut, const TexelSpace& space, const Signal& psi) {
  const TexelSpace plain(cut.model->surface, cut.model->atlas, soft_seams(cut.model->atlas, 0));
  const Signal d = space.stiffness_times(psi) - plain.stiffness_times(psi);
  return std::sqrt(std::max(0.0, psi.cwiseProduct(d).sum()));
}

TEST(SeamValues, KeepConstantsAndAllThatIsNotFree) {
  for (const Cut& cut : cut_squares()) {
    const TexelSpace space(cut.model->surface, cut.model->atlas, soft_seams(cut.model->atlas));
    const std::vector<char> free = seam_texels(cut.model->surface, cut.model->atlas, space);
    const Signal constant = Signal::Constant(space.size(), 2, 0.4);
    const Signal noise = test::random_signal(space.size(), 2);
    for (const Smooth what : {Smooth::values, Smooth::change}) {
      EXPECT_LT(
          (smooth_at_seams(space, constant, free, what).signal - constant).cwiseAbs().maxCoeff(),
          1e-12)
          << cut.name;
      const Signal found = smooth_at_seams(space, noise, free, what).signal;
      for (int i = 0; i < space.size(); ++i)
        if (!free[i]) {
          EXPECT_TRUE(found.row(i) == noise.row(i)) << cut.name;
        }
    }
  }
}

TEST(SeamValues, MakeBothSidesAgree) {
  int tried = 0;
  for (const Cut& cut : cut_squares()) {
    if (cut.options.parts == 1 || !cut.apart || cut.size.width < 40) continue;
    const TexelSpace space(cut.model->surface, cut.model->atlas, soft_seams(cut.model->atlas));
    const std::vector<char> free = seam_texels(cut.model->surface, cut.model->atlas, space);
    const Signal noise = test::random_signal(space.size(), 2);
    const double before = seam_energy(cut, space, noise);
    for (const Smooth what : {Smooth::values, Smooth::change}) {
      const Signal found = smooth_at_seams(space, noise, free, what).signal;
      // Noise asks for values far beyond those around, of which there are fewer to go by where what
      // is free means nothing.
      EXPECT_LT(seam_energy(cut, space, found), (what == Smooth::change ? 0.1 : 0.25) * before)
          << cut.name;
      const double low = noise.minCoeff(), high = noise.maxCoeff(), more = 0.25 * (high - low);
      EXPECT_GE(found.minCoeff(), low - more - 1e-12) << cut.name;
      EXPECT_LE(found.maxCoeff(), high + more + 1e-12) << cut.name;
    }
    ++tried;
  }
  EXPECT_GE(tried, 5);
}

/// A linear function has no jump, so that a smooth change of it is none; and it is its own
/// smoothest continuation where the flat surface goes on across the seam.
TEST(SeamValues, LeaveLinearFunctionsAlone) {
  const Cut cut = fixtures::cut("", fixtures::turned(fixtures::odd_angle), {48, 48});
  const TexelSpace space(cut.model->surface, cut.model->atlas, soft_seams(cut.model->atlas));
  const std::vector<char> free = seam_texels(cut.model->surface, cut.model->atlas, space);
  Signal linear(space.size(), 1);
  for (int i = 0; i < space.size(); ++i) {
    const auto& p = space.texels().positions[i];
    linear(i, 0) = 0.3 + 0.5 * p[0] - 0.2 * p[1];
  }
  const Signal found = smooth_at_seams(space, linear, free, Smooth::change).signal;
  EXPECT_LT((found - linear).cwiseAbs().maxCoeff(), 1e-5);  // places are in single precision
}

}  // namespace
}  // namespace mq

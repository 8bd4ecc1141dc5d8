#include "mq/video/frame_drift.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "fem/cut_squares.h"
#include "linear/matrices.h"
#include "mq/sample/noise.h"
#include "mq/video/light_removal.h"

namespace mq {
namespace {

/// A torus in charts at odd angles, on which a pattern slides by so many texels a frame.
class SlidingFilm {
 public:
  SlidingFilm(double texels, int frames, double noise) {
    const auto cut = fixtures::turned(fixtures::odd_angle);
    model_ = fixtures::textured(fixtures::cut_torus({.cells = 48, .parts = 2, .jitter = 0, .scale = cut.scale,
                                                     .angle = cut.angle, .shift = cut.shift}),
                                {{160, 160}});
    space_ = std::make_shared<TexelSpace>(model_->surface, model_->atlas);
    const double angle = texels * space_->scale().texel_spacing;
    for (int f = 0; f < frames; ++f) {
      truth_.push_back(pattern(f * angle));
      film_.push_back(truth_.back() + noise * test::random_signal(space_->size(), 3, f + 1));
    }
  }

  const TexelSpace& space() const { return *space_; }
  const Signal& truth(int f) const { return truth_[std::size_t(f)]; }
  const Signal& shown(int f) const { return film_[std::size_t(f)]; }

  enum class Drift { none, at_rest, followed };

  /// A mean over this many frames to either side.
  std::vector<Signal> means(int radius, Drift how) const {
    std::vector<Signal> result;
    remove_lighting(
        int(film_.size()), [&](int f, const Progress&) { return frame(f, how); },
        [&](int, const TemporalFrame&, Signal phi) { result.push_back(std::move(phi)); },
        {.weight = 0, .radius = radius});
    return result;
  }

  /// All frames at once, changes in time weighed by γ; light is added to every other frame.
  std::vector<Signal> filtered(double gamma, Drift how, double light = 0) const {
    std::vector<Signal> result;
    temporal_poisson(
        int(film_.size()),
        [&](int f, const Progress&) {
          TemporalFrame lit = frame(f, how);
          if (f % 2 == 1) lit.psi.array() += light;
          return lit;
        },
        [&](int, const TemporalFrame&, Signal phi) { result.push_back(std::move(phi)); }, {.gamma = gamma});
    return result;
  }

 private:
  TemporalFrame frame(int f, Drift how) const {
    TimeLinks links;
    if (f > 0) links = identical_links(space_->size());
    TemporalFrame frame{space_, nullptr, shown(f), links, {}};
    if (how == Drift::none) return frame;
    const auto drift = std::make_shared<FrameDrift>(model_, model_->surface, model_->atlas, *space_);
    if (f > 0 && how == Drift::followed) drift->follow(shown(f - 1), shown(f));
    frame.drift = drift;
    return frame;
  }

  Signal pattern(double angle) const {
    const Eigen::Matrix3d back = Eigen::AngleAxisd(-angle, Vector3::UnitZ()).toRotationMatrix();
    const Noise noise(7);
    Signal values(space_->size(), 3);
    for (int i = 0; i < space_->size(); ++i)
      for (int c = 0; c < 3; ++c)
        values(i, c) = noise(2 * (back * space_->texels().position(i)) + Vector3(31.4, 7.3, 3.7) * c);
    return values;
  }

  std::shared_ptr<const fixtures::Textured> model_;
  std::shared_ptr<const TexelSpace> space_;
  std::vector<Signal> truth_, film_;
};

double distance(const Signal& a, const Signal& b) { return std::sqrt((a - b).squaredNorm() / double(a.size())); }

TEST(FrameDrift, MeansAlongItKeepWhatMeansOfTexelsBlur) {
  const SlidingFilm film(0.7, 7, 0);
  const int middle = 3;
  const double blurred = distance(film.means(3, SlidingFilm::Drift::none)[middle], film.truth(middle));
  const double followed = distance(film.means(3, SlidingFilm::Drift::followed)[middle], film.truth(middle));
  EXPECT_LT(followed, 0.35 * blurred);
}

TEST(FrameDrift, KeepsSharpWhatIsFilteredInTime) {
  const SlidingFilm film(0.7, 7, 0);
  const int middle = 3;
  const double blurred = distance(film.filtered(16, SlidingFilm::Drift::none)[middle], film.truth(middle));
  const double followed = distance(film.filtered(16, SlidingFilm::Drift::followed)[middle], film.truth(middle));
  EXPECT_LT(followed, 0.2 * blurred);
}

TEST(FrameDrift, LeavesAsMuchOfLightAsWithoutIt) {
  const SlidingFilm film(0.7, 6, 0);
  const auto left = [&](SlidingFilm::Drift how) {
    const std::vector<Signal> lit = film.filtered(16, how, 0.2), dark = film.filtered(16, how);
    Vector steps(5);
    for (int f = 0; f < 5; ++f) steps[f] = ((lit[f + 1] - dark[f + 1]) - (lit[f] - dark[f])).mean();
    return steps;
  };
  const Vector followed = left(SlidingFilm::Drift::followed);
  EXPECT_LT((followed - left(SlidingFilm::Drift::none)).cwiseAbs().maxCoeff(), 1e-5);
  EXPECT_LT(followed.cwiseAbs().maxCoeff(), 0.02);  // of 0.2
}

TEST(FrameDrift, TakesNoiseOutOfWhatSlides) {
  const double noise = 0.1;
  const SlidingFilm film(0.7, 7, noise);
  const int middle = 3;
  const Signal mean = film.means(3, SlidingFilm::Drift::followed)[middle];
  EXPECT_LT(distance(mean, film.truth(middle)), 0.55 * distance(film.shown(middle), film.truth(middle)));
}

TEST(FrameDrift, WithoutAFieldMeansAreThoseOfTexels) {
  const SlidingFilm film(0.7, 4, 0.1);
  const auto plain = film.means(2, SlidingFilm::Drift::none), at_rest = film.means(2, SlidingFilm::Drift::at_rest);
  for (std::size_t f = 0; f < plain.size(); ++f) EXPECT_TRUE(plain[f] == at_rest[f]);
  const auto filtered = film.filtered(4, SlidingFilm::Drift::none), rested = film.filtered(4, SlidingFilm::Drift::at_rest);
  for (std::size_t f = 0; f < plain.size(); ++f) EXPECT_TRUE(filtered[f] == rested[f]);
}

TEST(FrameDrift, WhatGoesToTheFrameBeforeComesBack) {
  const std::shared_ptr<const fixtures::Textured> model = fixtures::textured(
      fixtures::cut_torus({.cells = 48, .parts = 2, .jitter = 0, .scale = 0.6, .angle = fixtures::odd_angle}),
      {{128, 128}});
  const TexelSpace space(model->surface, model->atlas);
  FrameDrift drift(model, model->surface, model->atlas, space);
  EXPECT_FALSE(drift.follows());
  EXPECT_TRUE(drift.before(drift.starts()) == drift.starts());
  Signal before(space.size(), 1), after(space.size(), 1);
  for (int i = 0; i < space.size(); ++i) {
    const Vector3& p = space.texels().position(i);
    const double turn = std::atan2(p.y(), p.x());
    before(i, 0) = std::cos(3 * turn), after(i, 0) = std::cos(3 * (turn - 0.02));
  }
  drift.follow(before, after);
  EXPECT_TRUE(drift.follows());
  const std::vector<ChartPlace> there = drift.before(drift.starts()), back = drift.after(there);
  int moved = 0, returned = 0;
  for (std::size_t i = 0; i < back.size(); ++i) {
    if (there[i] == drift.starts()[i]) continue;
    ++moved;
    returned += (drift.texel(back[i]) - drift.texel(drift.starts()[i])).norm() < 1e-6 ? 1 : 0;
  }
  EXPECT_GT(moved, space.size() / 2);
  EXPECT_GT(returned, 0.97 * moved);
}

}  // namespace
}  // namespace mq

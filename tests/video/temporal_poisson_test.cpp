#include "mq/video/temporal_poisson.h"

#include <cmath>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "evolving/evolving_models.h"
#include "fixtures.h"
#include "linear/matrices.h"
#include "mq/base/error.h"
#include "mq/base/random.h"
#include "mq/fem/vertex_space.h"
#include "mq/filter/screened_poisson.h"

namespace mq {
namespace {

using test::random_signal;

/// Frames of one connectivity.
struct Film {
  std::vector<std::shared_ptr<const SignalSpace>> spaces;
  std::vector<Signal> psi;
  std::vector<TimeLinks> links;

  TemporalFrame frame(int f) const { return {spaces[f], nullptr, psi[f], links[f]}; }

  std::vector<Signal> filtered(const TemporalOptions& options,
                               TemporalReport* report = nullptr) const {
    std::vector<Signal> result;
    const TemporalReport found = temporal_poisson(
        int(psi.size()), [&](int f, const Progress&) { return frame(f); },
        [&](int f, const TemporalFrame&, Signal phi) {
          EXPECT_EQ(f, int(result.size()));
          result.push_back(std::move(phi));
        },
        options);
    EXPECT_EQ(result.size(), psi.size());
    if (report) *report = found;
    return result;
  }
};

/// A torus that breathes by `motion` of its size.
Film breathing(int frames, double motion, int channels = 2) {
  Film film;
  for (int f = 0; f < frames; ++f) {
    Mesh mesh = fixtures::torus(16, 10);
    for (Vector3& p : mesh.positions) p.z() *= 1 + motion * std::sin(0.7 * f);
    film.spaces.push_back(std::make_shared<VertexSpace>(make_surface(mesh)));
    const int n = film.spaces.back()->size();
    film.psi.push_back(random_signal(n, channels, f + 1));
    film.links.push_back(f > 0 ? identical_links(n) : TimeLinks());
  }
  return film;
}

constexpr TimeMultigridOptions tight{.tolerance = 1e-13, .max_cycles = 200};

double largest_difference(const Signal& a, const Signal& b) {
  return (a - b).cwiseAbs().maxCoeff();
}

TEST(TemporalPoisson, IsThatOfEachFrameWithoutGamma) {
  const Film film = breathing(5, 0.2);
  const double weight = 0.03;
  const std::vector<Signal> phi =
      film.filtered({.weight = weight, .beta = 0.3, .gamma = 0, .solver = tight});
  for (std::size_t f = 0; f < phi.size(); ++f) {
    const SignalSpace& space = *film.spaces[f];
    const ScreenedPoisson equation(space, weight, std::vector<double>(space.size(), 1.0));
    EXPECT_LE(largest_difference(phi[f], equation.solve(film.psi[f], 0.3).signal), 1e-10);
  }
}

TEST(TemporalPoisson, IsTheStaticEquationOfWhatDoesNotChange) {
  Film film = breathing(9, 0);
  for (Signal& psi : film.psi) psi = film.psi[0];
  const std::vector<Signal> phi =
      film.filtered({.weight = 0.05, .beta = 2, .gamma = 7, .solver = tight});
  const SignalSpace& space = *film.spaces[0];
  const Signal still = ScreenedPoisson(space, 0.05, std::vector<double>(space.size(), 1.0))
                           .solve(film.psi[0], 2)
                           .signal;
  for (const Signal& frame : phi) EXPECT_LE(largest_difference(frame, still), 1e-10);
}

/// (1 + γ·2(1 − cos ω)) of a chain of n with free ends: its eigenvectors are cos(ω(f + ½)).
TEST(TemporalPoisson, SolvesTheChainOfEveryTexelWithoutWeight) {
  const int n = 24, k = 5;
  const double omega = std::numbers::pi * k / n, gamma = 6;
  Film film = breathing(n, 0, 1);
  const Signal pattern = film.psi[0];
  for (int f = 0; f < n; ++f) film.psi[f] = pattern * std::cos(omega * (f + 0.5));
  const std::vector<Signal> phi = film.filtered({.gamma = gamma, .window = n, .solver = tight});
  const double gain = 1 / (1 + gamma * 2 * (1 - std::cos(omega)));
  for (int f = 0; f < n; ++f) EXPECT_LE(largest_difference(phi[f], gain * film.psi[f]), 1e-10);
}

TEST(TemporalPoisson, SatisfiesTheNormalEquationsOfMovingFrames) {
  const Film film = breathing(4, 0.3);
  const double w = 0.02, beta = 1.5, gamma = 3, eta = 0.25;
  const std::vector<Signal> phi =
      film.filtered({.weight = w, .beta = beta, .gamma = gamma, .change = eta, .solver = tight});
  for (int f = 0; f < 4; ++f) {
    const SignalSpace& space = *film.spaces[f];
    const Vector m = space.lumped_mass();
    Signal error = m.asDiagonal() * (phi[f] - film.psi[f]);
    error += w * (space.stiffness() * (phi[f] - beta * film.psi[f]));
    for (const int other : {f - 1, f + 1}) {
      if (other < 0 || other > 3) continue;
      const Vector mean = 0.5 * (m + film.spaces[other]->lumped_mass());
      error += gamma *
               (mean.asDiagonal() * (phi[f] - phi[other] - eta * (film.psi[f] - film.psi[other])));
    }
    EXPECT_LE(error.cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST(TemporalPoisson, GivesBackWhatIsToStayBitForBit) {
  const Film film = breathing(5, 0.2);
  const std::vector<Signal> phi =
      film.filtered({.weight = 0.03, .beta = 1, .gamma = 4, .change = 1});
  for (int f = 0; f < 5; ++f) EXPECT_TRUE(phi[f] == film.psi[f]);
}

/// From the response 1/(1 + γ(2 − 2 cos ω)) and its square, integrated over ω.
TEST(TemporalPoisson, DampsNoiseAndSpreadsImpulsesAsTheirClosedFormsSay) {
  const double gamma = 4;
  const int n = 400;
  Film film = breathing(n, 0, 1);
  for (Signal& psi : film.psi) psi.setZero();
  film.psi[n / 2].setOnes();
  const std::vector<Signal> response =
      film.filtered({.gamma = gamma, .window = n, .solver = tight});
  EXPECT_NEAR(response[n / 2](0, 0), 1 / std::sqrt(1 + 4 * gamma), 1e-6);
  EXPECT_NEAR(response[n / 2 + 3](0, 0) / response[n / 2 + 2](0, 0), decay_in_time(gamma), 1e-6);

  const Random random(3);
  std::uint64_t draw = 0;
  for (Signal& psi : film.psi)
    for (int i = 0; i < psi.rows(); ++i) psi(i, 0) = random.uniform(draw++, -1, 1);
  const std::vector<Signal> phi = film.filtered({.gamma = gamma, .window = n});
  double before = 0, after = 0;
  for (int f = 20; f < n - 20; ++f) {
    before += film.psi[f].squaredNorm();
    after += phi[f].squaredNorm();
  }
  EXPECT_NEAR(after / before / ((1 + 2 * gamma) / std::pow(1 + 4 * gamma, 1.5)), 1, 0.01);
}

TEST(TemporalPoisson, NeedsOnlyAWindowOfFrames) {
  const Film film = breathing(60, 0.2);
  TemporalOptions options{.weight = 0.01, .beta = 0, .gamma = 2, .window = 60, .solver = tight};
  TemporalReport whole, windows;
  const std::vector<Signal> all = film.filtered(options, &whole);
  EXPECT_EQ(whole.windows, 1);
  for (const double accuracy : {1e-1, 1e-3, 1e-6}) {
    options.accuracy = accuracy;
    options.window = 0;
    const std::vector<Signal> streamed = film.filtered(options, &windows);
    EXPECT_EQ(windows.held, std::min(60, 2 * windows.look_ahead + 8));
    double worst = 0, change = 0;
    for (std::size_t f = 0; f < all.size(); ++f) {
      worst = std::max(worst, largest_difference(all[f], streamed[f]));
      change = std::max(change, largest_difference(all[f], film.psi[f]));
    }
    EXPECT_LE(worst, accuracy * change) << accuracy;
    EXPECT_GT(windows.windows, 1);
  }
  options.window = 3;
  EXPECT_THROW(film.filtered(options), InvalidInput);
}

TEST(TemporalPoisson, LetsNothingThroughWherePointsAreBornOrDie) {
  Film film = breathing(6, 0);
  const int n = film.spaces[0]->size();
  film.links[3] = {};  // all born anew
  for (int t = 0; t < n; ++t) film.links[3].starts.push_back(0);
  const TemporalOptions options{.weight = 0.02, .beta = 0, .gamma = 5, .solver = tight};
  const std::vector<Signal> before = film.filtered(options);
  for (int f = 3; f < 6; ++f) film.psi[f] *= -4;
  const std::vector<Signal> after = film.filtered(options);
  for (int f = 0; f < 3; ++f) EXPECT_LE(largest_difference(before[f], after[f]), 1e-11);
  for (int f = 3; f < 6; ++f) EXPECT_LE(largest_difference(-4 * before[f], after[f]), 1e-11);
}

TEST(TemporalPoisson, IsTheSameForAnyNumberOfThreads) {
  const Film film = breathing(12, 0.2);
  const TemporalOptions options{.weight = 0.02, .beta = 0, .gamma = 5};
  std::vector<Signal> first;
  for (const int threads : {1, 2, 7}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const std::vector<Signal> phi = film.filtered(options);
    if (first.empty()) first = phi;
    for (int f = 0; f < 12; ++f) EXPECT_TRUE(phi[f] == first[f]) << threads;
  }
}

TEST(TemporalPoisson, SaysWhatItNeeds) {
  Film film = breathing(2, 0);
  EXPECT_THROW(film.filtered({.weight = -1}), InvalidInput);
  EXPECT_THROW(film.filtered({.gamma = -1}), InvalidInput);
  EXPECT_THROW(film.filtered({.gamma = NAN}), InvalidInput);
  EXPECT_THROW(film.filtered({.accuracy = 0}), InvalidInput);
  film.links[1].entries[0].column = 1000;
  EXPECT_THROW(film.filtered({}), InvalidInput);
}

// ---- The cycle ----

/// A square of one chart, two frames of whose three a chart of another place has.
std::vector<AtlasFrame> rearranged(int frames, int size) {
  std::vector<AtlasFrame> result;
  for (int f = 0; f < frames; ++f) {
    EvolvingSegment segment = grid(8, [] {
      std::vector<int> ids(64);
      for (int i = 0; i < 64; ++i) ids[i] = i;
      return ids;
    }());
    std::vector<Vector3> positions;
    for (int y = 0; y <= 8; ++y)
      for (int x = 0; x <= 8; ++x) {
        positions.emplace_back(x, y, std::sin(0.4 * x + 0.3 * f));
        const Vector2 p(x / 8.0, y / 8.0);
        // Turned by a quarter and moved by no whole texels from the middle on.
        segment.uvs.push_back(f < frames / 2 ? Vector2(0.05 + 0.8 * p.x(), 0.05 + 0.8 * p.y())
                                             : Vector2(0.113 + 0.8 * p.y(), 0.917 - 0.8 * p.x()));
      }
    segment.corner_uvs = segment.triangles;
    result.emplace_back(segment, positions, size, size);
  }
  return result;
}

TEST(TexelLinks, FindPlacesInChartsThatMoved) {
  const std::vector<AtlasFrame> frames = rearranged(4, 64);
  const auto values = [&](int f) {  // linear over the square in both charts
    const Texels& texels = frames[f].space().texels();
    Signal signal(texels.size(), 2);
    for (int t = 0; t < texels.size(); ++t) {
      const double u = (texels.places[t].x + 0.5) / 64, v = 1 - (texels.places[t].y + 0.5) / 64;
      const Vector2 p = f < 2 ? Vector2((u - 0.05) / 0.8, (v - 0.05) / 0.8)
                              : Vector2((0.917 - v) / 0.8, (u - 0.113) / 0.8);
      signal.row(t) = p.transpose();
    }
    return signal;
  };
  for (int f = 1; f < 4; ++f) {
    const TimeLinks links = texel_links(frames[f - 1], frames[f]);
    const Signal before = values(f - 1), after = values(f);
    int linked = 0;
    for (int t = 0; t < links.rows(); ++t) {
      if (!links.linked(t)) continue;
      ++linked;
      Eigen::RowVectorXd was = Eigen::RowVectorXd::Zero(2);
      for (int e = links.starts[t]; e < links.starts[t + 1]; ++e)
        was += links.entries[e].weight * before.row(links.entries[e].column);
      EXPECT_LE((was - after.row(t)).cwiseAbs().maxCoeff(), 1e-9);
      EXPECT_EQ(links.same(t) >= 0, f != 2);
    }
    EXPECT_GE(linked, 50 * 50);
  }
}

/// A texel within a chart hangs on a place where the frame before has the kernel of one at a corner, which shows a
/// thousandth of a texel: to make up for a difference of 1 that one would have to be more than 1.
TEST(TemporalPoisson, LetsTexelsAtBordersFollow) {
  const std::vector<AtlasFrame> frames = rearranged(2, 24);
  const auto space = std::shared_ptr<const SignalSpace>(std::shared_ptr<const SignalSpace>(), &frames[0].space());
  const int n = space->size();
  const Vector m = space->lumped_mass();
  const SparseMatrix S = space->stiffness();
  int corner = 0, inner = 0;
  m.minCoeff(&corner);
  for (SparseMatrix::InnerIterator entry(S, corner); entry; ++entry)
    if (m[entry.col()] > m[inner]) inner = int(entry.col());
  TimeLinks links;
  for (int t = 0; t < n; ++t) {
    if (t == inner) links.entries.insert(links.entries.end(), {{inner, 0.8}, {corner, 0.2}});
    if (t != inner && t != corner) links.entries.push_back({t, 1.0});
    links.starts.push_back(int(links.entries.size()));
  }
  Film film{{space, space}, {Signal::Zero(n, 1), Signal::Zero(n, 1)}, {TimeLinks(), links}};
  film.psi[1](inner, 0) = 1;
  const std::vector<Signal> phi = film.filtered({.weight = 1e-5, .gamma = 16, .solver = tight});
  EXPECT_GE(phi[0].minCoeff(), -0.1);
  EXPECT_LE(phi[0].maxCoeff(), 1);
  EXPECT_NEAR(phi[1](corner, 0), phi[1](inner, 0) - 1, 1e-12);
  // By squares alone:
  SparseMatrix K = space->regularised_system(0, 1e-5);
  K.diagonal() += m;
  const TimeMultigrid squares({{K, {}, {}}, {K, links, 16 * m}}, factored_planes(), tight);
  Signal b = Signal::Zero(2 * n, 1), delta = b;
  b(n + inner, 0) = -16 * m[inner];
  b(inner, 0) = 0.8 * 16 * m[inner];
  b(corner, 0) = 0.2 * 16 * m[inner];
  squares.solve(b, delta);
  EXPECT_GT(delta(corner, 0), 1.2);
  EXPECT_EQ(phi[0](corner, 0), phi[0](inner, 0));
}

/// Half of a torus is new in a frame and gone in the next, which is lighter than the others.
TEST(TemporalPoisson, SpreadsChangesSmoothlyOverSurfaceThatIsNew) {
  Film film = breathing(5, 0, 1);
  const int n = film.spaces[0]->size();
  for (int f = 0; f < 5; ++f) film.psi[f].setConstant(f == 2 ? 1 : 0);
  TimeLinks half;
  for (int t = 0; t < n; ++t) {
    if (t >= n / 2) half.entries.push_back({t, 1.0});
    half.starts.push_back(int(half.entries.size()));
  }
  film.links[2] = film.links[3] = half;
  const Signal phi = film.filtered({.weight = 1e-4, .gamma = 4, .solver = tight})[2];
  EXPECT_LT(phi(n - 1, 0), 0.5);
  EXPECT_GT(phi.maxCoeff(), phi(n - 1, 0) + 0.1);
  const SparseMatrix S = film.spaces[2]->stiffness();
  double step = 0;
  for (int i = 0; i < n; ++i)
    for (SparseMatrix::InnerIterator entry(S, i); entry; ++entry)
      step = std::max(step, std::abs(phi(i, 0) - phi(entry.col(), 0)));
  EXPECT_LT(step, 0.3);  // 0.7 without
}

/// By how much a cycle, without acceleration, reduces the residual in the end.
double factor(const TimeMultigrid& system) {
  Signal x = random_signal(int(system.matrix().rows()), 1), z;
  double worst = 0;
  const double first = (system.matrix() * x).norm();
  for (double before = first, after = 0; before > 1e-9 * first; before = after) {
    const Signal r = -(system.matrix() * x);
    system.cycle(r, z);
    x += z;
    after = (system.matrix() * x).norm();
    worst = std::max(worst, after / before);
    if (after > first) break;
  }
  return worst;
}

TEST(TimeMultigrid, ConvergesAlikeForEveryGammaAndWeight) {
  const Film film = breathing(33, 0.1);
  for (const double weight : {0.0, 1e-3, 0.1})
    for (const double gamma : {0.1, 1.0, 10.0, 100.0, 1e4}) {
      std::vector<TimePlane> planes;
      for (int f = 0; f < 33; ++f) {
        const Vector m = film.spaces[f]->lumped_mass();
        SparseMatrix K = film.spaces[f]->system(0, weight);
        K.diagonal() += m;
        planes.push_back({K, film.links[f], gamma * m});
      }
      const double found = factor(TimeMultigrid(planes, factored_planes()));
      EXPECT_LE(found, 0.12) << weight << " " << gamma;
    }
}

TEST(TimeMultigrid, IsSymmetricAndContracts) {
  std::vector<AtlasFrame> frames = rearranged(7, 24);
  std::vector<TimePlane> planes;
  for (int f = 0; f < 7; ++f) {
    const TexelSpace& space = frames[f].space();
    const Vector m = space.lumped_mass().cwiseMax(1e-12);
    SparseMatrix K = space.regularised_system(0, 0.05);
    K.diagonal() += m;
    planes.push_back({K, f > 0 ? texel_links(frames[f - 1], frames[f]) : TimeLinks(), 5 * m});
  }
  const TimeMultigrid system(planes, factored_planes());
  const int n = int(system.matrix().rows());
  const Signal a = random_signal(n, 1, 1), b = random_signal(n, 1, 2);
  Signal Ca, Cb;
  system.cycle(a, Ca);
  system.cycle(b, Cb);
  EXPECT_NEAR(a.cwiseProduct(Cb).sum(), b.cwiseProduct(Ca).sum(), 1e-9 * a.norm() * Cb.norm());
  EXPECT_LE((system.matrix() - SparseMatrix(system.matrix().transpose())).norm(), 1e-12);
  EXPECT_LE(factor(system), 0.5);
}

}  // namespace
}  // namespace mq

#include "mq/filter/shock.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "fixtures.h"

namespace mq {
namespace {

using namespace fixtures;

/// A mesh with what a filter needs of it.
struct Case {
  explicit Case(const Mesh& m) : surface(make_surface(m)), mesh(surface), space(surface) {}
  Surface surface;
  TraceMesh mesh;
  VertexSpace space;

  Signal signal(const auto& value, int channels = 1) const {
    Signal phi(space.size(), channels);
    for (int v = 0; v < space.size(); ++v)
      for (int c = 0; c < channels; ++c) phi(v, c) = (1 + c) * value(surface.mesh.positions[v]);
    return phi;
  }
  Shocked shock(const Signal& phi, double tau, const ShockWeights& weights = {1e-4, 1e-4}) const {
    const double area = space.scale().area;
    return transport_shock(mesh, space, phi, {weights.signal * area, weights.potential * area},
                           {ShockTime::Unit::relative, tau});
  }
};

double blurred_step(double x) { return 0.5 + 0.5 * std::tanh(4 * x); }

double step_over_z(const Vector3& p) { return blurred_step(p.z()); }

TEST(Shock, SharpensAStepOnASphereAsSymmetricallyAsItsMesh) {
  const Case sphere_case(sphere(6));
  const Signal phi = sphere_case.signal(step_over_z);
  const Shocked shocked = sphere_case.shock(phi, 3);
  double inside = 0, outside = 0;
  int near_equator = 0, far = 0;
  for (int v = 0; v < sphere_case.space.size(); ++v) {
    const double z = sphere_case.surface.mesh.positions[v].z(), value = shocked.signal(v, 0);
    // 1 − φ(−z) = φ(z), and the step is steeper than it was: values lie further out.
    if (std::abs(z) < 0.05) continue;
    EXPECT_EQ(value > 0.5, z > 0);
    EXPECT_GE(std::abs(value - 0.5), std::abs(phi(v, 0) - 0.5) - 0.02);
    if (std::abs(z) < 0.15) {
      inside += std::abs(value - 0.5);
      outside += std::abs(phi(v, 0) - 0.5);
      ++near_equator;
    } else {
      far += std::abs(value - 0.5) > 0.45;
    }
  }
  ASSERT_GT(near_equator, 100);
  EXPECT_GT(inside, 1.5 * outside);
  EXPECT_GT(far, 5000);
}

TEST(Shock, IsAsRoundAsTheSphere) {
  // A signal of the latitude stays one: its spread along a circle is far below its change.
  const Case sphere_case(sphere(7));
  const Signal phi = sphere_case.signal(step_over_z);
  const Shocked shocked = sphere_case.shock(phi, 1);
  std::map<int, std::pair<double, double>> bands;
  double change = 0;
  for (int v = 0; v < sphere_case.space.size(); ++v) {
    const double z = sphere_case.surface.mesh.positions[v].z(), value = shocked.signal(v, 0);
    change = std::max(change, std::abs(value - phi(v, 0)));
    if (std::abs(z) < 0.08) continue;
    const auto [band, fresh] = bands.try_emplace(int(std::floor(100 * z)), value, value);
    band->second.first = std::min(band->second.first, value);
    band->second.second = std::max(band->second.second, value);
  }
  EXPECT_GT(change, 0.2);
  for (const auto& [z, range] : bands) {
    const double within = std::abs(blurred_step(0.01 * z + 0.01) - blurred_step(0.01 * z));
    EXPECT_LT(range.second - range.first, 2 * within + 0.01) << z;
  }
}

TEST(Shock, KeepsAMonotoneRampMonotone) {
  // On the thesis' line: a strip whose signal depends on x alone.
  Mesh strip = flat_square(64);
  for (Vector3& p : strip.positions) p.y() *= 0.05;
  const Case line(strip);
  const Signal phi = line.signal([](const Vector3& p) { return blurred_step(4 * (p.x() - 0.4)); });
  for (const double tau : {0.3, 1.0, 10.0, 1e6}) {
    const Signal after = line.shock(phi, tau, {0, 0}).signal;
    for (int j = 0; j <= 64; j += 16)
      for (int i = 0; i < 64; ++i)
        EXPECT_LE(after(j * 65 + i, 0), after(j * 65 + i + 1, 0) + 1e-12) << tau;
    EXPECT_LE(after.maxCoeff(), phi.maxCoeff());
    EXPECT_GE(after.minCoeff(), phi.minCoeff());
  }
}

TEST(Shock, NeverLeavesTheRangeAndKeepsMinimaOfThePotential) {
  const Case torus_case(torus(80, 40));
  const Random random(4);
  Signal phi = torus_case.signal([](const Vector3& p) { return std::sin(4 * p.x()) + p.y(); }, 3);
  for (int i = 0; i < phi.size(); ++i) phi.data()[i] += random.uniform(std::uint64_t(i), -0.3, 0.3);
  for (const double tau : {0.1, 1.0, 10.0, 1e3, 1e6}) {
    const Shocked shocked = torus_case.shock(phi, tau);
    EXPECT_EQ(shocked.counts.cut_short, 0);
    for (int c = 0; c < 3; ++c) {
      EXPECT_LE(shocked.signal.col(c).maxCoeff(), phi.col(c).maxCoeff());
      EXPECT_GE(shocked.signal.col(c).minCoeff(), phi.col(c).minCoeff());
    }
    int minima = 0;
    for (int v = 0; v < torus_case.space.size(); ++v) {
      bool minimum = true;
      for (const Triangle& t : torus_case.surface.mesh.triangles)
        if (std::ranges::count(t, v))
          for (const int other : t) minimum &= shocked.potential[other] >= shocked.potential[v];
      if (!minimum) continue;
      ++minima;
      EXPECT_EQ(shocked.signal.row(v), phi.row(v));
    }
    EXPECT_GT(minima, 5);
  }
}

TEST(Shock, LeavesAConstantAlone) {
  const Case sphere_case(sphere(3));
  const Signal phi = Signal::Constant(sphere_case.space.size(), 2, 0.3);
  const Shocked shocked = sphere_case.shock(phi, 1e6);
  EXPECT_EQ(shocked.signal, phi);
  const Shocked plain = sphere_case.shock(phi, 1e6, {0, 0});
  EXPECT_EQ(plain.rate, 0);
  EXPECT_EQ(plain.signal, phi);
}

TEST(Shock, DoesNotDependOnTheSizeOfValuesOrSurface) {
  const Case small(sphere(5));
  // No symmetry: on a ridge of the potential between equal slopes rounding would decide.
  const Signal phi = small.signal([](const Vector3& p) {
    return blurred_step(p.z() + 0.13 * p.x() + 0.07 * std::sin(3 * p.y() + 1) - 0.05);
  });
  const Signal expected = small.shock(phi, 2).signal;
  EXPECT_EQ(small.shock(4 * phi, 2).signal / 4, expected);
  for (const double c : {0.37, 255.0, 1e-3})
    EXPECT_LT((small.shock(c * phi, 2).signal / c - expected).cwiseAbs().maxCoeff(), 1e-9) << c;
  Mesh scaled = sphere(5);
  for (Vector3& p : scaled.positions) p *= 1234.5;
  EXPECT_LT((Case(scaled).shock(phi, 2).signal - expected).cwiseAbs().maxCoeff(), 1e-9);
  // And so for the thesis' own time, with t → t/c².
  const auto own = [&](const Case& on, double factor, double time) {
    const double w = 1e-4 * on.space.scale().area;
    return Signal(
        transport_shock(on.mesh, on.space, factor * phi, {w, w}, {ShockTime::Unit::absolute, time})
            .signal /
        factor);
  };
  const Signal by_area = own(small, 1, 0.1);
  EXPECT_GT((by_area - phi).cwiseAbs().maxCoeff(), 0.01);
  EXPECT_LT((own(small, 3, 0.1 / 9) - by_area).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((own(Case(scaled), 1, 0.1) - by_area).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(Shock, DependsOnTheSurfaceAndNotOnItsTriangles) {
  // The same flat square, triangulated otherwise, and rolled up: the same signal to the order of h.
  const auto value = [](const Vector3& p) {
    return blurred_step(2 * std::hypot(p.x() - 0.45, p.y() - 0.5) - 0.6);
  };
  double differences[2];
  for (const int i : {0, 1}) {
    const int n = i ? 96 : 48;
    const Case regular(flat_square(n)), jittered(flat_square(n, 0.24));
    const Shocked first = regular.shock(regular.signal(value), 2, {1e-3, 1e-3});
    const Shocked second = jittered.shock(jittered.signal(value), 2, {1e-3, 1e-3});
    EXPECT_NEAR(first.rate, second.rate, 0.05 * first.rate);
    differences[i] = (first.signal - second.signal).cwiseAbs().mean();
    Mesh rolled = flat_square(n, 0.24);
    for (Vector3& p : rolled.positions) p = {std::sin(p.x()), p.y(), std::cos(p.x())};
    const Case bent(rolled);
    const Signal there = bent.shock(jittered.signal(value), 2, {1e-3, 1e-3}).signal;
    EXPECT_LT((there - second.signal).cwiseAbs().mean(), 3e-3);
  }
  EXPECT_LT(differences[1], 0.01);
  EXPECT_LT(differences[1], 0.7 * differences[0]);
}

TEST(PotentialRate, IsTheRootMeanSquareOfTheHessian) {
  // P = sin 2πx on the flat torus of a torus' parameters: |Hess P| = 4π² |sin|, rms 4π²/√2.
  const Case square(flat_square(128, 0.1));
  Vector P(square.space.size());
  // cos 2πx · cos 2πy has no flux through the boundary; ΔP = −8π²P, whose rms is 8π²/2.
  for (int v = 0; v < P.size(); ++v) {
    const Vector3& p = square.surface.mesh.positions[v];
    P[v] = std::cos(2 * std::numbers::pi * p.x()) * std::cos(2 * std::numbers::pi * p.y());
  }
  const double expected = 4 * std::numbers::pi * std::numbers::pi;
  EXPECT_NEAR(potential_rate(square.space, P), expected, 0.03 * expected);
}

/// ½ of the mean of the squared slopes around: of a ramp constant, and of ½kx² at x = ih, where the triangles left and
/// right of a vertex have the slopes kh(i ∓ ½), ½k²h²(i² + ¼).
TEST(ShockPotential, HasItsClosedFormOnRampsAndParabolas) {
  const int n = 16;
  const Case square(flat_square(n, 0));
  const double h = 1.0 / n, k = 3;
  const Vector ramp = shock_potential(
      square.space, square.signal([](const Vector3& p) { return 0.3 * p.x() - 0.4 * p.y(); }, 2), {});
  for (const double P : ramp) EXPECT_NEAR(P, 0.5 * 0.25 * (1 + 4), 1e-12);
  const Vector parabola =
      shock_potential(square.space, square.signal([&](const Vector3& p) { return 0.5 * k * p.x() * p.x(); }), {});
  int inner = 0;
  for (int v = 0; v < square.space.size(); ++v) {
    const Vector3& p = square.surface.mesh.positions[std::size_t(v)];
    if (std::min({p.x(), p.y(), 1 - p.x(), 1 - p.y()}) < 0.5 * h) continue;
    EXPECT_NEAR(parabola[v], 0.5 * k * k * (p.x() * p.x() + h * h / 4), 1e-12);
    ++inner;
  }
  EXPECT_EQ(inner, (n - 1) * (n - 1));
}

}  // namespace
}  // namespace mq

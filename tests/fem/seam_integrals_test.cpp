// Mass and stiffness beside a seam against integrals that share nothing with the library but the corners of the charts:
// two unit squares side by side, each a rectangle of the texture along its axes, so that functions are polynomials of the
// places on the squares between lines that are known, and a product rule in long double is exact.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "fem/cut_squares.h"
#include "fem/reference_integrals.h"
#include "mq/atlas/seams.h"
#include "mq/fem/texel_space.h"

namespace mq {
namespace {

using fixtures::Real;

/// Corner of the texture where a square begins, and its sides along s (away from the left end) and t, in texels.
struct Placed {
  Vector2 origin, along_s, along_t;
};

constexpr int texture_size = 64;

/// Squares 0 (s from 0 to 1) and 1 (s from 1 to 2), joined at s = 1.
Mesh two_squares(const std::array<Placed, 2>& placed) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 1, 0}};
  for (int k = 0; k < 2; ++k) {
    for (const auto& [s, t] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}})
      mesh.uvs.push_back((placed[std::size_t(k)].origin + s * placed[std::size_t(k)].along_s + t * placed[std::size_t(k)].along_t) / texture_size);
    mesh.triangles.push_back({k, k + 1, k + 4});
    mesh.triangles.push_back({k, k + 4, k + 3});
    mesh.corner_uvs.push_back({4 * k, 4 * k + 1, 4 * k + 2});
    mesh.corner_uvs.push_back({4 * k, 4 * k + 2, 4 * k + 3});
  }
  return mesh;
}

/// A square's place in texels, counted from the centre of texel (0, 0): o + s a + t b.
struct Frame {
  std::array<Real, 2> o, a, b;

  Frame(const Atlas& atlas, int square) {
    const fixtures::RealPolygon first = fixtures::corners_of(atlas, 2 * square), second = fixtures::corners_of(atlas, 2 * square + 1);
    for (int d = 0; d < 2; ++d) o[d] = first[0][d], a[d] = first[1][d] - first[0][d], b[d] = second[2][d] - first[0][d];
  }
  Real at(int d, Real s, Real t) const { return o[d] + s * a[d] + t * b[d]; }
  Real length() const { return std::hypot(a[0], a[1]); }
};

/// Where a coordinate of a frame that runs along one of s and t crosses texel lines.
void add_lines(const Frame& frame, const std::array<Real, 2>& along, std::set<Real>& cuts) {
  for (int d = 0; d < 2; ++d) {
    if (along[d] == 0) continue;
    const Real from = frame.o[d], to = frame.o[d] + along[d];
    for (Real line = std::ceil(std::min(from, to)); line <= std::max(from, to); ++line) cuts.insert((line - from) / along[d]);
  }
}

/// Value and derivatives by s and t, per texel.
using Functions = std::map<std::array<int, 2>, std::array<Real, 3>>;

/// Adds factor · B of a frame at (s, t), in the cell that the point (near_s, near_t) lies in; what a part does not move by
/// has no derivative.
void add_bilinear(const Frame& frame, Real s, Real t, Real near_s, Real near_t, std::array<Real, 3> factor, Functions& functions) {
  std::array<int, 2> cell;
  std::array<Real, 2> x;
  for (int d = 0; d < 2; ++d) {
    cell[d] = int(std::floor(frame.at(d, near_s, near_t)));
    x[d] = frame.at(d, s, t) - cell[d];
  }
  for (int k = 0; k < 4; ++k) {
    const int i = k & 1, j = k >> 1;
    const Real wx = i ? x[0] : 1 - x[0], wy = j ? x[1] : 1 - x[1], dx = (i ? 1 : -1) * wy, dy = (j ? 1 : -1) * wx;
    std::array<Real, 3>& sum = functions[{cell[0] + i, cell[1] + j}];
    const Real value = wx * wy;
    // factor = (f, ∂f/∂s, whether s moves the place): along the seam it does not.
    sum[0] += factor[0] * value;
    sum[1] += factor[1] * value + factor[2] * factor[0] * (dx * frame.a[0] + dy * frame.a[1]);
    sum[2] += factor[0] * (dx * frame.b[0] + dy * frame.b[1]);
  }
}

/// φ of all texels at (s, t) of a square, both from 0 to 1: B, and within η of the seam, where s is `end`, λ (σ − B) more.
Functions functions_at(const std::array<Frame, 2>& frames, int square, Real s, Real t, Real near_s, Real near_t) {
  constexpr Real eta = Real(Seams::blend);
  const Frame& own = frames[std::size_t(square)];
  const Frame& other = frames[std::size_t(1 - square)];
  const Real end = square == 0 ? 1 : 0;
  const auto inside = [&](Real at) { return at + (square == 0 ? -1 : 1) * Real(1e-9); };
  Functions functions;
  add_bilinear(own, s, t, near_s, near_t, {1, 0, 1}, functions);
  const Real lambda = 1 - std::abs(end - s) * own.length() / eta;
  if (1 - std::abs(end - near_s) * own.length() / eta <= 0) return functions;
  const Real slope = (square == 0 ? 1 : -1) * own.length() / eta;
  add_bilinear(own, end, t, inside(end), near_t, {-lambda / 2, -slope / 2, 0}, functions);
  const Real opposite = 1 - end;
  add_bilinear(other, opposite, t, opposite + (square == 0 ? 1 : -1) * Real(1e-9), near_t, {lambda / 2, slope / 2, 0}, functions);
  return functions;
}

struct Integrals {
  Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic> mass, stiffness;
};

Integrals integrals_of(const Atlas& atlas, const Texels& texels) {
  const std::array<Frame, 2> frames{Frame(atlas, 0), Frame(atlas, 1)};
  std::map<std::array<int, 2>, int> number;
  for (int i = 0; i < texels.size(); ++i) number[{texels.places[std::size_t(i)].x, texels.places[std::size_t(i)].y}] = i;
  Integrals sum;
  sum.mass.setZero(texels.size(), texels.size());
  sum.stiffness.setZero(texels.size(), texels.size());
  for (int square = 0; square < 2; ++square) {
    const Frame& own = frames[std::size_t(square)];
    std::set<Real> in_s{0, 1}, in_t{0, 1};
    add_lines(own, own.a, in_s);
    in_s.insert(square == 0 ? 1 - Real(Seams::blend) / own.length() : Real(Seams::blend) / own.length());
    for (const Frame& frame : frames) add_lines(frame, frame.b, in_t);
    for (auto s = in_s.begin(); std::next(s) != in_s.end(); ++s)
      for (auto t = in_t.begin(); std::next(t) != in_t.end(); ++t) {
        const Real s0 = *s, s1 = *std::next(s), t0 = *t, t1 = *std::next(t);
        fixtures::for_each_gauss_point({{s0, t0}, {s1, t0}, {s1, t1}, {s0, t1}}, [&](Real x, Real y, Real weight) {
          const Functions functions = functions_at(frames, square, x, y, (s0 + s1) / 2, (t0 + t1) / 2);
          for (const auto& [p, f] : functions)
            for (const auto& [q, g] : functions) {
              if (!number.contains(p) || !number.contains(q)) continue;
              sum.mass(number.at(p), number.at(q)) += weight * f[0] * g[0];
              sum.stiffness(number.at(p), number.at(q)) += weight * (f[1] * g[1] + f[2] * g[2]);
            }
        });
      }
  }
  return sum;
}

struct Mismatch {
  double mass = 0, stiffness = 0;  ///< largest, of the largest entry
};

/// By how much the library's matrices differ from those above.
Mismatch mismatch(const Placed& right) {
  const Placed left{{3.3, 40.2}, {17.4, 0}, {0, 15.7}};
  const auto model = fixtures::textured(two_squares({left, right}), {{texture_size, texture_size}});
  const TexelSpace space(model->surface, model->atlas);
  const Integrals expected = integrals_of(model->atlas, space.texels());
  EXPECT_NEAR(double(expected.mass.sum()), 2, 1e-12);
  const Eigen::MatrixXd M = space.mass(), S = space.stiffness();
  int over_the_seam = 0;
  for (int i = 0; i < space.size(); ++i)
    for (int j = 0; j < space.size(); ++j)
      over_the_seam += S(i, j) != 0 && space.texels().chart[std::size_t(i)] != space.texels().chart[std::size_t(j)];
  EXPECT_GT(over_the_seam, 100);
  return {(M - expected.mass.cast<double>()).cwiseAbs().maxCoeff() / M.cwiseAbs().maxCoeff(),
          (S - expected.stiffness.cast<double>()).cwiseAbs().maxCoeff() / S.cwiseAbs().maxCoeff()};
}

/// Where texel lines of both sides meet the seam in the same places: functions are polynomials of degree 2 on the pieces
/// that are integrated, and the rule is exact. The second square is as long along the seam, turned by a half, or mirrored;
/// across it as long as one likes.
TEST(SeamIntegrals, AreThoseOfTheFunctionsWhereTexelLinesMeet) {
  for (const Placed& right : {Placed{{25.37, 40.2}, {23.6, 0}, {0, 15.7}}, Placed{{60.61, 30.8}, {-19.2, 0}, {0, -15.7}},
                              Placed{{50.11, 12.2}, {-20.3, 0}, {0, 15.7}}}) {
    const Mismatch found = mismatch(right);
    EXPECT_LT(found.mass, 1e-12);
    EXPECT_LT(found.stiffness, 1e-11);
  }
}

/// Elsewhere functions bend inside of pieces, within a quarter of a texel of the seam, and the rule there is the definition:
/// it differs by less than half a percent of the largest entry.
TEST(SeamIntegrals, AreNearlyThoseOfTheFunctionsWhereTexelLinesDoNotMeet) {
  for (const Placed& right : {Placed{{25.37, 33.9}, {23.6, 0}, {0, 26.3}}, Placed{{60.61, 8.13}, {0, 19.2}, {-21.45, 0}},
                              Placed{{50.11, 5.77}, {-20.3, 0}, {0, 18.9}}}) {
    const Mismatch found = mismatch(right);
    EXPECT_LT(found.mass, 0.001);
    EXPECT_LT(found.stiffness, 0.005);
  }
}

}  // namespace
}  // namespace mq

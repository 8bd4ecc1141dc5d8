// Orders of convergence of the texel space against solutions known in closed form, with atlases cut
// in different ways, charts slanted, and textures of unequal sides: on the square with free border,
// on a torus and a sphere whose meshes are refined with their textures, and on the flat torus, which
// is a torus in space with the metric of the square.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fem/cut_squares.h"
#include "mq/filter/screened_poisson.h"
#include "mq/linear/direct.h"
#include "mq/mesh/closest_point.h"

namespace mq {
namespace {

using fixtures::CutOptions;
using fixtures::Textured;

using std::numbers::pi;

/// The textures of a case: `texels` of them along a side of the square that is cut, whatever the
/// scale of its charts; 3 : 5 where the case says so.
struct Case {
  std::string name;
  CutOptions options;
  bool oblong = false;

  TextureSize size(int texels) const {
    const int side = int(std::lround(texels / options.scale));
    return oblong ? TextureSize{side, side * 5 / 3} : TextureSize{side, side};
  }
};

CutOptions cut_in(int parts, int parts_up, int cells) {
  CutOptions options;
  options.parts = parts;
  options.parts_up = parts_up;
  options.cells = cells;
  options.jitter = 0.15;
  const bool whole = parts * parts_up == 1;
  options.scale = whole ? 0.9 : 0.6;
  if (!whole) options.angle = fixtures::odd_angle;
  return options;
}

/// 1, 4 and 28 charts, and 4 of them stretched and sheared each in its own direction.
std::vector<Case> cases(int cells = 0) {
  std::vector<Case> all = {{"1 chart", cut_in(1, 1, cells ? cells : 10)},
                           {"4 charts", cut_in(2, 2, cells ? cells : 10)},
                           {"28 charts", cut_in(4, 7, cells ? cells : 28)},
                           {"4 slanted charts, oblong", cut_in(2, 2, cells ? cells : 10), true}};
  all[2].options.scale = 0.45;
  all[3].options.shape = fixtures::sheared;
  all[3].options.scale = 0.5;
  return all;
}

// --------------------------------------------------------------------------- manufactured solutions

/// A function on a surface, continued to the space around it, with the right-hand side that has it
/// as its solution: φ − wΔφ = f.
struct Manufactured {
  double w;
  std::function<double(const Vector3&)> value;
  std::function<Vector3(const Vector3&)> gradient;
  std::function<double(const Vector3&)> right_hand_side;
};

/// Errors in L² and in the H¹ seminorm, on the polyhedron that the surface is approximated by.
std::pair<double, double> errors(const Mesh& mesh, const TextureSize& size, const Manufactured& exact) {
  const auto model = fixtures::textured(mesh, {size});
  const TexelSpace space(model->surface, model->atlas);
  EXPECT_FALSE(fixtures::shares_texels(space));
  const auto density = [&](int t) { return texel_metric(model->surface, model->atlas, t).density; };
  Signal b = Signal::Zero(space.size(), 1);
  space.for_each_piece([&](const TexelSamples& s) {
    for (Eigen::Index q = 0; q < s.weights.size(); ++q) {
      const Vector3 p = fixtures::on_surface(mesh, s.triangle, s.barycentric.row(q).transpose());
      const double f = s.weights[q] * density(s.triangle) * exact.right_hand_side(p);
      for (std::size_t k = 0; k < s.texels.size(); ++k) b(s.texels[k], 0) += f * s.values(q, k);
    }
  });
  const Signal phi = DirectSolver(space.system(1, exact.w)).solve(b);
  double l2 = 0, h1 = 0;
  space.for_each_piece([&](const TexelSamples& s) {
    const int t = s.triangle;
    const TexelMetric m = texel_metric(model->surface, model->atlas, t);
    const auto& c = model->atlas.corners[t];
    Eigen::Matrix2d texel;
    Eigen::Matrix<double, 3, 2> edges;
    for (int k = 0; k < 2; ++k) {
      texel.col(k) << c[k + 1].column() - c[0].column(), c[k + 1].row() - c[0].row();
      edges.col(k) = mesh.position(t, k + 1) - mesh.position(t, 0);
    }
    const Eigen::Matrix<double, 3, 2> J = edges * texel.inverse();
    for (Eigen::Index q = 0; q < s.weights.size(); ++q) {
      const Vector3 p = fixtures::on_surface(mesh, t, s.barycentric.row(q).transpose());
      double value = -exact.value(p);
      Vector2 slope = -J.transpose() * exact.gradient(p);
      for (std::size_t k = 0; k < s.texels.size(); ++k) {
        value += s.values(q, k) * phi(s.texels[k], 0);
        slope += Vector2(s.dx(q, k), s.dy(q, k)) * phi(s.texels[k], 0);
      }
      l2 += s.weights[q] * m.density * value * value;
      h1 += s.weights[q] * (m.a * slope.x() * slope.x() + 2 * m.b * slope.x() * slope.y() +
                            m.c * slope.y() * slope.y());
    }
  });
  return {std::sqrt(l2), std::sqrt(h1)};
}

void expect_orders(const std::string& name, const std::pair<double, double>& coarse,
                   const std::pair<double, double>& fine, double refinement) {
  const auto order = [&](double a, double b) { return std::log(a / b) / std::log(refinement); };
  EXPECT_GE(order(coarse.first, fine.first), 1.8) << name << ' ' << coarse.first << ' ' << fine.first;
  EXPECT_GE(order(coarse.second, fine.second), 0.9) << name << ' ' << coarse.second << ' ' << fine.second;
}

TEST(TexelConvergence, IsOfOrderTwoInValuesAndOneInGradientsHoweverTheSquareIsCut) {
  const double w = 0.05;
  const Manufactured cosines{
      w, [](const Vector3& p) { return std::cos(pi * p.x()) * std::cos(pi * p.y()); },
      [](const Vector3& p) {
        return Vector3(-pi * std::sin(pi * p.x()) * std::cos(pi * p.y()),
                       -pi * std::cos(pi * p.x()) * std::sin(pi * p.y()), 0);
      },
      [=](const Vector3& p) {
        return (1 + 2 * pi * pi * w) * std::cos(pi * p.x()) * std::cos(pi * p.y());
      }};
  for (const Case& c : cases()) {
    const Mesh mesh = fixtures::cut_square(c.options);
    expect_orders(c.name, errors(mesh, c.size(48), cosines), errors(mesh, c.size(144), cosines), 3);
  }
}

/// In the angles u around the axis and v around the tube of a torus with radii 1 and r,
///     Δφ = φ_uu / ρ² + φ_vv / r² − sin v φ_v / (r ρ),   ρ = 1 + r cos v;
/// φ = cos u + cos u sin v.
Manufactured on_torus(double r, double w) {
  struct Angles {
    double u, v, rho;
  };
  const auto angles = [](const Vector3& p) {
    const double rho = std::hypot(p.x(), p.y());
    return Angles{std::atan2(p.y(), p.x()), std::atan2(p.z(), rho - 1), rho};
  };
  const auto value = [=](const Vector3& p) {
    const Angles a = angles(p);
    return std::cos(a.u) * (1 + std::sin(a.v));
  };
  const auto gradient = [=](const Vector3& p) -> Vector3 {
    const Angles a = angles(p);
    const double d = a.rho - 1, square = d * d + p.z() * p.z();
    const Vector3 out(std::cos(a.u), std::sin(a.u), 0), up(0, 0, 1);
    const Vector3 of_u = Vector3(-std::sin(a.u), std::cos(a.u), 0) / a.rho;
    const Vector3 of_v = (d * up - p.z() * out) / square;
    return -std::sin(a.u) * (1 + std::sin(a.v)) * of_u + std::cos(a.u) * std::cos(a.v) * of_v;
  };
  const auto laplacian = [=](const Vector3& p) {
    const Angles a = angles(p);
    const double rho = 1 + r * std::cos(a.v), c = std::cos(a.u), s = std::sin(a.v);
    return -c * (1 + s) / (rho * rho) - c * s / (r * r) - s * c * std::cos(a.v) / (r * rho);
  };
  return {w, value, gradient, [=](const Vector3& p) { return value(p) - w * laplacian(p); }};
}

TEST(TexelConvergence, IsOfOrderTwoAndOneOnATorus) {
  const double r = 0.4;
  for (Case c : cases(14)) {
    if (c.options.parts == 4) c.options.cells = 28;
    const auto at = [&](int refinement) {
      CutOptions options = c.options;
      options.jitter = 0;
      options.cells *= refinement;
      return errors(fixtures::cut_torus(options, 1, r), c.size(48 * refinement), on_torus(r, 0.05));
    };
    expect_orders(c.name, at(1), at(3), 3);
  }
}

/// φ = z + xy, of the eigenvalues 2 and 6 on the unit sphere, constant along rays.
TEST(TexelConvergence, IsOfOrderTwoAndOneOnASphere) {
  const double w = 0.05;
  const auto value = [](const Vector3& p) {
    const Vector3 q = p.normalized();
    return q.z() + q.x() * q.y();
  };
  const auto gradient = [](const Vector3& p) -> Vector3 {
    const Vector3 q = p.normalized(), g(q.y(), q.x(), 1);
    return (g - q * q.dot(g)) / p.norm();
  };
  const auto right = [=](const Vector3& p) {
    const Vector3 q = p.normalized();
    return (1 + 2 * w) * q.z() + (1 + 6 * w) * q.x() * q.y();
  };
  for (const bool slanted : {false, true}) {
    CutOptions options;
    options.scale = slanted ? 0.5 : 0.6;
    options.angle = fixtures::odd_angle;
    if (slanted) options.shape = fixtures::sheared;
    const auto at = [&](int refinement) {
      const Mesh mesh = fixtures::cut_sphere(6 * refinement, options);
      const int side = 40 * refinement;
      return errors(mesh, slanted ? TextureSize{3 * side, 3 * side} : TextureSize{3 * side, 2 * side},
                    {w, value, gradient, right});
    };
    expect_orders(slanted ? "slanted" : "turned", at(1), at(3), 3);
  }
}

// -------------------------------------------------------------------------------------- flat torus

/// The square of side 1 with opposite sides joined: positions on a torus in space, the metric of
/// the square.
struct FlatTorus {
  std::unique_ptr<Textured> model;
  TexelSpaceOptions metrics;
};
FlatTorus flat_torus(const CutOptions& options, const TextureSize& size) {
  const Mesh flat = fixtures::cut_square(options);
  const auto square = fixtures::textured(flat, {size});
  FlatTorus torus{fixtures::textured(fixtures::cut_torus(options), {size}), {}};
  for (int t = 0; t < flat.triangle_count(); ++t)
    torus.metrics.metrics.push_back(texel_metric(square->surface, square->atlas, t));
  return torus;
}

TEST(TexelConvergence, FilteringHasTheGainOfItsFormulaOnTheFlatTorus) {
  for (const Case& c : cases(28)) {
    const TextureSize size = c.size(128);  // 64 texels a period of two
    const FlatTorus torus = flat_torus(c.options, size);
    ASSERT_EQ(torus.model->surface.euler_characteristic, 0);
    ASSERT_EQ(torus.model->surface.boundary_edges, 0);
    const TexelSpace space(torus.model->surface, torus.model->atlas, torus.metrics);
    const auto x = fixtures::texels_on_square(c.options, size, space.texels());
    Signal psi(space.size(), 2);
    for (int i = 0; i < space.size(); ++i)
      psi.row(i) << std::cos(4 * pi * x[i].x()), std::sin(2 * pi * (x[i].x() - x[i].y()));
    const SparseMatrix M = space.mass();
    const auto norm = [&](const Signal& v) { return std::sqrt((v.transpose() * (M * v))(0, 0)); };
    for (double beta : {0.0, 3.0})
      for (double w : {1e-3, 1e-2}) {
        const Signal phi = ScreenedPoisson(space, w).solve(psi, beta).signal;
        for (int k = 0; k < 2; ++k) {
          const double lambda = k ? 8 * pi * pi : 16 * pi * pi;
          const double gain = (1 + beta * w * lambda) / (1 + w * lambda);
          EXPECT_LT(norm(phi.col(k) - gain * psi.col(k)), 0.005 * gain * norm(psi.col(k)))
              << c.name << ", beta " << beta << ", w " << w << ", mode " << k;
        }
      }
  }
}

// --------------------------------------------------------------------------------- however it is cut

/// A filtered picture of the torus or the square, read at places of the square all cuts share.
Signal filtered_at(const Case& c, int texels, bool closed, const std::vector<Vector2>& places) {
  const TextureSize size = c.size(texels);
  const Mesh flat = fixtures::cut_square(c.options);
  FlatTorus torus;
  if (closed)
    torus = flat_torus(c.options, size);
  else
    torus.model = fixtures::textured(flat, {size});
  const TexelSpace space(torus.model->surface, torus.model->atlas, torus.metrics);
  EXPECT_FALSE(fixtures::shares_texels(space));
  const auto x = fixtures::texels_on_square(c.options, size, space.texels());
  Signal psi(space.size(), 1);
  for (int i = 0; i < space.size(); ++i)
    psi(i, 0) = std::exp(std::sin(2 * pi * x[i].x()) + std::cos(2 * pi * (x[i].x() + 2 * x[i].y())));
  const Signal phi = ScreenedPoisson(space, 1e-2).solve(psi, 2).signal;
  const ClosestPointFinder closest(flat);
  Signal values(std::ssize(places), 1);
  for (std::size_t k = 0; k < places.size(); ++k) {
    const ClosestPoint p = closest(Vector3(places[k].x(), places[k].y(), 0));
    values(k, 0) = fixtures::value_at(space, phi, p.triangle, p.barycentric);
  }
  return values;
}

/// The same surface in 1, 4 and 28 charts and in slanted ones: results differ by O(h²), seams
/// included.
TEST(TexelConvergence, ResultsDifferByTheSecondOrderHoweverTheSurfaceIsCut) {
  const Random random(12);
  std::vector<Vector2> places;
  for (std::uint64_t k = 0; k < 4000; ++k)
    places.push_back({random.uniform(2 * k), random.uniform(2 * k + 1)});
  for (const bool closed : {false, true}) {
    const std::vector<Case> all = cases(28);
    std::vector<std::vector<Signal>> results;
    for (const int texels : {56, 112, 168}) {
      results.emplace_back();
      for (const Case& c : all)
        results.back().push_back(filtered_at(c, texels, closed, places));
    }
    for (std::size_t k = 1; k < all.size(); ++k) {
      std::vector<double> rms;
      for (const auto& at : results)
        rms.push_back((at[k] - at[0]).norm() / std::sqrt(double(places.size())));
      EXPECT_GE(std::log(rms[0] / rms[2]) / std::log(3), 1.8)
          << (closed ? "torus, " : "square, ") << all[k].name << ": " << rms[0] << ' ' << rms[1]
          << ' ' << rms[2];
    }
  }
}

}  // namespace
}  // namespace mq

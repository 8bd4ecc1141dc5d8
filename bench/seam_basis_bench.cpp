// The published basis of texels beside a seam (quadratic elements) and ours (a blend over a quarter of a texel):
//
//     seam_basis_bench                errors of a solution by the size of the texture, and what nodes near seams cost
//     seam_basis_bench PICTURE.png    functions of a texel inside of a chart and of one beside it, bilinear, of quadratics
//                                     summed and averaged, and ours (Figure 5.2 of the thesis)
#include <fmt/format.h>

#include <Eigen/Eigenvalues>

#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <string>

#include "fem/cut_squares.h"
#include "mq/base/error.h"
#include "mq/baseline/quadratic_seam_basis.h"
#include "mq/fem/texel_space.h"
#include "mq/io/image_file.h"
#include "mq/linear/direct.h"

namespace mq {
namespace {

using std::numbers::pi;
using Evaluate = std::function<std::vector<BasisWeight>(int triangle, const Vector3& place)>;

constexpr double weight = 0.02;
double exact(const Vector3& p) { return std::cos(2 * pi * p.x()) * std::cos(pi * p.y()); }

Vector3 point_of(const Surface& surface, int t, const Vector3& place) {
  Vector3 p = Vector3::Zero();
  for (int c = 0; c < 3; ++c) p += place[c] * surface.mesh.position(t, c);
  return p;
}

/// Middles of small triangles.
void for_each_place(int cuts, const std::function<void(const Vector3&)>& visit) {
  for (int i = 0; i < cuts; ++i)
    for (int j = 0; j < cuts - i; ++j)
      for (int half = 0; half < (j + i + 1 < cuts ? 2 : 1); ++half) {
        const double third = half ? 2.0 / 3 : 1.0 / 3, u = (i + third) / cuts, v = (j + third) / cuts;
        visit({1 - u - v, u, v});
      }
}

/// Root mean square and largest error of the solution of φ − wΔφ = f with a free border.
std::array<double, 2> errors(const Surface& surface, SparseMatrix A, const Evaluate& evaluate, int cuts) {
  Vector b = Vector::Zero(A.rows());
  for (int t = 0; t < surface.triangle_count(); ++t) {
    const Vector3 first = surface.mesh.position(t, 1) - surface.mesh.position(t, 0), second = surface.mesh.position(t, 2) - surface.mesh.position(t, 0);
    const double share = first.cross(second).norm() / 2 / (cuts * cuts);
    for_each_place(cuts, [&](const Vector3& place) {
      for (const auto& [n, value] : evaluate(t, place)) b[n] += share * value * (1 + 5 * pi * pi * weight) * exact(point_of(surface, t, place));
    });
  }
  const double trace = A.diagonal().mean();
  for (int i = 0; i < A.rows(); ++i) A.coeffRef(i, i) += 1e-9 * trace;  // texels that hardly meet the surface
  const Vector phi = DirectSolver(A).solve(b);
  double sum = 0, most = 0;
  int count = 0;
  for (int t = 0; t < surface.triangle_count(); ++t)
    for_each_place(7, [&](const Vector3& place) {
      double value = 0;
      for (const auto& [n, at] : evaluate(t, place)) value += at * phi[n];
      const double error = value - exact(point_of(surface, t, place));
      sum += error * error;
      most = std::max(most, std::abs(error));
      ++count;
    });
  return {std::sqrt(sum / count), most};
}

double condition(const SparseMatrix& A) {
  Eigen::MatrixXd scaled = A;
  const Vector root = scaled.diagonal().cwiseSqrt().cwiseInverse();
  scaled = root.asDiagonal() * scaled * root.asDiagonal();
  const Vector values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled, Eigen::EigenvaluesOnly).eigenvalues();
  return values[values.size() - 1] / values[0];
}

double largest(const SparseMatrix& S) { return S.diagonal().maxCoeff(); }

fixtures::Cut off_lines(double offset) {
  fixtures::CutOptions options;
  options.jitter = 0;
  options.cells = 4;
  options.scale = 0.75;
  options.shift = [=](int chart) { return Vector2(offset * (chart + 1) / 24, -offset / 24); };
  return fixtures::cut("", options, {24, 24});
}

void measure() {
  fmt::print("four charts of a square, turned: error of a solution, root mean square and largest\n"
             "{:>8} {:>12} {:>22} {:>22}\n", "texture", "texels", "published", "ours");
  for (const int size : {32, 64, 128, 256}) {
    const fixtures::Cut cut = fixtures::cut("", fixtures::turned(fixtures::odd_angle), {size, size});
    const Surface& surface = cut.model->surface;
    const QuadraticSeamBasis published(surface, cut.model->atlas);
    const TexelSpace ours(surface, cut.model->atlas);
    const auto a = errors(surface, published.system(1, weight), [&](int t, const Vector3& p) { return published.basis_at(t, p); }, size / 2);
    const auto b = errors(surface, ours.regularised_system(1, weight), [&](int t, const Vector3& p) { return ours.basis_at(t, p); }, size / 2);
    fmt::print("{:>8} {:>12} {:>11.2e} {:>10.2e} {:>11.2e} {:>10.2e}\n", size, ours.size(), a[0], a[1], b[0], b[1]);
  }
  fmt::print("\nseams so many texels from the lines they run along: largest entry of S, and condition of M + w S scaled to a "
             "diagonal of 1\n{:>8} {:>10} {:>12} {:>10} {:>12}\n", "distance", "published", "", "ours", "");
  for (const double offset : {0.3, 0.1, 0.01, 0.001, 1e-4}) {
    const fixtures::Cut cut = off_lines(offset);
    const QuadraticSeamBasis published(cut.model->surface, cut.model->atlas);
    const TexelSpace ours(cut.model->surface, cut.model->atlas);
    fmt::print("{:>8} {:>10.4g} {:>12.4g} {:>10.4g} {:>12.4g}\n", offset, largest(published.system(0, 1)), condition(published.system(1, weight)),
               largest(ours.stiffness()), condition(ours.regularised_system(1, weight)));
  }
}

/// Two charts of a strip two squares long, the second turned by a third of a right angle and finer.
Mesh strip() {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 1, 0}};
  const auto place = [&](int k, int s, int t) {
    const double angle = k == 0 ? 0 : pi / 6, scale = k == 0 ? 0.35 : 0.42;
    const Vector2 origin = k == 0 ? Vector2(0.06, 0.3) : Vector2(0.62, 0.2);
    return Vector2(origin + scale * Vector2(std::cos(angle) * s - std::sin(angle) * t, std::sin(angle) * s + std::cos(angle) * t) * 0.8);
  };
  for (int k = 0; k < 2; ++k) {
    for (const auto& [s, t] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) mesh.uvs.push_back(place(k, s, t));
    mesh.triangles.push_back({k, k + 1, k + 4});
    mesh.triangles.push_back({k, k + 4, k + 3});
    mesh.corner_uvs.push_back({4 * k, 4 * k + 1, 4 * k + 2});
    mesh.corner_uvs.push_back({4 * k, 4 * k + 2, 4 * k + 3});
  }
  return mesh;
}

/// A function over a square of the strip around the seam: black 0, bright 1, red below 0, with the seam as a line.
void draw(const Evaluate& evaluate, int unknown, Image<float>& picture, int left, int top, int side) {
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const double s = 0.6 + 0.7 * (x + 0.5) / side, t = 0.85 - 0.7 * (y + 0.5) / side;
      const int k = s < 1 ? 0 : 1;
      const double u = s - k;
      const int triangle = 2 * k + (t > u);
      const Vector3 place = t > u ? Vector3(1 - t, u, t - u) : Vector3(1 - u, u - t, t);
      double value = 0;
      for (const auto& [n, at] : evaluate(triangle, place))
        if (n == unknown) value += at;
      const float bright = float(std::clamp(value, 0.0, 1.0)), dark = float(std::clamp(-4 * value, 0.0, 1.0));
      const bool seam = std::abs(s - 1) < 0.35 / side;
      picture(left + x, top + y, 0) = seam ? 0.5F : 0.08F + 0.92F * std::max(bright, dark);
      picture(left + x, top + y, 1) = seam ? 0.5F : 0.08F + 0.92F * bright;
      picture(left + x, top + y, 2) = seam ? 0.5F : 0.08F + 0.92F * bright;
    }
}

void draw_functions(const std::string& file) {
  const Surface surface = make_surface(strip());
  const Atlas atlas = make_atlas(surface, {{24, 24}});
  TexelSpaceOptions soft;
  soft.seams = TexelSpaceOptions::Seams::soft;
  const TexelSpace ours(surface, atlas), bilinear(surface, atlas, soft);
  const QuadraticSeamBasis mean(surface, atlas), sum(surface, atlas, QuadraticSeamBasis::Values::sum);
  constexpr int side = 220, gap = 10;
  Image<float> picture(4 * side + 5 * gap, 2 * side + 3 * gap, 3);
  std::ranges::fill(picture.values(), 1.0F);
  // The chart begins at 0.06 · 24 − ½ = 0.94 and ends at 0.94 + 6.72 = 7.66 texels: 6 is inside, 8 beside it.
  int row = 0;
  for (const std::array<int, 3>& texel : {std::array{0, 6, 13}, {0, 8, 13}}) {
    const auto of_space = [&](const TexelSpace& space) {
      for (int i = 0; i < space.size(); ++i) {
        const Texels::Place& p = space.texels().places[std::size_t(i)];
        if (std::array{p.texture, p.x, p.y} == texel) return i;
      }
      return -1;
    };
    const auto of_basis = [&](const QuadraticSeamBasis& basis) {
      return int(std::ranges::find(basis.texels(), texel) - basis.texels().begin());
    };
    const int top = gap + row++ * (side + gap);
    draw([&](int t, const Vector3& p) { return bilinear.basis_at(t, p); }, of_space(bilinear), picture, gap, top, side);
    draw([&](int t, const Vector3& p) { return sum.basis_at(t, p); }, of_basis(sum), picture, 2 * gap + side, top, side);
    draw([&](int t, const Vector3& p) { return mean.basis_at(t, p); }, of_basis(mean), picture, 3 * gap + 2 * side, top, side);
    draw([&](int t, const Vector3& p) { return ours.basis_at(t, p); }, of_space(ours), picture, 4 * gap + 3 * side, top, side);
  }
  write_image(file, picture, Depth::u8);
}

}  // namespace
}  // namespace mq

int main(int argc, char** argv) {
  try {
    if (argc > 1)
      mq::draw_functions(argv[1]);
    else
      mq::measure();
  } catch (const std::exception& error) {
    fmt::print(stderr, "seam_basis_bench: {}\n", error.what());
    return 2;
  }
}

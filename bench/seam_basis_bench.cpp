// The published basis of texels beside a seam (quadratic elements) and ours (a blend over a quarter of a texel):
//
//     seam_basis_bench                errors of a solution by the size of the texture, and what nodes near seams cost
//     seam_basis_bench PICTURE.png    functions of a texel inside of a chart and of one beside it, bilinear, of quadratics
//                                     summed and averaged, and ours (Figure 5.2 of the thesis)
//     seam_basis_bench spot PICTURE.png
//                                     a spot that spreads far, and a little, over a seam that is penalised a little, much, and
//                                     by our functions, as graphics cards show it (Figure 5.5); how far each is off
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

/// The triangle of the strip and the place in it of a point.
std::pair<int, Vector3> place_on_strip(double s, double t) {
  const int k = s < 1 ? 0 : 1;
  const double u = s - k;
  return {2 * k + (t > u), t > u ? Vector3(1 - t, u, t - u) : Vector3(1 - u, u - t, t)};
}

constexpr int side = 220, gap = 10;

Image<float> panels(int columns, int rows) {
  Image<float> picture(columns * side + (columns + 1) * gap, rows * side + (rows + 1) * gap, 3);
  std::ranges::fill(picture.values(), 1.0F);
  return picture;
}

/// A square of the strip around the seam, by values there: black 0, bright 1, red below 0, with the seam as a line.
void draw(const std::function<double(int, const Vector3&)>& value_at, Image<float>& picture, int column, int row) {
  const int left = gap + column * (side + gap), top = gap + row * (side + gap);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const double s = 0.6 + 0.7 * (x + 0.5) / side, t = 0.85 - 0.7 * (y + 0.5) / side;
      const auto [triangle, place] = place_on_strip(s, t);
      const double value = value_at(triangle, place);
      const float bright = float(std::clamp(value, 0.0, 1.0)), dark = float(std::clamp(-4 * value, 0.0, 1.0));
      const bool seam = std::abs(s - 1) < 0.35 / side;
      picture(left + x, top + y, 0) = seam ? 0.5F : 0.08F + 0.92F * std::max(bright, dark);
      picture(left + x, top + y, 1) = seam ? 0.5F : 0.08F + 0.92F * bright;
      picture(left + x, top + y, 2) = seam ? 0.5F : 0.08F + 0.92F * bright;
    }
}

void draw(const Evaluate& evaluate, int unknown, Image<float>& picture, int column, int row) {
  draw(
      [&](int triangle, const Vector3& place) {
        double value = 0;
        for (const auto& [n, at] : evaluate(triangle, place))
          if (n == unknown) value += at;
        return value;
      },
      picture, column, row);
}

TexelSpaceOptions soft_seams(double penalty) {
  TexelSpaceOptions options;
  options.seams = TexelSpaceOptions::Seams::soft;
  options.seam_penalty = penalty;
  return options;
}

void draw_functions(const std::string& file) {
  const Surface surface = make_surface(strip());
  const Atlas atlas = make_atlas(surface, {{24, 24}});
  const TexelSpace ours(surface, atlas), bilinear(surface, atlas, soft_seams(0));
  const QuadraticSeamBasis mean(surface, atlas), sum(surface, atlas, QuadraticSeamBasis::Values::sum);
  Image<float> picture = panels(4, 2);
  // The chart begins at 0.06 · 24 − ½ = 0.94 and ends at 0.94 + 6.72 = 7.66 texels: 6 is inside, 8 beside it.
  int row = 0;
  for (const std::array<int, 3>& texel : {std::array{0, 6, 13}, {0, 8, 13}}) {
    const auto of_space = [&](const TexelSpace& space) { return space.texels().find({texel[0], texel[1], texel[2]}); };
    const auto of_basis = [&](const QuadraticSeamBasis& basis) {
      return int(std::ranges::find(basis.texels(), texel) - basis.texels().begin());
    };
    draw([&](int t, const Vector3& p) { return bilinear.basis_at(t, p); }, of_space(bilinear), picture, 0, row);
    draw([&](int t, const Vector3& p) { return sum.basis_at(t, p); }, of_basis(sum), picture, 1, row);
    draw([&](int t, const Vector3& p) { return mean.basis_at(t, p); }, of_basis(mean), picture, 2, row);
    draw([&](int t, const Vector3& p) { return ours.basis_at(t, p); }, of_space(ours), picture, 3, row);
    ++row;
  }
  write_image(file, picture, Depth::u8);
}

/// A unit of heat at (0.9, 0.5) of the strip after it has spread over a length.
Vector spread(const TexelSpace& space, double length) {
  const auto [triangle, place] = place_on_strip(0.9, 0.5);
  Vector b = Vector::Zero(space.size());
  for (const auto& [n, value] : space.basis_at(triangle, place)) b[n] += value;
  return DirectSolver(space.regularised_system(1, length * length)).solve(b);
}

/// Values at a point as a graphics card shows them: bilinear in each chart.
double shown(const TexelSpace& bilinear, const TexelSpace& space, const Vector& phi, int triangle, const Vector3& place) {
  double value = 0;
  for (const auto& [n, at] : bilinear.basis_at(triangle, place)) {
    const int unknown = space.texels().find(bilinear.texels().places[std::size_t(n)]);
    if (unknown >= 0) value += at * phi[unknown];
  }
  return value;
}

void draw_spots(const std::string& file) {
  const Surface surface = make_surface(strip());
  const Atlas atlas = make_atlas(surface, {{40, 40}}), fine_atlas = make_atlas(surface, {{240, 240}});
  const TexelSpace fine(surface, fine_atlas), bilinear(surface, atlas, soft_seams(0)), ours(surface, atlas);
  const double h = ours.scale().texel_spacing;
  const TexelSpace little(surface, atlas, soft_seams(0.01 / h)), much(surface, atlas, soft_seams(1000 / h));
  Image<float> picture = panels(3, 2);
  fmt::print("{:>10} {:>10} {:>10} {:>10}   of the largest: error, root mean square and largest over the seam\n", "length", "little", "much", "ours");
  int row = 0;
  for (const double length : {0.5, 2 * h}) {
    const Vector reference = spread(fine, length);
    double largest = 0;
    const auto truth = [&](int t, const Vector3& p) {
      double value = 0;
      for (const auto& [n, at] : fine.basis_at(t, p)) value += at * reference[n];
      return value;
    };
    for (int k = 0; k < 50; ++k) {
      const auto [t, p] = place_on_strip(0.999, (k + 0.5) / 50);
      largest = std::max(largest, truth(t, p));
    }
    fmt::print("{:>10.3g}", length);
    int column = 0;
    for (const TexelSpace* space : {&little, &much, &ours}) {
      const Vector phi = spread(*space, length);
      const auto value = [&](int t, const Vector3& p) { return shown(bilinear, *space, phi, t, p) / largest; };
      double sum = 0, jump = 0;
      int count = 0;
      for (int i = 0; i < 60; ++i)
        for (int j = 0; j < 60; ++j) {
          const double s = 1 + 0.4 * (i + 0.5) / 60, t = 0.1 + 0.8 * (j + 0.5) / 60;  // behind the seam
          const auto [triangle, place] = place_on_strip(s, t);
          sum += std::pow(value(triangle, place) - truth(triangle, place) / largest, 2), ++count;
          const auto [left, on_left] = place_on_strip(1 - 1e-9, t);
          const auto [right, on_right] = place_on_strip(1 + 1e-9, t);
          jump = std::max(jump, std::abs(value(left, on_left) - value(right, on_right)));
        }
      fmt::print(" {:>6.3f} {:.3f}", std::sqrt(sum / count), jump);
      draw(value, picture, column++, row);
    }
    fmt::print("\n");
    ++row;
  }
  write_image(file, picture, Depth::u8);
}

}  // namespace
}  // namespace mq

int main(int argc, char** argv) {
  try {
    if (argc > 2)
      mq::draw_spots(argv[2]);
    else if (argc > 1)
      mq::draw_functions(argv[1]);
    else
      mq::measure();
  } catch (const std::exception& error) {
    fmt::print(stderr, "seam_basis_bench: {}\n", error.what());
    return 2;
  }
}

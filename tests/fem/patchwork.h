#pragma once
/// The unit square cut into charts that are laid apart in a texture: a texel system small enough to
/// write down, with everything that makes real ones hard. Charts are stretched, shifted by parts of
/// a texel, and coupled at their cuts by averaging both sides, as the seam-continuous basis is
/// (thesis 5.5).

#include <array>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <vector>

#include "mq/fem/texels.h"
#include "mq/linear/matrix.h"

namespace mq::fixtures {

struct Patchwork {
  SparseMatrix mass;
  SparseMatrix stiffness;
  Texels texels;

  SparseMatrix system(double a, double b) const { return a * mass + b * stiffness; }
};

struct PatchworkOptions {
  int size = 64;         ///< texels along a side of the square, where it is not stretched
  int charts = 1;        ///< along a side
  double stretch = 1;    ///< texels are so many times as far apart along x as along y
  double denser = 1;     ///< every other chart has so many times as many texels along y
  unsigned seed = 1;
};

namespace patchwork_detail {

/// A value as a combination of texels.
using Combination = std::vector<std::pair<int, double>>;

struct Node {
  std::array<double, 2> at;  ///< in texels of the chart
  Combination value;
};

class Builder {
 public:
  explicit Builder(const PatchworkOptions& options) : options_(options) {
    lay_out();
    for (int c = 0; c < chart_count(); ++c) add_chart(c);
  }

  Patchwork finish() {
    Patchwork result;
    std::map<std::array<int, 2>, int> order;  // raster order
    for (const auto& [place, id] : ids_) order[{place[1], place[0]}] = id;
    std::vector<int> rank(order.size());
    for (const auto& [place, id] : order) {
      rank[id] = result.texels.size();
      const int chart = chart_of_[id];
      const Chart& c = charts_[chart];
      result.texels.places.push_back({0, place[1], place[0]});
      result.texels.positions.push_back({float(c.u + (place[1] - c.x) / c.sx),
                                         float(c.v + (place[0] - c.y) / c.sy), 0.0f});
      result.texels.chart.push_back(chart);
      result.texels.interior.push_back(0);
    }
    const int n = int(rank.size());
    for (auto* list : {&mass_, &stiffness_})
      for (auto& t : *list) t = {rank[t.row()], rank[t.col()], t.value()};
    result.mass.resize(n, n);
    result.mass.setFromTriplets(mass_.begin(), mass_.end());
    result.stiffness.resize(n, n);
    result.stiffness.setFromTriplets(stiffness_.begin(), stiffness_.end());
    for (int k = 0; k < n; ++k) result.texels.interior[k] = result.mass.row(k).nonZeros() == 9;
    return result;
  }

 private:
  struct Chart {
    double u, v;            ///< lower corner on the square
    double sx, sy;          ///< texels per unit
    double x, y, x1, y1;    ///< its rectangle in the texture
  };

  int chart_count() const { return options_.charts * options_.charts; }

  void lay_out() {
    std::mt19937 random(options_.seed);
    std::uniform_real_distribution<double> uniform(0, 1);
    const int k = options_.charts;
    const double f = std::sqrt(options_.stretch);
    const double pitch = std::ceil(options_.size * f * options_.denser / k) + 5;
    // Cuts keep off texel centres by a tenth of a texel, as welding keeps them in the real basis.
    const auto start = [&](double base, double length) {
      const auto clear = [](double x) { return x - std::floor(x) > 0.1 && x - std::floor(x) < 0.9; };
      for (;;) {
        const double x = base + uniform(random);
        if (clear(x) && clear(x + length)) return x;
      }
    };
    for (int j = 0; j < k; ++j)
      for (int i = 0; i < k; ++i) {
        Chart c;
        c.u = double(i) / k;
        c.v = double(j) / k;
        c.sx = options_.size / f;
        c.sy = options_.size * f * ((i + j) % 2 ? options_.denser : 1);
        c.x = start(2 + pitch * i, c.sx / k);
        c.y = start(2 + pitch * j, c.sy / k);
        c.x1 = c.x + c.sx / k;
        c.y1 = c.y + c.sy / k;
        charts_.push_back(c);
      }
  }

  int id(int x, int y, int chart) {
    const auto [it, added] = ids_.try_emplace({x, y}, int(ids_.size()));
    if (added) chart_of_.push_back(chart);
    return it->second;
  }

  /// The bilinear value of a chart at (x, y), times weight, added to `out`.
  void add_bilinear(int chart, double x, double y, double weight, std::map<int, double>& out) {
    const int i = int(std::floor(x)), j = int(std::floor(y));
    for (int dy = 0; dy < 2; ++dy)
      for (int dx = 0; dx < 2; ++dx) {
        const double w = (dx ? x - i : 1 - (x - i)) * (dy ? y - j : 1 - (y - j));
        if (w > 1e-12) out[id(i + dx, j + dy, chart)] += weight * w;
      }
  }

  /// The charts that hold the point of chart c at (x, y), with its coordinates there.
  std::vector<std::array<double, 3>> copies(int c, double x, double y) const {
    const Chart& own = charts_[c];
    const int k = options_.charts, i0 = c % k, j0 = c / k;
    std::vector<int> is = {i0}, js = {j0};
    if (x == own.x && i0 > 0) is.push_back(i0 - 1);
    if (x == own.x1 && i0 + 1 < k) is.push_back(i0 + 1);
    if (y == own.y && j0 > 0) js.push_back(j0 - 1);
    if (y == own.y1 && j0 + 1 < k) js.push_back(j0 + 1);
    std::vector<std::array<double, 3>> result;
    const double s = (x - own.x) / (own.x1 - own.x), t = (y - own.y) / (own.y1 - own.y);
    for (const int j : js)
      for (const int i : is) {
        const Chart& d = charts_[j * k + i];
        const double sd = i < i0 ? 1 : i > i0 ? 0 : s, td = j < j0 ? 1 : j > j0 ? 0 : t;
        result.push_back({double(j * k + i), d.x + sd * (d.x1 - d.x), d.y + td * (d.y1 - d.y)});
      }
    return result;
  }

  Node node(int c, double x, double y) {
    const auto all = copies(c, x, y);
    std::map<int, double> value;
    for (const auto& [chart, xd, yd] : all)
      add_bilinear(int(chart), xd, yd, 1.0 / double(all.size()), value);
    return {{x, y}, Combination(value.begin(), value.end())};
  }

  /// Coordinates of chart c along `axis` where the grid lines of it and of its neighbour across the
  /// side cross that side; crossings of the neighbour within a tenth of a texel of another are left
  /// out (functions are then not quite continuous there, but no sliver spoils the conditioning).
  std::set<double> crossings(int c, int axis, int neighbour) const {
    const auto range = [&](int chart) {
      const Chart& d = charts_[chart];
      return axis == 0 ? std::array{d.x, d.x1} : std::array{d.y, d.y1};
    };
    const auto own = range(c);
    std::set<double> result = {own[0], own[1]};
    for (double x = std::ceil(own[0]); x < own[1]; ++x) result.insert(x);
    if (neighbour >= 0) {
      const auto other = range(neighbour);
      for (double x = std::ceil(other[0]); x < other[1]; ++x) {
        const double mine = own[0] + (x - other[0]) / (other[1] - other[0]) * (own[1] - own[0]);
        bool close = false;
        for (const double r : result) close = close || std::abs(r - mine) < welded;
        if (!close) result.insert(mine);
      }
    }
    return result;
  }

  void add_chart(int c) {
    const Chart& chart = charts_[c];
    const int k = options_.charts, i0 = c % k, j0 = c / k;
    const std::array<std::set<double>, 4> side = {
        crossings(c, 0, j0 > 0 ? c - k : -1), crossings(c, 1, i0 + 1 < k ? c + 1 : -1),
        crossings(c, 0, j0 + 1 < k ? c + k : -1), crossings(c, 1, i0 > 0 ? c - 1 : -1)};
    for (int j = int(std::floor(chart.y)); j < chart.y1; ++j)
      for (int i = int(std::floor(chart.x)); i < chart.x1; ++i) {
        const double x0 = std::max(chart.x, double(i)), x1 = std::min(chart.x1, double(i + 1));
        const double y0 = std::max(chart.y, double(j)), y1 = std::min(chart.y1, double(j + 1));
        if (x0 >= x1 || y0 >= y1) continue;
        if (x0 > chart.x && x1 < chart.x1 && y0 > chart.y && y1 < chart.y1)
          add_cell(c, i, j);
        else
          add_piece(c, x0, x1, y0, y1, side);
      }
  }

  /// A whole cell: bilinear, integrated exactly.
  void add_cell(int c, int i, int j) {
    const Chart& chart = charts_[c];
    const double a = chart.sx / chart.sy, density = 1 / (chart.sx * chart.sy);
    int ids[4];
    for (int n = 0; n < 4; ++n) ids[n] = id(i + n % 2, j + n / 2, c);
    for (int m = 0; m < 4; ++m)
      for (int n = 0; n < 4; ++n) {
        const bool same_x = m % 2 == n % 2, same_y = m / 2 == n / 2;
        const double mx = same_x ? 1.0 / 3 : 1.0 / 6, my = same_y ? 1.0 / 3 : 1.0 / 6;
        const double kx = same_x ? 1 : -1, ky = same_y ? 1 : -1;
        mass_.emplace_back(ids[m], ids[n], density * mx * my);
        stiffness_.emplace_back(ids[m], ids[n], a * kx * my + mx * ky / a);
      }
  }

  /// A cell cut by the chart's outline: triangles around its middle.
  void add_piece(int c, double x0, double x1, double y0, double y1,
                 const std::array<std::set<double>, 4>& side) {
    const Chart& chart = charts_[c];
    std::vector<Node> ring;
    const auto walk = [&](const std::set<double>& extra, bool on_side, double from, double to,
                          bool along_x, double fixed) {
      std::vector<double> at = {from};
      if (on_side)
        for (const double t : extra)
          if (t > std::min(from, to) && t < std::max(from, to)) at.push_back(t);
      if (from < to) std::sort(at.begin(), at.end());
      else std::sort(at.rbegin(), at.rend());
      for (const double t : at)
        ring.push_back(along_x ? node(c, t, fixed) : node(c, fixed, t));
    };
    walk(side[0], y0 == chart.y, x0, x1, true, y0);
    walk(side[1], x1 == chart.x1, y0, y1, false, x1);
    walk(side[2], y1 == chart.y1, x1, x0, true, y1);
    walk(side[3], x0 == chart.x, y1, y0, false, x0);
    const Node middle = node(c, (x0 + x1) / 2, (y0 + y1) / 2);
    const auto half = [&](const Node& a, const Node& b) {
      return node(c, (a.at[0] + b.at[0]) / 2, (a.at[1] + b.at[1]) / 2);
    };
    for (std::size_t n = 0; n < ring.size(); ++n) {
      const Node &a = ring[n], &b = ring[(n + 1) % ring.size()];
      add_triangle(chart, {middle, a, b, half(middle, a), half(a, b), half(b, middle)});
    }
  }

  /// Quadratic functions on a triangle: corners, then the middles of the edges 01, 12, 20.
  void add_triangle(const Chart& chart, const std::array<Node, 6>& nodes) {
    std::array<std::array<double, 2>, 3> p, edge;
    for (int n = 0; n < 3; ++n)
      p[n] = {nodes[n].at[0] / chart.sx, nodes[n].at[1] / chart.sy};
    for (int n = 0; n < 3; ++n)
      for (int d = 0; d < 2; ++d) edge[n][d] = p[(n + 2) % 3][d] - p[(n + 1) % 3][d];
    const double area = (edge[2][0] * -edge[1][1] + edge[2][1] * edge[1][0]) / 2;
    const auto gradients = [&](int m, int n) {  // of barycentric coordinates m and n
      return (edge[m][0] * edge[n][0] + edge[m][1] * edge[n][1]) / (4 * area * area);
    };
    // Gradients of the six functions at the middle of edge `at`, as multiples of those of the
    // barycentric coordinates; the product of two is quadratic, so three such points are exact.
    const auto slopes = [&](int at, int f) {
      std::array<double, 3> l = {0.5, 0.5, 0.5}, g = {0, 0, 0};
      l[(at + 2) % 3] = 0;
      if (f < 3) {
        g[f] = 4 * l[f] - 1;
      } else {
        const int i = f - 3, j = (i + 1) % 3;
        g[j] = 4 * l[i];
        g[i] = 4 * l[j];
      }
      return g;
    };
    for (int f = 0; f < 6; ++f)
      for (int g = 0; g < 6; ++g) {
        double s = 0;
        for (int at = 0; at < 3; ++at) {
          const auto gf = slopes(at, f), gg = slopes(at, g);
          for (int m = 0; m < 3; ++m)
            for (int n = 0; n < 3; ++n) s += area / 3 * gf[m] * gg[n] * gradients(m, n);
        }
        const bool corner_f = f < 3, corner_g = g < 3;
        double w = 0;
        if (corner_f && corner_g) w = f == g ? 6 : -1;
        if (!corner_f && !corner_g) w = f == g ? 32 : 16;
        if (corner_f != corner_g) {
          const int corner = std::min(f, g), middle = std::max(f, g) - 3;
          w = (middle + 2) % 3 == corner ? -4 : 0;
        }
        w *= area / 180;
        for (const auto& [i, vi] : nodes[f].value)
          for (const auto& [j, vj] : nodes[g].value) {
            mass_.emplace_back(i, j, vi * vj * w);
            stiffness_.emplace_back(i, j, vi * vj * s);
          }
      }
  }

  static constexpr double welded = 0.1;

  PatchworkOptions options_;
  std::vector<Chart> charts_;
  std::map<std::array<int, 2>, int> ids_;
  std::vector<int> chart_of_;
  std::vector<Eigen::Triplet<double>> mass_, stiffness_;
};

}  // namespace patchwork_detail

inline Patchwork make_patchwork(const PatchworkOptions& options) {
  return patchwork_detail::Builder(options).finish();
}

/// M + w·S with w = `ratio` texels squared; infinite: S alone.
inline SparseMatrix system_of(const Patchwork& p, double ratio) {
  const double h2 = p.mass.sum() / p.texels.size();
  SparseMatrix A = std::isinf(ratio) ? p.system(0, 1) : p.system(1, ratio * h2);
  A.makeCompressed();
  return A;
}

/// Values in [0, 1), a different signal for every seed.
inline Signal signal_noise(Eigen::Index rows, int channels, unsigned seed = 7) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  Signal X(rows, channels);
  for (Eigen::Index i = 0; i < X.size(); ++i) X.data()[i] = uniform(random);
  return X;
}

}  // namespace mq::fixtures

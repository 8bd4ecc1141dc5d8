// Integrals of fields against the basis functions of a texel space.

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>

#include "mq/base/error.h"
#include "mq/fem/detail/quadrature.h"
#include "mq/fem/detail/texel_space_data.h"
#include "mq/linear/coupled_pairs.h"

namespace mq {

namespace {

/// What a triangle covers of one row of cells, as pieces, whole cells among them.
template <class Visit>
void for_each_piece_in_row(const std::array<TexelPoint, 3>& corners, int row, const Visit& visit) {
  clip_row(
      corners, row,
      [&](const Piece& piece) {
        if (piece.area() >= smallest_piece) visit(piece);
      },
      [&](int, int first, int last) {
        for (int column = first; column <= last; ++column) visit(whole_cell(row, column));
      });
}

void add_rule(int triangle, const std::array<double, 2>& a, const std::array<double, 2>& b,
              const std::array<double, 2>& c, SeamCell& cell) {
  const double area = std::abs((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2;
  for (const TrianglePoint& p : triangle_rule_4())
    cell.add_point(triangle, p.l0 * a[0] + p.l1 * b[0] + p.l2 * c[0],
                   p.l0 * a[1] + p.l1 * b[1] + p.l2 * c[1], p.weight * area);
}

/// Barycentric coordinates, a row each, of points of a cell.
Signal barycentric_in(const std::array<TexelPoint, 3>& corners, int column, int row,
                      const std::vector<std::array<double, 2>>& places) {
  std::array<Eigen::Vector2d, 3> p;  // from the cell's origin
  for (int k = 0; k < 3; ++k)
    p[k] = Eigen::Vector2d(double(corners[k].x - column * TexelPoint::one),
                           double(corners[k].y - row * TexelPoint::one)) /
           double(TexelPoint::one);
  Eigen::Matrix2d edges;
  edges << p[1] - p[0], p[2] - p[0];
  const Eigen::Matrix2d inverse = edges.inverse();
  Signal result(std::ssize(places), 3);
  for (Eigen::Index q = 0; q < result.rows(); ++q) {
    const Eigen::Vector2d l = inverse * (Eigen::Vector2d(places[q][0], places[q][1]) - p[0]);
    result.row(q) << 1 - l.sum(), l.x(), l.y();
  }
  return result;
}

}  // namespace

void TexelSpace::for_each_piece(const std::function<void(const TexelSamples&)>& visit) const {
  const Data& d = *data_;
  d.require_integrals();
  SeamCell cell(d.atlas, *d.seams, d.grid);
  std::vector<SeamCell::Polygon> bilinear;
  BasisSamples points;
  std::vector<int> unknowns;
  TexelSamples samples;
  const auto visit_cell = [&](int column, int row) {
    cell.evaluate(points);
    samples.barycentric =
        barycentric_in(d.atlas.corners[samples.triangle], column, row, points.places);
    samples.values = points.values;
    samples.dx = points.dx;
    samples.dy = points.dy;
    samples.weights = Eigen::Map<const Vector>(points.weights.data(), std::ssize(points.weights));
    unknowns.clear();
    for (int texel : points.texels) unknowns.push_back(d.unknown[texel]);
    samples.texels = unknowns;
    visit(samples);
  };
  for (int t = 0; t < d.triangles(); ++t) {
    if (d.atlas.chart[t] < 0) continue;
    const int texture = d.surface.mesh.texture(t);
    samples.triangle = t;
    const auto [first, end] = rows_of(d.atlas.corners[t]);
    for (int row = first; row < end; ++row) {
      const auto near = d.near_row(t, row);
      for_each_piece_in_row(d.atlas.corners[t], row, [&](const Piece& piece) {
        if (!d.marked.empty() && !d.marked[std::size_t(d.grid.cell(texture, piece.column, row))]) return;
        cell.start(texture, piece.column, row, NearSeams::cell(near, piece.column));
        bilinear.clear();
        cell.add_piece(t, piece, bilinear);
        if (!cell.empty()) visit_cell(piece.column, row);
        if (bilinear.empty()) return;
        cell.start(texture, piece.column, row, {});
        for (const SeamCell::Polygon& polygon : bilinear)
          for (std::size_t k = 2; k < polygon.size(); ++k)
            add_rule(t, polygon[0], polygon[k - 1], polygon[k], cell);
        visit_cell(piece.column, row);
      });
    }
  }
}

std::vector<BasisWeight> TexelSpace::basis_at(int triangle, const Vector3& barycentric) const {
  const Data& d = *data_;
  require(triangle >= 0 && triangle < d.triangles() && d.atlas.chart[triangle] >= 0,
          "a triangle with a chart is needed");
  const auto& corners = d.atlas.corners[triangle];
  // Relative to the first corner's cell, to keep the fraction's bits.
  const int column0 = floor_texel(corners[0].x), row0 = floor_texel(corners[0].y);
  double x = 0, y = 0;
  for (int k = 0; k < 3; ++k) {
    x +=
        barycentric[k] * double(corners[k].x - column0 * TexelPoint::one) / double(TexelPoint::one);
    y += barycentric[k] * double(corners[k].y - row0 * TexelPoint::one) / double(TexelPoint::one);
  }
  const int column = column0 + int(std::floor(x)), row = row0 + int(std::floor(y));
  return basis_in(d.atlas.chart[triangle], column, row, x - std::floor(x), y - std::floor(y));
}

std::vector<BasisWeight> TexelSpace::basis_in(int chart, int column, int row, double x, double y) const {
  const Data& d = *data_;
  d.require_integrals();
  const int texture = d.atlas.charts[chart].texture;
  const TextureSize& size = d.grid.texture(texture);
  SeamCell cell(d.atlas, *d.seams, d.grid);
  cell.start(texture, column, row, {});
  // Of a chart that runs over the border of a texture that repeats, the tile is not known.
  const int tiles = d.near && size.wrap == Wrap::repeat ? 1 : 0;
  for (int j = -tiles; d.near && j <= tiles; ++j)
    for (int i = -tiles; i <= tiles; ++i) {
      const int tile_column = column + i * size.width, tile_row = row + j * size.height;
      const auto near = NearSeams::cell(d.near->row(chart, tile_row), tile_column);
      if (!near.empty()) cell.start(texture, tile_column, tile_row, near);
    }
  cell.add_point(-1, x, y, 0);
  BasisSamples samples;
  cell.evaluate(samples);
  std::vector<BasisWeight> result;
  for (std::size_t k = 0; k < samples.texels.size(); ++k)
    if (samples.values(0, k) != 0 && d.unknown[samples.texels[k]] >= 0)
      result.push_back({d.unknown[samples.texels[k]], samples.values(0, k)});
  return result;
}

Signal TexelSpace::divergence(const std::vector<std::vector<Vector3>>& fields) const {
  const Data& d = *data_;
  for (const auto& field : fields)
    require(int(field.size()) == d.triangles(), "one vector per triangle is needed");
  Signal result = Signal::Zero(size(), Eigen::Index(fields.size()));
  for_each_piece([&](const TexelSamples& samples) {
    // X in texel coordinates: least squares of e ξ = X over the triangle's two edge vectors.
    const int t = samples.triangle;
    const auto& p = d.atlas.corners[t];
    Eigen::Matrix2d E;
    E << p[1].column() - p[0].column(), p[2].column() - p[0].column(), p[1].row() - p[0].row(),
        p[2].row() - p[0].row();
    Eigen::Matrix<double, 3, 2> e;
    e.col(0) = d.surface.mesh.position(t, 1) - d.surface.mesh.position(t, 0);
    e.col(1) = d.surface.mesh.position(t, 2) - d.surface.mesh.position(t, 0);
    const Eigen::Matrix2d gram = e.transpose() * e;
    const Eigen::RowVectorXd sum_x = samples.weights.transpose() * samples.dx;
    const Eigen::RowVectorXd sum_y = samples.weights.transpose() * samples.dy;
    for (std::size_t f = 0; f < fields.size(); ++f) {
      const Eigen::Vector2d xi = E * gram.ldlt().solve(e.transpose() * fields[f][t]);
      for (std::size_t k = 0; k < samples.texels.size(); ++k)
        result(samples.texels[k], f) +=
            d.metrics[t].density * (xi.x() * sum_x[k] + xi.y() * sum_y[k]);
    }
  });
  return result;
}

std::vector<std::array<int, 2>> TexelSpace::edges() const {
  const SparseMatrix pattern = system(0, 1);
  std::vector<std::array<int, 2>> result;
  result.reserve(pattern.nonZeros() / 2);
  for_each_coupled_pair(pattern, [&](int i, int j) { result.push_back({i, j}); });
  return result;
}

Signal TexelSpace::edge_divergence(const std::vector<std::array<int, 2>>& edges,
                                   const Signal& z) const {
  require(z.rows() == std::ssize(edges), "one row per edge is needed");
  const Data& d = *data_;
  const Eigen::Index channels = z.cols();
  Signal result = Signal::Zero(size(), channels);
  Eigen::MatrixXd difference;
  for_each_piece([&](const TexelSamples& samples) {
    const int count = int(samples.texels.size());
    const TexelMetric& metric = d.metrics[samples.triangle];
    for (Eigen::Index c = 0; c < channels; ++c) {
      difference.setZero(count, count);
      for (int i = 0; i < count; ++i)
        for (int j = 0; j < count; ++j) {
          const std::array<int, 2> pair{samples.texels[i], samples.texels[j]};
          if (pair[0] >= pair[1]) continue;
          const auto at = std::lower_bound(edges.begin(), edges.end(), pair);
          if (at == edges.end() || *at != pair) continue;
          difference(i, j) = z(at - edges.begin(), c);
          difference(j, i) = -difference(i, j);
        }
      // ω = Σ_j (Σ_i φ_i z_ij) ∇φ_j, over both orders of each pair
      const Eigen::MatrixXd mixed = samples.values * difference;
      const Eigen::VectorXd wx = (mixed.array() * samples.dx.array()).rowwise().sum();
      const Eigen::VectorXd wy = (mixed.array() * samples.dy.array()).rowwise().sum();
      const Eigen::VectorXd fx = samples.weights.array() * (metric.a * wx + metric.b * wy).array();
      const Eigen::VectorXd fy = samples.weights.array() * (metric.b * wx + metric.c * wy).array();
      const Eigen::VectorXd b = samples.dx.transpose() * fx + samples.dy.transpose() * fy;
      for (int k = 0; k < count; ++k) result(samples.texels[k], c) += b[k];
    }
  });
  return result;
}

namespace {

/// ∫ ⟨φ_i ∇φ_j − φ_j ∇φ_i, ∇φ_t⟩ dA over one piece, per texel t of it.
Eigen::VectorXd moments_of_edge(const TexelSamples& samples, const TexelMetric& metric, int i, int j) {
  const auto form = [&](const Signal& slope) {
    return (samples.weights.array() * (samples.values.col(i).array() * slope.col(j).array() -
                                       samples.values.col(j).array() * slope.col(i).array()))
        .matrix()
        .eval();
  };
  const Eigen::VectorXd wx = form(samples.dx), wy = form(samples.dy);
  return samples.dx.transpose() * (metric.a * wx + metric.b * wy) +
         samples.dy.transpose() * (metric.b * wx + metric.c * wy);
}

constexpr std::size_t entries_at_once = 1 << 23;  ///< before equal places are added up: 128 MB

}  // namespace

SparseMatrix TexelSpace::edge_divergence_matrix(const std::vector<std::array<int, 2>>& edges) const {
  SparseMatrix sum(size(), int(edges.size()));
  Entries entries;
  const auto add_up = [&] {
    const SparseMatrix part = sparse_matrix(size(), int(edges.size()), entries);
    sum = SparseMatrix(sum + part);
    entries.clear();
  };
  for_each_piece([&](const TexelSamples& samples) {
    const int count = int(samples.texels.size());
    for (int i = 0; i < count; ++i)
      for (int j = 0; j < count; ++j) {
        const std::array<int, 2> pair{samples.texels[i], samples.texels[j]};
        if (pair[0] >= pair[1]) continue;
        const auto at = std::lower_bound(edges.begin(), edges.end(), pair);
        if (at == edges.end() || *at != pair) continue;
        const Eigen::VectorXd b = moments_of_edge(samples, data_->metrics[samples.triangle], i, j);
        for (int k = 0; k < count; ++k)
          entries.emplace_back(samples.texels[k], int(at - edges.begin()), b[k]);
      }
    if (entries.size() > entries_at_once) add_up();
  });
  add_up();
  return sum;
}

}  // namespace mq

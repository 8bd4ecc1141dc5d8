// Paths on an image are those on a mesh of its triangles, and those on a chart of as many texels.

#include "mq/trace/grid_flow.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "fem/cut_squares.h"
#include "fixtures.h"
#include "mq/base/error.h"
#include "mq/base/random.h"
#include "mq/trace/atlas_flow.h"
#include "mq/trace/surface_flow.h"

namespace mq {
namespace {

/// Triangle s of cell (i, j) of an image so wide, as `GridFlow` numbers them.
int grid_triangle(int width, int i, int j, int s) {
  int row = 1;
  while (row < width) row *= 2;
  return 2 * (j * row + i) + s;
}

/// The image's triangles as a mesh, pixel (i, j) at (i, j): those of cell after cell.
Surface grid_mesh(const GridFlow& flow) {
  Mesh mesh;
  for (int j = 0; j < flow.height(); ++j)
    for (int i = 0; i < flow.width(); ++i) mesh.positions.push_back({double(i), double(j), 0});
  for (int j = 0; j + 1 < flow.height(); ++j)
    for (int i = 0; i + 1 < flow.width(); ++i)
      for (const int s : {0, 1}) {
        Triangle t;
        for (int k = 0; k < 3; ++k) {
          const auto [x, y] = flow.place({grid_triangle(flow.width(), i, j, s), Vector3::Unit(k)});
          t[k] = int(y) * flow.width() + int(x);
        }
        mesh.triangles.push_back(t);
      }
  return make_surface(mesh);
}

/// Starts inside, on edges and at corners of all triangles, of the image and of the mesh.
std::pair<std::vector<SurfacePoint>, std::vector<SurfacePoint>> grid_starts(int width, int height) {
  std::pair<std::vector<SurfacePoint>, std::vector<SurfacePoint>> starts;
  int triangle = 0;
  for (int j = 0; j + 1 < height; ++j)
    for (int i = 0; i + 1 < width; ++i)
      for (int s = 0; s < 2; ++s, ++triangle)
        for (const Vector3& b : {Vector3(0.2, 0.3, 0.5), Vector3(0.4, 0, 0.6), Vector3(0, 1, 0)}) {
          starts.first.push_back({grid_triangle(width, i, j, s), b});
          starts.second.push_back({triangle, b});
        }
  return starts;
}

void expect_same_ends(const GridFlow& grid, const SurfaceFlow& flow, const Surface& surface, double time) {
  const auto [on_image, on_mesh] = grid_starts(grid.width(), grid.height());
  const auto compare = [&](const Traced& found, const Traced& wanted) {
    ASSERT_EQ(found.ends.size(), wanted.ends.size());
    for (std::size_t n = 0; n < found.ends.size(); ++n) {
      const auto [x, y] = grid.place(found.ends[n]);
      const Vector3 there = point_at(surface.mesh, wanted.ends[n]);
      ASSERT_LT((Vector3(x, y, 0) - there).norm(), 1e-9) << n << ", after " << time;
    }
    EXPECT_EQ(found.counts.paths, wanted.counts.paths);
    EXPECT_EQ(found.counts.resting, wanted.counts.resting);
    EXPECT_EQ(found.counts.cut_short, wanted.counts.cut_short);
  };
  compare(grid.trace(on_image, time), flow.trace(on_mesh, time));
  compare(grid.trace_pixels(time), flow.trace_vertices(time));
}

TEST(GridFlow, FallsAsOnAMeshOfItsTriangles) {
  for (const auto& [width, height] : {std::pair(2, 2), std::pair(7, 5), std::pair(8, 3), std::pair(3, 9)})
    for (const double noise : {0.1, 3.0}) {
      const Random random(7);
      std::vector<double> P;
      for (int i = 0; i < width * height; ++i)
        P.push_back(std::sin(0.9 * (i % width)) + std::cos(0.8 * (i / width)) +
                    noise * random.uniform(std::uint64_t(i), -1, 1));
      const GridFlow grid = GridFlow::downhill(width, height, P);
      const Surface surface = grid_mesh(grid);
      const TraceMesh mesh(surface);
      const SurfaceFlow flow = SurfaceFlow::downhill(mesh, Eigen::Map<Vector>(P.data(), Eigen::Index(P.size())));
      for (const double time : {0.3, 2.7, std::numeric_limits<double>::infinity()})
        expect_same_ends(grid, flow, surface, time);
    }
}

TEST(GridFlow, GoesAlongAFieldAsOnAMeshOfItsTriangles) {
  for (const auto& [width, height] : {std::pair(2, 3), std::pair(7, 5), std::pair(9, 4)})
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
      const Random random(seed);
      std::vector<std::array<double, 2>> X;
      std::vector<Vector3> of_triangles;
      for (int c = 0; c < (width - 1) * (height - 1); ++c) {
        X.push_back({random.uniform(std::uint64_t(2 * c), -1, 1), random.uniform(std::uint64_t(2 * c + 1), -1, 1)});
        of_triangles.insert(of_triangles.end(), 2, Vector3(X.back()[0], X.back()[1], 0));
      }
      const GridFlow grid = GridFlow::along(width, height, X);
      const Surface surface = grid_mesh(grid);
      const TraceMesh mesh(surface);
      const SurfaceFlow flow = SurfaceFlow::along(mesh, field_in_frames(surface, of_triangles));
      for (const double time : {0.3, 2.7, 40.0}) expect_same_ends(grid, flow, surface, time);
    }
}

TEST(GridFlow, NumbersTrianglesByRowsOfAPowerOfTwo) {
  const GridFlow flow = GridFlow::along(8, 5, std::vector<std::array<double, 2>>(28, {0.0, 0.0}));
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 7; ++i)
      for (const int s : {0, 1}) {
        const auto [x, y] = flow.place({grid_triangle(8, i, j, s), Vector3::UnitX()});
        EXPECT_EQ(y, j + s);
        EXPECT_EQ(x, (i + j + s) % 2 == 0 ? i + 1 : i);  // mirrored from cell to cell
      }
  const std::vector<SurfacePoint> beyond = {{grid_triangle(8, 7, 2, 0), Vector3(0.2, 0.3, 0.5)}};
  EXPECT_THROW(flow.trace(beyond, 1), InvalidInput);
  const std::vector<SurfacePoint> below = {{grid_triangle(8, 2, 4, 1), Vector3(0.2, 0.3, 0.5)}};
  EXPECT_THROW(flow.trace(below, 1), InvalidInput);
}

/// A square of one chart, of as many texels as an image has pixels; the image may begin a column before it, so
/// that cells are cut alike.
struct SquareOfTexels {
  static constexpr int side = 24;
  std::unique_ptr<fixtures::Textured> model = fixtures::textured(
      fixtures::cut_square({.cells = 4, .parts = 1, .jitter = 0}), {{side, side}});
  TexelSpace space{model->surface, model->atlas};
  TraceAtlas domain{model->surface, model->atlas, space};

  int shift() const { return domain.diagonal(domain.cell(0, 0, 0)); }

  /// Where a place of the chart is on the image.
  Vector2 pixel(const ChartPlace& at) const {
    const int stride = domain.stride(at.cell);
    return {at.cell % stride - 1 + shift() + at.x, at.cell / stride - 1 + at.y};
  }
  SurfacePoint on_image(const GridFlow& grid, const ChartPlace& at) const {
    const Vector2 wanted = pixel(at);
    for (const int s : {0, 1}) {
      const int t = grid_triangle(grid.width(), int(wanted.x()), int(wanted.y()), s);
      Eigen::Matrix3d corners;
      for (int k = 0; k < 3; ++k) {
        const auto [x, y] = grid.place({t, Vector3::Unit(k)});
        corners.col(k) << x, y, 1;
      }
      const Vector3 b = corners.inverse() * Vector3(wanted.x(), wanted.y(), 1);
      if (b.minCoeff() > -1e-12) return {t, b.cwiseMax(0) / b.cwiseMax(0).sum()};
    }
    ADD_FAILURE() << wanted.transpose();
    return {};
  }

  /// The share of paths from all cells but `margin` around that end at the same place.
  double same_ends(const AtlasFlow& atlas, const GridFlow& grid, int margin, double time) const {
    std::vector<ChartPlace> starts;
    std::vector<SurfacePoint> starts_of_image;
    for (int j = margin; j + 1 < side - margin; ++j)
      for (int i = margin; i + 1 < side - margin; ++i)
        for (const auto& [x, y] : {std::pair(0.2, 0.3), std::pair(0.7, 0.6), std::pair(0.0, 0.0), std::pair(0.0, 0.4)}) {
          starts.push_back({0, domain.cell(0, i, j), x, y});
          starts_of_image.push_back(on_image(grid, starts.back()));
        }
    const TracedTexels found = atlas.trace(starts, time);
    const Traced wanted = grid.trace(starts_of_image, time);
    int same = 0;
    for (std::size_t n = 0; n < starts.size(); ++n) {
      const auto [x, y] = grid.place(wanted.ends[n]);
      same += (pixel(found.ends[n]) - Vector2(x, y)).norm() < 1e-4;
    }
    return double(same) / double(starts.size());
  }
};

TEST(GridFlow, IsThatOfAChartOfAsManyTexels) {
  const SquareOfTexels square;
  constexpr int side = SquareOfTexels::side;
  const int width = side + square.shift();
  const Random random(3);
  std::vector<std::array<double, 2>> on_image(std::size_t(width - 1) * (side - 1), {0.0, 0.0});
  std::vector<std::array<double, 2>> on_chart(std::size_t(square.domain.grid_cell_count()), {0.0, 0.0});
  for (int j = 0; j + 1 < side; ++j)
    for (int i = 0; i + 1 < side; ++i) {
      const std::uint64_t count = 2 * std::uint64_t(j * side + i);
      const std::array<double, 2> X = {random.uniform(count, -1, 1), random.uniform(count + 1, -1, 1)};
      on_image[std::size_t(j) * (width - 1) + i + square.shift()] = X;
      on_chart[std::size_t(j + 1) * (side + 1) + i + 1] = X;  // cells of `TexelGrid` begin before the first texel
    }
  const AtlasFlow along = AtlasFlow::along(square.domain, on_chart);
  EXPECT_EQ(square.same_ends(along, GridFlow::along(width, side, on_image), 7, 2.5), 1);

  std::vector<double> P(std::size_t(width) * side, 0.0);
  Vector of_texels(square.space.size());
  for (int n = 0; n < of_texels.size(); ++n) {
    const auto& at = square.space.texels().places[std::size_t(n)];
    of_texels[n] = random.uniform(std::uint64_t(n), -1, 1);
    if (at.x >= 0 && at.y >= 0 && at.x < side && at.y < side)
      P[std::size_t(at.y) * width + at.x + square.shift()] = of_texels[n];
  }
  // Gradients of the chart are those of its surface.
  const double metric = square.domain.metric(square.domain.cell(0, side / 2, side / 2)).xx;
  const AtlasFlow falls = AtlasFlow::downhill(square.domain, of_texels / metric);
  EXPECT_GT(square.same_ends(falls, GridFlow::downhill(width, side, P), 7, 1.5), 0.99);
}

}  // namespace
}  // namespace mq

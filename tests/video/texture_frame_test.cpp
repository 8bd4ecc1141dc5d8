#include "mq/video/texture_frame.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "mq/base/error.h"
#include "mq/sample/sample.h"
#include "mq/video/texel_owners.h"

namespace mq {
namespace {

/// The square [0, 1]², cut into n × n squares of two triangles, moved to `height`; its texture
/// coordinates are (x, y) shrunk to `share` of the texture's side.
Mesh square(int n, double height = 0, double share = 1) {
  Mesh mesh;
  for (int y = 0; y <= n; ++y)
    for (int x = 0; x <= n; ++x) {
      mesh.positions.emplace_back(double(x) / n, double(y) / n, height);
      mesh.uvs.emplace_back(share * x / n, share * y / n);
    }
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const int v = y * (n + 1) + x;
      mesh.triangles.push_back({v, v + 1, v + n + 2});
      mesh.triangles.push_back({v, v + n + 2, v + n + 1});
    }
  mesh.corner_uvs = mesh.triangles;
  return mesh;
}

/// Red is x, green y, blue x·y, of the captured point.
ColourAt by_place(const Mesh& mesh) {
  return [&mesh](const ClosestPoint& point) {
    Vector3 p = Vector3::Zero();
    for (int k = 0; k < 3; ++k) p += point.barycentric[k] * mesh.position(point.triangle, k);
    return std::array{float(p.x()), float(p.y()), float(p.x() * p.y())};
  };
}

TEST(TextureFrame, ShowsWhatWasCapturedWhateverItsTriangles) {
  const Mesh surface = square(3), captured = square(7);
  const TextureFrame frame = resample_texture(surface, captured, by_place(captured),
                                              {.width = 32, .height = 16, .samples = 3});
  EXPECT_EQ(frame.texels, 32 * 16);
  EXPECT_EQ(frame.unseen, 0);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 32; ++x) {
      const double u = (x + 0.5) / 32, v = 1 - (y + 0.5) / 16;
      EXPECT_NEAR(frame.picture(x, y, 0), u, 1e-6);
      EXPECT_NEAR(frame.picture(x, y, 1), v, 1e-6);
      EXPECT_NEAR(frame.picture(x, y, 2), u * v, 1e-6);  // symmetric samples of a bilinear function
    }
}

/// Colours are linear on captured triangles, so what is shown is off by the square of their edges.
TEST(TextureFrame, ConvergesToTheTruthAsCapturesGetFiner) {
  const Sample ball = make_sample("sphere", {.texture_size = 128, .triangles = 20000});
  const auto truth = [](const Vector3& p) { return 0.5 + 0.3 * std::sin(3 * p.x() + p.y()); };
  const TexelOwners owners(ball.mesh, 128, 128);
  const auto error = [&](int triangles) {
    Mesh captured = make_sample("sphere", {.triangles = triangles}).mesh;
    const Eigen::AngleAxisd turn(1, Vector3(1, 2, 3).normalized());
    for (Vector3& p : captured.positions) p = turn * p;
    const ColourAt colour = [&](const ClosestPoint& at) {
      double value = 0;
      for (int k = 0; k < 3; ++k)
        value += at.barycentric[k] * truth(captured.position(at.triangle, k));
      return std::array{float(value), float(value), float(value)};
    };
    const TextureFrame frame =
        resample_texture(ball.mesh, captured, colour, {.width = 128, .height = 128, .samples = 1});
    double squares = 0, count = 0;
    for (int y = 0; y < 128; ++y)
      for (int x = 0; x < 128; ++x) {
        const TexelOwners::Owner& owner = owners.owner(x, y);
        if (owner.triangle < 0 || owner.distance > 0) continue;
        const Vector3 inside =
            nearest_in_triangle(owners.corners(owner.triangle), owners.place(x, y));
        Vector3 p = Vector3::Zero();
        for (int k = 0; k < 3; ++k) p += inside[k] * ball.mesh.position(owner.triangle, k);
        squares += std::pow(frame.picture(x, y, 0) - truth(p.normalized()), 2);
        ++count;
      }
    return std::sqrt(squares / count);
  };
  const double coarse = error(1000), middle = error(4000), fine = error(16000);
  EXPECT_GT(coarse, 3.5 * middle) << coarse << ' ' << middle << ' ' << fine;
  EXPECT_GT(middle, 3.5 * fine) << coarse << ' ' << middle << ' ' << fine;
  EXPECT_LT(fine, 3e-4);
}

TEST(TextureFrame, GoesOnOutsideOfChartsWithTheNearestTexel) {
  const Mesh surface = square(4, 0, 0.5), captured = square(5);
  const TextureFrame frame =
      resample_texture(surface, captured, by_place(captured), {.width = 32, .height = 32});
  EXPECT_EQ(frame.texels, 16 * 16);
  // Beyond the rim colours are those of the rim: its samples, clamped to the surface.
  for (int y = 18; y < 32; ++y)
    for (int x = 18; x < 32; ++x) {
      EXPECT_NEAR(frame.picture(x, y, 0), 1, 0.05);
      EXPECT_NEAR(frame.picture(x, y, 1), frame.picture(16, y, 1), 1e-6);
    }
}

TEST(TextureFrame, LeavesOutWhatIsFarOrFacesAway) {
  const Mesh surface = square(4), far = square(4, 0.5);
  EXPECT_EQ(resample_texture(surface, far, by_place(far), {.width = 16, .height = 16}).unseen, 256);
  Mesh away = square(4);
  for (Triangle& t : away.triangles) std::swap(t[1], t[2]);
  EXPECT_EQ(resample_texture(surface, away, by_place(away), {.width = 16, .height = 16}).unseen,
            256);
  // Half of it is there: the rest is filled from where that ends.
  Mesh half = square(4);
  std::erase_if(half.triangles, [&](const Triangle& t) {
    return half.positions[t[0]].x() + half.positions[t[1]].x() + half.positions[t[2]].x() > 1.5;
  });
  const TextureFrame frame =
      resample_texture(surface, half, by_place(half), {.width = 64, .height = 64});
  EXPECT_NEAR(double(frame.unseen) / double(frame.texels), 0.5, 0.05);
  EXPECT_NEAR(frame.picture(60, 30, 0), 0.5, 0.05);
}

/// Both, the second after the first; texture coordinates of the first in the left half of the
/// texture, of the second in the right one.
Mesh side_by_side(Mesh a, Mesh b) {
  const auto halve = [](Mesh& mesh, double shift) {
    for (Vector2& uv : mesh.uvs) uv.x() = shift + 0.48 * uv.x();
  };
  halve(a, 0.01);
  halve(b, 0.51);
  const int vertices = a.vertex_count(), uvs = int(a.uvs.size());
  a.positions.insert(a.positions.end(), b.positions.begin(), b.positions.end());
  a.uvs.insert(a.uvs.end(), b.uvs.begin(), b.uvs.end());
  for (int t = 0; t < b.triangle_count(); ++t) {
    Triangle corners = b.triangles[t], corner_uvs = b.corner_uvs[t];
    for (int k = 0; k < 3; ++k) corners[k] += vertices, corner_uvs[k] += uvs;
    a.triangles.push_back(corners);
    a.corner_uvs.push_back(corner_uvs);
  }
  return a;
}

Mesh with_flipped(Mesh mesh) {
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  for (Triangle& t : mesh.corner_uvs) std::swap(t[1], t[2]);
  return mesh;
}

/// Red: the height of the captured point is that of the first sheet; green and blue: x and y.
ColourAt by_sheet(const Mesh& mesh, int first_triangles) {
  return [&mesh, first_triangles](const ClosestPoint& point) {
    Vector3 p = Vector3::Zero();
    for (int k = 0; k < 3; ++k) p += point.barycentric[k] * mesh.position(point.triangle, k);
    return std::array{point.triangle < first_triangles ? 1.0F : 0.0F, float(p.x()), float(p.y())};
  };
}

/// Largest error of red, green and blue in texels whose owner is sure: those of charts.
double worst_error(const TextureFrame& frame) {
  double worst = 0;
  const int size = frame.picture.width();
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const double u = (x + 0.5) / size, v = 1 - (y + 0.5) / size;
      const double place = u < 0.5 ? (u - 0.01) / 0.48 : (u - 0.51) / 0.48;
      if (place < 0.05 || place > 0.95 || v < 0.05 || v > 0.95) continue;
      worst = std::max({worst, std::abs(frame.picture(x, y, 0) - (u < 0.5 ? 1.0 : 0.0)),
                        std::abs(frame.picture(x, y, 1) - place),
                        std::abs(frame.picture(x, y, 2) - v)});
    }
  return worst;
}

TEST(TextureFrame, DoesNotTakeTheUndersideOfAnArmForTheBody) {
  // An underside 0.01 above a body, both followed with an error that brings each nearer to the
  // other than to itself.
  const Mesh surface = side_by_side(square(6, 0.007), with_flipped(square(6, 0.003))),
             captured = side_by_side(square(5, 0), with_flipped(square(5, 0.01)));
  const TextureFrame frame =
      resample_texture(surface, captured, by_sheet(captured, 50), {.width = 64, .height = 64});
  EXPECT_EQ(frame.unseen, 0);
  EXPECT_NEAR(frame.accuracy, 0.007, 1e-12);
  EXPECT_LT(worst_error(frame), 1e-5);
}

TEST(TextureFrame, FillsAHoleRatherThanTakeWhatLiesBehindIt) {
  // Two sheets that face the same way; in the first one a hole, through which the second is near.
  const Mesh surface = side_by_side(square(6, 0), square(6, 0.02));
  Mesh holed = square(10);
  const auto in_hole = [&](const Triangle& t) {
    const Vector3 p = (holed.positions[t[0]] + holed.positions[t[1]] + holed.positions[t[2]]) / 3;
    return std::abs(p.x() - 0.5) < 0.2 && std::abs(p.y() - 0.5) < 0.2;
  };
  std::erase_if(holed.triangles, in_hole);
  holed.corner_uvs = holed.triangles;
  const int left = holed.triangle_count();
  const Mesh captured = side_by_side(holed, square(10, 0.02));
  const TextureFrame frame =
      resample_texture(surface, captured, by_sheet(captured, left), {.width = 96, .height = 96});
  EXPECT_NEAR(double(frame.unseen) / double(frame.texels), 0.16 / 2, 0.01);
  EXPECT_EQ(frame.filled, frame.unseen);
  EXPECT_LT(worst_error(frame), 0.01);  // what it shows is linear, and so is what is harmonic
  // The nearest point that faces alike is on the other sheet.
  const ClosestPoint nearest = ClosestPointFinder(captured)(Vector3(0.5, 0.5, 0));
  EXPECT_GE(nearest.triangle, left);
  EXPECT_LT(std::sqrt(nearest.squared_distance), 0.02 * std::sqrt(2.0));
}

TEST(TextureFrame, TakesOutStepsBetweenCapturedCharts) {
  // What was captured is x, and 0.2 more in a second chart.
  const Mesh surface = square(6), captured = square(8);
  std::vector<int> charts;
  for (const Triangle& t : captured.triangles)
    charts.push_back(
        (captured.positions[t[0]] + captured.positions[t[1]] + captured.positions[t[2]]).x() > 1.5
            ? 1
            : 0);
  const ColourAt colour = [&](const ClosestPoint& point) {
    double x = 0;
    for (int k = 0; k < 3; ++k)
      x += point.barycentric[k] * captured.position(point.triangle, k).x();
    const float value = float(0.2 + 0.5 * x + 0.2 * charts[point.triangle]);
    return std::array{value, value, 0.5F};
  };
  TextureFrameOptions options{.width = 64, .height = 64};
  const TextureFrame as_it_is = resample_texture(surface, captured, colour, options);
  EXPECT_NEAR(as_it_is.picture(32, 30, 0) - as_it_is.picture(31, 30, 0), 0.2, 0.02);
  options.captured_charts = charts;
  const TextureFrame frame = resample_texture(surface, captured, colour, options);
  EXPECT_GT(frame.before.across, 10 * frame.before.within);
  EXPECT_LT(frame.after.across, 2 * frame.after.within);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) {  // the mean is kept
      EXPECT_NEAR(frame.picture(x, y, 0), 0.3 + 0.5 * (x + 0.5) / 64, 0.004);
      EXPECT_NEAR(frame.picture(x, y, 2), 0.5, 1e-6);
    }
  options.captured_charts.assign(charts.size(), 3);
  const TextureFrame one_chart = resample_texture(surface, captured, colour, options);
  EXPECT_TRUE(std::ranges::equal(one_chart.picture.values(), as_it_is.picture.values()));
  options.captured_charts.pop_back();
  EXPECT_THROW(resample_texture(surface, captured, colour, options), InvalidInput);
}

TEST(TextureFrame, ColoursVerticesInTheSameWay) {
  const Mesh surface = side_by_side(square(12, 0.007), with_flipped(square(12, 0.003)));
  Mesh below = square(24, 0);
  std::erase_if(below.triangles, [&](const Triangle& t) {
    return (below.positions[t[0]] - Vector3(0.5, 0.5, 0)).norm() < 0.2;
  });
  below.corner_uvs = below.triangles;
  const int left = below.triangle_count();
  const Mesh captured = side_by_side(below, with_flipped(square(5, 0.01)));
  const VertexColours found = resample_vertices(surface, captured, by_sheet(captured, left));
  EXPECT_GT(found.unseen, 10);
  ASSERT_EQ(found.colours.rows(), surface.vertex_count());
  for (int v = 0; v < surface.vertex_count(); ++v) {
    EXPECT_NEAR(found.colours(v, 0), v < 169 ? 1 : 0, 1e-6);
    EXPECT_NEAR(found.colours(v, 1), surface.positions[v].x(), 0.02);
    EXPECT_NEAR(found.colours(v, 2), surface.positions[v].y(), 0.02);
  }
}

TEST(TextureFrame, SaysWhatItNeeds) {
  Mesh bare = square(2);
  bare.corner_uvs.clear();
  const Mesh captured = square(2);
  EXPECT_THROW(resample_texture(bare, captured, by_place(captured)), InvalidInput);
  EXPECT_THROW(resample_texture(captured, Mesh(), by_place(captured)), InvalidInput);
  EXPECT_THROW(resample_texture(captured, captured, by_place(captured), {.samples = 0}),
               InvalidInput);
}

}  // namespace
}  // namespace mq

#include "mq/sample/sample.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <map>
#include <numbers>

#include "fixtures.h"
#include "mq/base/error.h"
#include "mq/mesh/geometry.h"
#include "mq/sample/shapes.h"

namespace mq {
namespace {

using std::numbers::pi;
using ::testing::HasSubstr;

struct Made {
  Sample sample;
  Surface surface;
  Atlas atlas;
};

Made make(const std::string& name, const SampleOptions& options) {
  Made made{make_sample(name, options), {}, {}};
  made.surface = make_surface(made.sample.mesh);
  made.atlas = make_atlas(made.surface, {made.sample.texture});
  return made;
}

/// As a user gets it who asks for nothing else; made once.
const Made& make(const std::string& name) {
  static std::map<std::string, Made> all;
  const auto at = all.find(name);
  return at != all.end() ? at->second : all.emplace(name, make(name, {})).first->second;
}

/// Texel centres that lie strictly inside more than one triangle.
int overlapping_texels(const Made& made) {
  const TextureSize& size = made.atlas.textures[0];
  std::vector<int> layers(std::size_t(size.width) * size.height);
  for (int t = 0; t < made.surface.triangle_count(); ++t) {
    const auto& p = made.atlas.corners[t];
    const auto [x0, x1] = std::minmax({p[0].x, p[1].x, p[2].x});
    const auto [y0, y1] = std::minmax({p[0].y, p[1].y, p[2].y});
    for (int y = std::max(0, floor_texel(y0)); y <= std::min(size.height - 1, floor_texel(y1)); ++y)
      for (int x = std::max(0, floor_texel(x0)); x <= std::min(size.width - 1, floor_texel(x1));
           ++x) {
        const TexelPoint c{x * TexelPoint::one, y * TexelPoint::one};
        const int turn = sign(orientation(p[0], p[1], p[2]));
        bool inside = true;
        for (int k = 0; k < 3; ++k)
          inside = inside && sign(orientation(p[k], p[(k + 1) % 3], c)) == turn;
        layers[std::size_t(y) * size.width + x] += inside;
      }
  }
  return int(std::count_if(layers.begin(), layers.end(), [](int n) { return n > 1; }));
}

void expect_sound(const Made& made) {
  SCOPED_TRACE(made.sample.name);
  for (const Defect& d : made.surface.defects) ADD_FAILURE() << d.kind;
  for (const Defect& d : made.atlas.defects) ADD_FAILURE() << d.kind;  // no flipped triangles
  EXPECT_EQ(made.surface.components, 1);
  for (const int c : made.atlas.chart) ASSERT_GE(c, 0);
  for (const Vector2& uv : made.sample.mesh.uvs) {
    EXPECT_GE(uv.minCoeff(), 0);
    EXPECT_LE(uv.maxCoeff(), 1);
  }
  EXPECT_EQ(overlapping_texels(made), 0);
}

/// Mean ratio of singular values over the surface.
double mean_stretch(const Made& made) {
  double mean = 0;
  for (int t = 0; t < made.surface.triangle_count(); ++t)
    mean += texel_metric(made.surface, made.atlas, t).stretch *
            triangle_area(made.surface.mesh, t) / made.surface.area;
  return mean;
}

struct Expected {
  int charts, euler, boundary_loops;
  double stretch;  // mean, at most
};

class EverySample : public testing::TestWithParam<std::string> {};

TEST_P(EverySample, HasTheChartsAndTheTopologyItIsNamedForAndStretchesLittle) {
  const std::map<std::string, Expected> expected{{"bust", {28, 2, 0, 1.1}},
                                                 {"bust_1", {1, 2, 0, 1.5}},
                                                 {"bust_4", {4, 2, 0, 1.5}},
                                                 {"bust_3000", {3000, 2, 0, 1.1}},
                                                 {"genus4", {24, -6, 0, 1.1}},
                                                 {"sphere", {6, 2, 0, 1.25}},
                                                 {"torus", {1, 0, 0, 1.4}},
                                                 {"torus_conformal", {1, 0, 0, 1.05}},
                                                 {"flat_torus", {1, 0, 0, 1.001}},
                                                 {"cylinder", {1, 0, 2, 1.001}},
                                                 {"cube", {1, 2, 0, 1.001}},
                                                 {"cap", {1, 1, 1, 1.05}},
                                                 {"cap_moebius", {1, 1, 1, 1.05}},
                                                 {"cap_stretched_4", {1, 1, 1, 4.1}},
                                                 {"cap_stretched_16", {1, 1, 1, 16.4}},
                                                 {"cap_28", {28, 1, 1, 1.1}}};
  EXPECT_EQ(sample_names().size(), expected.size());
  const Made& made = make(GetParam());
  const Expected& want = expected.at(GetParam());
  expect_sound(made);
  EXPECT_EQ(std::ssize(made.atlas.charts), want.charts);
  EXPECT_EQ(made.surface.euler_characteristic, want.euler);
  EXPECT_EQ(made.surface.boundary_edges > 0, want.boundary_loops > 0);
  EXPECT_LT(mean_stretch(made), want.stretch);
}

std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const SampleInfo& info : sample_names()) all.push_back(info.name);
  return all;
}
INSTANTIATE_TEST_SUITE_P(Samples, EverySample, testing::ValuesIn(names()),
                         [](const auto& info) { return info.param; });

TEST(Samples, AreStretchedWhereTheySaySo) {
  EXPECT_GT(mean_stretch(make("cap_stretched_16")), 15.9);
}

TEST(Samples, AreSoundAtAnyTextureSize) {
  for (const SampleInfo& info : sample_names())
    for (const int size : {128, 333}) {
      const int triangles = info.name == "bust_3000" ? 20000 : 3000;
      expect_sound(make(info.name, {.texture_size = size, .triangles = triangles}));
    }
}

TEST(Samples, AreIsometricWhereTheySaySo) {
  for (const char* name : {"cube", "cylinder", "flat_torus"}) {
    const Made& made = make(name);
    const double density = made.atlas.surface_area / made.atlas.texel_area;
    for (int t = 0; t < made.surface.triangle_count(); ++t) {
      const TexelMetric metric = texel_metric(made.surface, made.atlas, t);
      ASSERT_NEAR(metric.stretch, 1, 1e-6) << name;
      ASSERT_NEAR(metric.density / density, 1, 1e-7) << name;
    }
  }
}

TEST(Samples, BecomeConformalAsTheMeshIsRefined) {
  const auto excess = [](const char* name, int triangles) {
    const Made made = make(name, {.triangles = triangles});
    double sum = 0;
    for (int t = 0; t < made.surface.triangle_count(); ++t)
      sum += std::pow(texel_metric(made.surface, made.atlas, t).stretch - 1, 2) *
             triangle_area(made.surface.mesh, t) / made.surface.area;
    return std::sqrt(sum);
  };
  for (const char* name : {"cap", "cap_moebius", "torus_conformal"}) {
    const double coarse = excess(name, 6000), fine = excess(name, 24000);
    EXPECT_GT(std::log2(coarse / fine), 0.9) << name;
    EXPECT_LT(fine, 0.05) << name;
  }
}

TEST(FlatTorus, HasNoCurvatureAnywhere) {
  const Sample sample = make_sample("flat_torus");
  std::vector<double> sums(sample.mesh.positions.size());
  for (int t = 0; t < sample.mesh.triangle_count(); ++t)
    for (int k = 0; k < 3; ++k)
      sums[sample.mesh.triangles[t][k]] += corner_angles(sample.mesh, t)[k];
  for (const double sum : sums) EXPECT_NEAR(sum, 2 * pi, 1e-12);
}

/// Whether the segment meets the triangle, from side to side.
bool pierces(const Vector3& p, const Vector3& q, const Mesh& mesh, int t) {
  const Vector3 &a = mesh.position(t, 0), &b = mesh.position(t, 1), &c = mesh.position(t, 2);
  const auto volume = [](const Vector3& u, const Vector3& v, const Vector3& w, const Vector3& x) {
    return (v - u).cross(w - u).dot(x - u);
  };
  if (volume(a, b, c, p) * volume(a, b, c, q) >= 0) return false;
  const double u = volume(p, q, a, b), v = volume(p, q, b, c), w = volume(p, q, c, a);
  return (u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0);
}

TEST(FlatTorus, DoesNotMeetItself) {
  const Mesh mesh = make_sample("flat_torus", {.triangles = 36}).mesh;
  ASSERT_EQ(mesh.triangle_count(), 36);
  for (int t = 0; t < 36; ++t)
    for (int s = 0; s < 36; ++s)
      for (int k = 0; k < 3; ++k) {
        const int a = mesh.triangles[s][k], b = mesh.triangles[s][(k + 1) % 3];
        const Triangle& corners = mesh.triangles[t];
        const bool shared = std::count(corners.begin(), corners.end(), a) +
                                std::count(corners.begin(), corners.end(), b) >
                            0;
        EXPECT_FALSE(!shared && pierces(mesh.positions[a], mesh.positions[b], mesh, t));
      }
}

/// The picture at a point of a half-edge, bilinearly, from the side of its triangle.
Vector3 color_at(const Made& made, const Image<float>& image, HalfEdge h, double along) {
  const TexelPoint& a = made.atlas.corners[h / 3][h % 3];
  const TexelPoint& b = made.atlas.corners[h / 3][(h % 3 + 1) % 3];
  const double x = std::lerp(a.column(), b.column(), along), y = std::lerp(a.row(), b.row(), along);
  const int i = int(std::floor(x)), j = int(std::floor(y));
  Vector3 color;
  for (int k = 0; k < 3; ++k)
    color[k] = std::lerp(std::lerp(image(i, j, k), image(i + 1, j, k), x - i),
                         std::lerp(image(i, j + 1, k), image(i + 1, j + 1, k), x - i), y - j);
  return color;
}

/// A smooth field, so that interpolation errors are of the second order.
Vector3 smooth_field(const Vector3& p, int) {
  return {0.5 + 0.4 * std::sin(3 * p.x() + p.y()), 0.5 + 0.4 * std::cos(2 * p.y() - p.z()),
          0.5 + 0.4 * std::sin(4 * p.z() + 2 * p.x())};
}

/// Largest difference at seams from what the field is there, in units of how much it can change
/// over a texel.
double seam_error(const std::string& name, int size) {
  const Made made = size == SampleOptions{}.texture_size ? make(name) : make(name, {.texture_size = size});
  const Image<float> image = paint(made.surface, made.atlas, smooth_field);
  double largest = 0;
  int seams = 0;
  for (HalfEdge h = 0; h < HalfEdge(made.atlas.edges.size()); ++h) {
    if (made.atlas.edges[h] != EdgeKind::seam) continue;
    ++seams;
    for (const double along : {0.1, 0.5, 0.8}) {
      const Vector3 p = (1 - along) * made.surface.mesh.position(h / 3, h % 3) +
                        along * made.surface.mesh.position(h / 3, (h % 3 + 1) % 3);
      largest = std::max(
          largest, (color_at(made, image, h, along) - smooth_field(p, 0)).cwiseAbs().maxCoeff());
    }
  }
  EXPECT_GT(seams, 0);
  return largest / (1.8 * made.atlas.texel_spacing());
}

TEST(Paint, HasTheTrueValueOnBothSidesOfASeam) {
  // The error is that of leaving a bent surface along a triangle's plane: less than a texel's worth
  // of change anywhere, and hardly any where the surface is smooth.
  for (const char* name : {"cube", "bust", "bust_3000"})
    EXPECT_LT(seam_error(name, 1024), 1) << name;
  EXPECT_LT(seam_error("sphere", 1024), 0.05);
  EXPECT_LT(seam_error("sphere", 1024), 0.6 * seam_error("sphere", 512));
}

TEST(Paint, IsExactForLinearFieldsOnAFlatChart) {
  Mesh mesh = fixtures::flat_square(3, 0.2);
  for (Vector2& uv : mesh.uvs) uv = 0.8 * uv + Vector2(0.1, 0.1);
  const Surface surface = make_surface(mesh);
  const Atlas atlas = make_atlas(surface, {{.width = 64, .height = 48}});
  const Image<float> image = paint(surface, atlas, [](const Vector3& p, int) {
    return Vector3(0.3 + 0.3 * p.x(), 0.5 - 0.2 * p.y(), 0.4);
  });
  int painted = 0;
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) {
      const double u = ((x + 0.5) / 64 - 0.1) / 0.8, v = (1 - (y + 0.5) / 48 - 0.1) / 0.8;
      if (image(x, y, 2) != 0.4f) continue;
      ++painted;
      EXPECT_NEAR(image(x, y, 0), 0.3 + 0.3 * u, 1e-6);
      EXPECT_NEAR(image(x, y, 1), 0.5 - 0.2 * v, 1e-6);
    }
  EXPECT_GT(painted, (0.8 * 64 + 4) * (0.8 * 48 + 4));  // the chart and a margin
  EXPECT_LT(painted, (0.8 * 64 + 8) * (0.8 * 48 + 8));
}

TEST(Paint, CoversEveryTexelOfTheCharts) {
  const Made& made = make("bust_3000");
  const int size = made.sample.texture.width;
  const Image<float> image = paint(made.surface, made.atlas,
                                   [](const Vector3&, int) -> Vector3 {
                                     return {1, 1, 1};
                                   },
                                   {.margin = 0, .background = {0, 0, 0}});
  double painted = 0;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) painted += image(x, y);
  EXPECT_NEAR(painted / made.atlas.texel_area, 1, 0.01);
}

TEST(Paint, MisalignedChartsDifferInExposure) {
  const Made made = make("cube", {.texture_size = 128});
  const auto field = [](const Vector3&, int) -> Vector3 { return {0.5, 0.5, 0.5}; };
  const ColorField bad = misaligned(field, {.exposure = 0.2, .white_balance = 0.1, .seed = 3});
  EXPECT_NE(bad({0, 0, 0}, 0), bad({0, 0, 0}, 1));
  EXPECT_EQ(bad({0, 0, 0}, 1), bad({0, 0, 0}, 1));
  for (int chart = 0; chart < 100; ++chart)
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(bad({0, 0, 0}, chart)[k] / 0.5, 1, 1.2 * 1.1 - 1 + 1e-12);
}

TEST(Samples, AreEqualBitsForEqualSeedsAndAnyNumberOfThreads) {
  const auto bits = [](std::uint64_t seed, std::size_t threads) {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const Sample sample =
        make_sample("bust", {.texture_size = 128, .triangles = 4000, .seed = seed});
    return std::pair(sample.mesh.uvs, paint(sample, Alignment::misaligned, seed));
  };
  const auto one = bits(1, 1);
  EXPECT_TRUE(one == bits(1, 2));
  EXPECT_TRUE(one == bits(1, 7));
  EXPECT_FALSE(one.second == bits(2, 2).second);
}

TEST(Samples, AreFoundByNameOnly) {
  const auto error_of = [](const std::string& name, const SampleOptions& options) {
    return fixtures::error_of([&] { make_sample(name, options); });
  };
  EXPECT_THAT(error_of("bustt", {}), HasSubstr("did you mean 'bust'"));
  EXPECT_THAT(error_of("cap_mobius", {}), HasSubstr("did you mean 'cap_moebius'"));
  EXPECT_THAT(error_of("cube", {.texture_size = 0}), HasSubstr("1 to 32768"));
  EXPECT_THAT(error_of("cube", {.triangles = -1}), HasSubstr("20 million"));
}

}  // namespace
}  // namespace mq

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "mq/base/error.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/tangent_frames.h"

namespace mq {
namespace {

using std::numbers::pi;

/// A grid of rows × columns squares, each cut in two; place(u, v) and uv(u, v) of u, v in [0, 1].
/// Corners where `cut` says so have texture coordinates of their own.
template <class Place, class Uv>
Mesh grid(int columns, int rows, const Place& place, const Uv& uv) {
  Mesh mesh;
  const auto id = [&](int i, int j) { return j * (columns + 1) + i; };
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i) {
      const double u = double(i) / columns, v = double(j) / rows;
      mesh.positions.push_back(place(u, v));
      mesh.uvs.push_back(uv(u, v));
    }
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      mesh.triangles.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      mesh.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  mesh.corner_uvs = mesh.triangles;
  return mesh;
}

Mesh plane(double turn = 0, double mirror = 1) {
  return grid(
      3, 2, [](double u, double v) { return Vector3(3 * u, 2 * v, 0); },
      [&](double u, double v) -> Vector2 {
        return Vector2(0.5, 0.5) + 0.1 * Vector2(Eigen::Rotation2Dd(turn) *
                                                 Vector2(mirror * (3 * u - 1.5), 2 * v - 1));
      });
}

SurfacePoint middle(int triangle) { return {triangle, Vector3(0.2, 0.3, 0.5)}; }

TEST(TangentFrames, OfAPlaneAreItsAxes) {
  const CornerFrames frames = tangent_frames(plane());
  ASSERT_EQ(frames.normals.size(), 36U);
  for (int t = 0; t < 12; ++t) {
    const TangentFrame f = frame_at(frames, middle(t));
    EXPECT_LT((f.tangent - Vector3::UnitX()).norm(), 1e-6);
    EXPECT_LT((f.bitangent - Vector3::UnitY()).norm(), 1e-6);
    EXPECT_LT((f.normal - Vector3::UnitZ()).norm(), 1e-6);
  }
}

TEST(TangentFrames, PointWhereTextureCoordinatesGrow) {
  for (const double mirror : {1.0, -1.0})
    for (const double turn : {0.3, pi / 2, 2.5}) {
      const Mesh mesh = plane(turn, mirror);
      const CornerFrames frames = tangent_frames(mesh);
      for (const Eigen::Vector4f& tangent : frames.tangents) EXPECT_EQ(tangent[3], float(mirror));
      const TangentFrame f = frame_at(frames, middle(5));
      // ∂uv/∂p = 0.1 R(turn) diag(mirror, 1): its rows are the gradients of u and v.
      EXPECT_LT((f.tangent - Vector3(mirror * std::cos(turn), -std::sin(turn), 0)).norm(), 1e-6);
      EXPECT_LT((f.bitangent - Vector3(mirror * std::sin(turn), std::cos(turn), 0)).norm(), 1e-6);
    }
}

/// Charts that lie turned and mirrored show the same normals when what they store is turned with them.
TEST(TangentFrames, GiveOneNormalWhereverTheChartLies) {
  const Vector3 n = Vector3(0.3, -0.5, 0.8).normalized();
  for (const double mirror : {1.0, -1.0})
    for (const double turn : {0.0, pi / 2, pi}) {
      const TangentFrame f = frame_at(tangent_frames(plane(turn, mirror)), middle(3));
      const Vector2 seen = Eigen::Rotation2Dd(turn) * Vector2(mirror * n.x(), n.y());
      EXPECT_LT((f.to_map(n) - Vector3(seen.x(), seen.y(), n.z())).norm(), 1e-6);
      EXPECT_LT((f.to_model(f.to_map(n)) - n).norm(), 1e-12);
    }
}

TEST(TangentFrames, OfACylinderFollowItsCirclesAndLines) {
  const int columns = 48;
  const Mesh mesh = grid(
      columns, 3,
      [](double u, double v) {
        return Vector3(std::cos(1.5 * pi * u), std::sin(1.5 * pi * u), 2 * v);
      },
      [](double u, double v) { return Vector2(u, v); });
  const CornerFrames frames = tangent_frames(mesh);
  for (int t = 0; t < mesh.triangle_count(); ++t)
    for (int k = 0; k < 3; ++k) {
      const Vector3 p = mesh.position(t, k);
      const double u = mesh.uv(t, k).x();
      if (u < 0.01 || u > 0.99) continue;  // at a border a vertex has half its triangles
      const TangentFrame f = frame_at(frames, {t, Vector3::Unit(k)});
      const Vector3 radial(p.x(), p.y(), 0);
      EXPECT_LT((f.normal - radial).norm(), 1e-6);
      EXPECT_LT((f.tangent - Vector3(-p.y(), p.x(), 0)).norm(), 1e-6);
      EXPECT_LT((f.bitangent - Vector3::UnitZ()).norm(), 1e-6);
    }
}

/// Second order in the edge length to the frames of the sphere itself, given its normals.
TEST(TangentFrames, OfASphereConvergeToItsMeridiansAndParallels) {
  const auto error = [](int n) {
    const auto place = [](double u, double v) {
      const double a = pi * u, b = 0.25 * pi + 0.5 * pi * v;
      return Vector3(std::sin(b) * std::cos(a), std::sin(b) * std::sin(a), -std::cos(b));
    };
    const Mesh mesh = grid(n, n, place, [](double u, double v) { return Vector2(u, v); });
    CornerFrames given;
    for (int t = 0; t < mesh.triangle_count(); ++t)
      for (int k = 0; k < 3; ++k) given.normals.push_back(mesh.position(t, k).cast<float>());
    const CornerFrames frames = tangent_frames(mesh, given);
    double most = 0;
    for (int t = 0; t < mesh.triangle_count(); ++t) {
      const SurfacePoint at = middle(t);
      const Vector2 uv = interpolate(at.barycentric, [&](int k) { return mesh.uv(t, k); });
      if ((uv - Vector2(0.5, 0.5)).cwiseAbs().maxCoeff() > 0.35) continue;
      const Vector3 normal = place(uv.x(), uv.y());
      const Vector3 along = Vector3(-normal.y(), normal.x(), 0).normalized();
      const TangentFrame f = frame_at(frames, at);
      most = std::max({most, (f.normal.normalized() - normal).norm(),
                       (f.tangent.normalized() - along).norm(),
                       (f.bitangent.normalized() - normal.cross(along)).norm()});
    }
    return most;
  };
  const double coarse = error(20), fine = error(40);
  EXPECT_LT(fine, 2e-3);
  EXPECT_GT(std::log2(coarse / fine), 1.8);
}

/// The two halves of a strip whose right half is mirrored in the texture meet at vertices of equal
/// texture coordinates, and have a tangent each.
TEST(TangentFrames, MirroredHalvesHaveOppositeTangents) {
  const Mesh mesh = grid(
      4, 1, [](double u, double v) { return Vector3(4 * u, v, 0); },
      [](double u, double v) { return Vector2(u < 0.5 ? u : 1 - u, v); });
  const CornerFrames frames = tangent_frames(mesh);
  for (int t = 0; t < mesh.triangle_count(); ++t)
    for (int k = 0; k < 3; ++k) {
      const double side = t < 4 ? 1 : -1;
      const TangentFrame f = frame_at(frames, {t, Vector3::Unit(k)});
      EXPECT_LT((f.tangent - side * Vector3::UnitX()).norm(), 1e-6) << t;
      EXPECT_LT((f.bitangent - Vector3::UnitY()).norm(), 1e-6);
    }
}

/// MikkTSpace's weights: a corner of two triangles whose ∂p/∂u differ has their mean by angles.
TEST(TangentFrames, OfACornerAreMeansByAngle) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {2, 0, 0}, {1, 1, 0}, {-1, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.uvs = {{0, 0}, {1, 0}, {0.5, 0.5}, {0, 0.5}};
  mesh.corner_uvs = mesh.triangles;
  mesh.uvs[3] = {0.25, 0.75};  // so that triangle 1 is sheared; 0 is laid out in proportion
  const Vector2 p(1, 1), q(-1, 1), a(0.5, 0.5), b(0.25, 0.75);
  const double area = a.x() * b.y() - b.x() * a.y();
  const Vector2 second = (Vector2(b.y() * p - a.y() * q) / area).normalized();
  const double first_angle = pi / 4, second_angle = pi / 2;
  const Vector2 sum = first_angle * Vector2(1, 0) + second_angle * second;
  const CornerFrames frames = tangent_frames(mesh);
  const Vector3 wanted = Vector3(sum.x(), sum.y(), 0).normalized();
  EXPECT_LT((frames.tangents[0].head<3>().cast<double>() - wanted).norm(), 1e-6);
  EXPECT_LT((frames.tangents[3].head<3>().cast<double>() - wanted).norm(), 1e-6);
  EXPECT_LT((frames.tangents[1].head<3>().cast<double>() - Vector3::UnitX()).norm(), 1e-6);
}

TEST(TangentFrames, KeepWhatIsGiven) {
  const Mesh mesh = plane();
  CornerFrames given;
  const Eigen::Vector3f n = Eigen::Vector3f(0.1F, 0.2F, 1).normalized();
  given.normals.assign(36, n);
  given.normals[4].setZero();
  given.tangents.assign(36, Eigen::Vector4f(0, 2, 0, -1));
  given.tangents[7].setConstant(std::nanf(""));
  const CornerFrames frames = tangent_frames(mesh, given);
  for (std::size_t c = 0; c < 36; ++c) {
    EXPECT_LT((frames.normals[c] - (c == 4 ? Eigen::Vector3f::UnitZ() : n)).norm(), 1e-6F);
    EXPECT_LT(std::abs(frames.normals[c].dot(frames.tangents[c].head<3>())), 1e-6F);
    EXPECT_NEAR(frames.tangents[c].head<3>().norm(), 1, 1e-6);
    EXPECT_EQ(frames.tangents[c][3], c == 7 ? 1 : -1);
  }
  EXPECT_LT((frames.tangents[7].head<2>() - Eigen::Vector2f(1, 0)).norm(), 0.05F);
  given.tangents.pop_back();
  EXPECT_THROW(tangent_frames(mesh, given), InvalidInput);
}

TEST(TangentFrames, HaveVolumeWhateverTheTrianglesAre) {
  Mesh mesh = plane();
  mesh.uvs[mesh.corner_uvs[0][1]] = mesh.uvs[mesh.corner_uvs[0][0]];  // no area in the texture
  mesh.uvs[mesh.corner_uvs[7][2]] = {std::nan(""), 0};
  mesh.positions[mesh.triangles[11][0]] = mesh.positions[mesh.triangles[11][1]];
  mesh.corner_uvs[9] = {-1, -1, -1};
  const CornerFrames frames = tangent_frames(mesh);
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const TangentFrame f = frame_at(frames, middle(t));
    EXPECT_GT(std::abs(f.tangent.cross(f.bitangent).dot(f.normal)), 0.1) << t;
  }
  EXPECT_TRUE(tangent_frames(Mesh()).normals.empty());
}

/// Opposite normals and tangents at the corners vanish between them.
TEST(TangentFrames, HaveVolumeWhereInterpolationVanishes) {
  CornerFrames frames;
  frames.normals.assign(3, Eigen::Vector3f::UnitZ());
  frames.normals[1] *= -1;
  frames.tangents.assign(3, Eigen::Vector4f(1, 0, 0, 1));
  frames.tangents[1][0] = -1;
  const TangentFrame f = frame_at(frames, {0, Vector3(0.5, 0.5, 0)});
  EXPECT_GT(std::abs(f.tangent.cross(f.bitangent).dot(f.normal)), 0.1);
  const Vector3 n = Vector3(1, 2, 3).normalized();
  EXPECT_LT((f.to_model(f.to_map(n)) - n).norm(), 1e-9);
}

TEST(TangentFrames, GiveBackTheUndisturbedNormalExactly) {
  const Mesh mesh = grid(
      8, 8, [](double u, double v) { return Vector3(u, v, 0.3 * std::sin(5 * u) * v); },
      [](double u, double v) { return Vector2(v, u); });
  const CornerFrames frames = tangent_frames(mesh);
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const TangentFrame f = frame_at(frames, middle(t));
    EXPECT_EQ(f.to_model(Vector3::UnitZ()), f.normal.normalized());
    EXPECT_EQ(f.to_model(Vector3::Zero()), f.normal.normalized());
  }
}

}  // namespace
}  // namespace mq

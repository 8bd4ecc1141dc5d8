// Photographs of a painted plane, whose cameras are then turned and moved.
#include "mq/draw/align_photographs.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <random>

#include "mq/draw/detail/parts_that_agree.h"

namespace mq {
namespace {

double paint(double x, double y) {
  return 0.5 + 0.12 * std::sin(17 * x + 3 * y) + 0.1 * std::cos(23 * y - 5 * x) + 0.08 * std::sin(9 * x * y + 11 * y);
}

/// Letters of four strokes on a plain ground, none nearer to another than its own size: most of what is shown is one
/// colour, in all photographs.
double print(double x, double y) {
  const double column = x / 0.16, row = y / 0.16;
  const double u = column - std::floor(column), v = row - std::floor(row);
  const int letter = int(std::floor(column)) + 3 * int(std::floor(row));
  if (u < 0.3 || u > 0.7 || v < 0.3 || v > 0.7) return 0.85;
  const bool stroke = u < 0.38 || v < 0.38 || (letter % 2 == 0 && u > 0.62) || (letter % 3 == 0 && v > 0.62);
  return stroke ? 0.15 : 0.85;
}

constexpr int side = 240;

/// Looks at the middle of the unit square from above, 1.6 away.
PinholeCamera camera_from(double angle, double tilt) {
  PinholeCamera camera;
  camera.width = camera.height = side;
  camera.fx = camera.fy = 260, camera.cx = camera.cy = side / 2.0;
  const Vector3 forward(-std::sin(tilt) * std::cos(angle), -std::sin(tilt) * std::sin(angle), -std::cos(tilt));
  const Vector3 right = Vector3(-std::sin(angle), std::cos(angle), 0), down = forward.cross(right);
  camera.rotation.row(0) = right, camera.rotation.row(1) = down, camera.rotation.row(2) = forward;
  camera.translation = -camera.rotation * (Vector3(0.5, 0.5, 0) - 1.6 * forward);
  return camera;
}

/// The point of the plane that a place of the picture shows.
Vector3 on_plane(const PinholeCamera& camera, double px, double py) {
  const Vector3 ray =
      camera.rotation.transpose() * Vector3((px - camera.cx) / camera.fx, (py - camera.cy) / camera.fy, 1);
  const Vector3 eye = camera.center();
  return eye - eye.z() / ray.z() * ray;
}

Image<float> photograph(const PinholeCamera& camera, double gain) {
  Image<float> picture(side, side, 1);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const Vector3 at = on_plane(camera, x + 0.5, y + 0.5);
      picture(x, y) = float(gain * paint(at.x(), at.y()));
    }
  return picture;
}

/// A pixel is the mean over nine places in it, rounded to 8 bits.
Image<float> photograph_of_print(const PinholeCamera& camera) {
  Image<float> picture(side, side, 1);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      double sum = 0;
      for (int k = 0; k < 9; ++k) {
        const Vector3 at = on_plane(camera, x + (k % 3 + 0.5) / 3, y + (k / 3 + 0.5) / 3);
        sum += print(at.x(), at.y()) / 9;
      }
      picture(x, y) = float(std::round(255 * sum) / 255);
    }
  return picture;
}

PinholeCamera shaken(PinholeCamera camera, std::mt19937& random) {
  std::normal_distribution<double> normal(0, 1);
  const Vector3 turn = 0.008 * Vector3(normal(random), normal(random), normal(random));
  const Eigen::Matrix3d rotation = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  camera.rotation = rotation * camera.rotation;
  camera.translation = rotation * camera.translation + 0.005 * Vector3(normal(random), normal(random), normal(random));
  return camera;
}

/// How far apart on the plane photographs put what is at one place, root mean square in pixels.
double disagreement(std::span<const Vector3> places, std::span<const PinholeCamera> truth,
                    std::span<const AlignedPhotograph> photographs) {
  double sum = 0, count = 0;
  for (const Vector3& place : places) {
    Vector3 mean = Vector3::Zero();
    std::vector<Vector3> shown;
    for (std::size_t v = 0; v < truth.size(); ++v)
      if (const auto at = photographs[v].camera.project(place)) shown.push_back(on_plane(truth[v], at->x(), at->y()));
    for (const Vector3& point : shown) mean += point / double(shown.size());
    for (const Vector3& point : shown) sum += (point - mean).squaredNorm(), count += 1;
  }
  return 260 / 1.6 * std::sqrt(sum / count);
}

/// Seven photographs of the unit square, of cameras that are said to be a little off, and places on it that all may show.
struct Shaken {
  /// `take`: the picture of the v-th camera.
  Shaken(int count, const std::function<Image<float>(const PinholeCamera&, int)>& take) {
    std::mt19937 random(5);
    for (int k = 0; k < count; ++k)
      places.emplace_back(0.1 + 0.8 * double(random() % 1000) / 1000, 0.1 + 0.8 * double(random() % 1000) / 1000, 0);
    for (int v = 0; v < 7; ++v) {
      truth.push_back(camera_from(0.9 * v, 0.15 + 0.05 * (v % 3)));
      photographs.push_back({shaken(truth.back(), random), take(truth.back(), v), {}, {}});
      for (int i = 0; i < count; ++i)
        photographs.back().places.push_back(i), photographs.back().weights.push_back(1);
    }
  }

  std::vector<Vector3> places;
  std::vector<PinholeCamera> truth;
  std::vector<AlignedPhotograph> photographs;
};

Image<float> exposed(const PinholeCamera& camera, int v) { return photograph(camera, 0.8 + 0.07 * v); }

TEST(AlignPhotographs, CamerasThatAreOffComeTogether) {
  auto [places, truth, photographs] = Shaken(3000, exposed);
  // One more, of places that no other shows.
  const PinholeCamera far = camera_from(2, 0.2);
  AlignedPhotograph& alone = photographs.emplace_back(AlignedPhotograph{far, photograph(far, 1), {}, {}});
  for (int k = 0; k < 200; ++k) {
    alone.places.push_back(int(places.size())), alone.weights.push_back(1);
    places.emplace_back(0.2 + 0.003 * k, 0.5 + 0.1 * std::sin(k), 0);
  }
  std::vector<AlignedPhotograph> one_thread = photographs;
  const double before = disagreement(places, truth, photographs);
  align_photographs(places, photographs);
  EXPECT_GT(before, 1.5);
  EXPECT_LT(disagreement(places, truth, photographs), 0.2);  // bends follow what lies between pixels
  for (std::size_t v = 0; v < truth.size(); ++v) EXPECT_GT(photographs[v].moved, 0);
  EXPECT_EQ(photographs.back().moved, 0) << "it shares nothing";
  EXPECT_EQ(photographs.back().camera.rotation, far.rotation);

  align_photographs(places, one_thread);
  for (std::size_t v = 0; v < truth.size(); ++v)
    EXPECT_EQ(one_thread[v].camera.rotation, photographs[v].camera.rotation);
}

TEST(AlignPhotographs, PhotographsOfAMeshThatIsOffAreBentTogether) {
  std::mt19937 random(6);
  std::vector<Vector3> places;  // on hills, where what is photographed is a plane
  for (int k = 0; k < 4000; ++k) {
    const double x = 0.1 + 0.8 * double(random() % 1000) / 1000, y = 0.1 + 0.8 * double(random() % 1000) / 1000;
    places.emplace_back(x, y, 0.03 * std::sin(12 * x) * std::cos(11 * y));
  }
  std::vector<PinholeCamera> truth;
  std::vector<AlignedPhotograph> photographs;
  for (int v = 0; v < 6; ++v) {
    truth.push_back(camera_from(1.05 * v, 0.5));
    photographs.push_back({truth.back(), photograph(truth.back(), 1), {}, {}});
    for (int i = 0; i < int(places.size()); ++i)
      photographs.back().places.push_back(i), photographs.back().weights.push_back(1);
  }
  const double before = disagreement(places, truth, photographs);
  align_photographs(places, photographs);
  EXPECT_GT(before, 0.9);
  EXPECT_LT(disagreement(places, truth, photographs), 0.5 * before);
  EXPECT_FALSE(photographs[0].camera.correction.empty());
}

/// Photographs exposed alike agree on the ground to their last bit, which says nothing of print.
TEST(AlignPhotographs, PrintOnAPlainGroundComesTogether) {
  auto [places, truth, photographs] =
      Shaken(4000, [](const PinholeCamera& camera, int) { return photograph_of_print(camera); });
  const double before = disagreement(places, truth, photographs);
  align_photographs(places, photographs);
  EXPECT_GT(before, 1.5);
  EXPECT_LT(disagreement(places, truth, photographs), 0.3);
}

/// Chequered, a third of what is seen wide and two thirds high.
void paste_passer_by(Image<float>& picture, double column, double row) {
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x)
      if (std::pow((x - column) / 24, 2) + std::pow((y - row) / 45, 2) < 1)
        picture(x, y) = (x / 7 + y / 11) % 2 == 0 ? 0.9F : 0.15F;
}

TEST(AlignPhotographs, PassersByMoveLittle) {
  auto [places, truth, clean] = Shaken(3000, exposed);
  std::vector<AlignedPhotograph> spoilt = clean;
  std::vector<Vector3> in_sight;  // of what is not behind any of them
  const std::vector<Vector2> stand = {{90, 130}, {150, 110}, {120, 140}};
  for (int v = 0; v < 7; v += 3)
    paste_passer_by(spoilt[std::size_t(v)].grey, stand[std::size_t(v / 3)].x(), stand[std::size_t(v / 3)].y());
  for (const Vector3& place : places) {
    bool hidden = false;
    for (int v = 0; v < 7; v += 3) {
      const Vector2 at = *truth[std::size_t(v)].project(place), from = at - stand[std::size_t(v / 3)];
      hidden = hidden || std::pow(from.x() / 34, 2) + std::pow(from.y() / 55, 2) < 1;
    }
    if (!hidden) in_sight.push_back(place);
  }
  ASSERT_GT(in_sight.size(), 500U);
  align_photographs(places, clean);
  align_photographs(places, spoilt);
  EXPECT_LT(disagreement(in_sight, truth, clean), 0.05);
  EXPECT_LT(disagreement(in_sight, truth, spoilt), 0.3);  // 0.7 where all that photographs show is believed alike
}

/// As plain as what it hides is, so that it is known by nothing but its brightness.
TEST(AlignPhotographs, SomebodyPlainBeforePlainThingsDoesNotShiftBrightness) {
  auto [places, truth, clean] = Shaken(3000, [](const PinholeCamera& camera, int v) {
    Image<float> picture = exposed(camera, v);
    for (float& value : picture.values()) value = 0.6F + 0.06F * value;  // hardly any contrast
    return picture;
  });
  std::vector<AlignedPhotograph> spoilt = clean;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side * 3 / 8; ++x) spoilt[3].grey(x, y) = 0.15F;
  align_photographs(places, clean);
  align_photographs(places, spoilt);
  EXPECT_NEAR(spoilt[3].moved, clean[3].moved, 0.5);
}

TEST(PartsThatAgree, AreToldFromOthersWhateverTheBrightness) {
  constexpr int columns = 12, rows = 10;
  std::vector<Compared> compared;
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform(0, 1);
  const auto other = [](int cell) { return cell % columns >= 7 && cell / columns >= 5; };
  const auto plain = [](int cell) { return cell / columns < 3; };
  for (int k = 0; k < 6000; ++k) {
    const int cell = int(random() % (columns * rows));
    const double agreed = plain(cell) ? 0.5 : 0.2 + 0.5 * uniform(random);
    compared.push_back({cell, other(cell) ? uniform(random) : 0.1 + 0.6 * agreed, agreed, 1});
  }
  const std::vector<float> found = parts_that_agree(compared, columns, rows, 0.02);
  for (int cell = 0; cell < columns * rows; ++cell) {
    const int column = cell % columns, row = cell / columns;
    if (column >= 8 && row >= 6) EXPECT_EQ(found[std::size_t(cell)], 0) << cell;
    if (column < 6 || row < 4) EXPECT_EQ(found[std::size_t(cell)], 1) << cell;
  }
}

TEST(AlignPhotographs, OneThatSharesNothingStays) {
  const PinholeCamera camera = camera_from(0, 0.2);
  std::vector<Vector3> places;
  for (int k = 0; k < 200; ++k) places.emplace_back(0.2 + 0.003 * k, 0.5 + 0.1 * std::sin(k), 0);
  std::vector<AlignedPhotograph> photographs = {{camera, photograph(camera, 1), {}, {}}};
  for (int i = 0; i < 200; ++i) photographs[0].places.push_back(i), photographs[0].weights.push_back(1);
  align_photographs(places, photographs);
  EXPECT_EQ(photographs[0].camera.rotation, camera.rotation);
  EXPECT_EQ(photographs[0].moved, 0);
}

}  // namespace
}  // namespace mq

#pragma once
/// One set of cameras, with pictures, in a folder.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "fixtures.h"
#include "io/folder.h"
#include "io/foreign_cameras.h"
#include "mq/base/error.h"
#include "mq/image/image.h"
#include "mq/io/cameras.h"
#include "mq/io/model.h"

namespace mq {

/// Three cameras that look at the origin from three sides, of pictures of 64 × 48 and one of 48 × 64.
class CameraFiles : public FolderTest, protected ForeignCameras {
 protected:
  static PinholeCamera camera(int k) {
    PinholeCamera c{.width = 64, .height = 48, .fx = 70.5, .fy = 70.5, .cx = 32, .cy = 24};
    if (k == 2) std::swap(c.width, c.height), std::swap(c.cx, c.cy);
    const Eigen::AngleAxisd tilt(2.8 + 0.1 * k, Vector3::UnitX()), turn(1.1 * k, Vector3::UnitY());
    const Eigen::AngleAxisd roll(0.2 * k - 0.1, Vector3::UnitZ());
    c.rotation = (roll * tilt * turn).toRotationMatrix();
    c.translation = Vector3(0.05 * k, -0.1, 3 + 0.25 * k);
    return c;
  }
  static std::string name(int k) { return fmt::format("photo {}.png", k); }

  CameraFiles() {
    for (int k = 0; k < 3; ++k) {
      set.push_back({name(k), camera(k)});
      write_image(folder / name(k), Image<float>(camera(k).width, camera(k).height, 3, 0.5F));
    }
  }

  /// How far apart two sets show points around the origin, pixels; the points must be seen.
  static double apart(const std::vector<Photograph>& a, const std::vector<Photograph>& b) {
    EXPECT_EQ(a.size(), b.size());
    double most = 0;
    int seen = 0;
    for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k)
      for (int i = 0; i < 27; ++i) {
        const Vector3 point(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
        const auto p = a[k].camera.project(0.3 * point), q = b[k].camera.project(0.3 * point);
        EXPECT_EQ(p.has_value(), q.has_value()) << k << ", " << i;
        if (!p || !q) continue;
        ++seen;
        most = std::max(most, (*p - *q).norm());
      }
    EXPECT_GT(seen, int(15 * a.size()));
    return most;
  }

  double apart_from_set(const std::string& path) const {
    const std::vector<Photograph> found = read_cameras(folder / path);
    for (std::size_t k = 0; k < found.size(); ++k)
      EXPECT_EQ(found[k].picture.filename(), set[k].picture) << path;
    return apart(set, found);
  }

  /// What reading refuses.
  std::string refused(const std::string& path) const {
    return fixtures::error_of<Error>([&] { read_cameras(folder / path); });
  }

  void put_bytes(const std::string& file, ByteView bytes) const { put(file, std::string(text_of(bytes))); }
};

}  // namespace mq

#include "mq/draw/photograph.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/draw/scene.h"
#include "mq/image/colour.h"
#include "mq/image/resample.h"
#include "mq/mesh/closest_point.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/surface_point.h"

namespace mq {

struct Projector::Shared {
  Scene scene;
  std::vector<Vector3> points, normals;
  double spacing, diagonal;

  Shared(const Surface& surface, std::span<const Vector3> places, double step,
         const Progress& progress)
      : scene(surface), spacing(step), diagonal(bounding_box(surface.mesh).diagonal()) {
    const Mesh& mesh = surface.mesh;
    const ClosestPointFinder closest(mesh);
    const std::vector<ClosestPoint> found = closest(places, progress);
    points.resize(places.size()), normals.resize(places.size());
    parallel_for(std::ssize(places), [&](std::int64_t i) {
      const ClosestPoint& at = found[i];
      points[i] = point_at(mesh, at);
      normals[i] = triangle_normal(mesh, at.triangle);
    });
  }

  bool clear(const PinholeCamera& camera, const Vector3& eye, const Vector3& point, double reach,
             double cosine, double bias) const;

  struct Sight {
    Vector2 place;  ///< in the picture
    double confidence;
  };
  /// Of place i; nothing where it is not shown.
  std::optional<Sight> look(const PinholeCamera& camera, const PhotographOptions& options,
                            std::size_t i) const;

  /// Whether the first thing on the line from the camera is the point itself.
  bool visible(const Vector3& eye, const Vector3& point, double bias) const {
    const Vector3 line = point - eye;
    const double distance = line.norm();
    const Hit hit = scene.hit({eye, line / distance});
    return hit.triangle < 0 || (hit.point - eye).norm() >= distance - bias;
  }
};

/// Whether the pixels around a point show the surface around it, and no outline runs between them:
/// four lines `reach` beside it end about as far away, as a surface so inclined does.
bool Projector::Shared::clear(const PinholeCamera& camera, const Vector3& eye, const Vector3& point,
                              double reach, double cosine, double bias) const {
  for (int k = 0; k < 4; ++k) {
    const Vector3 aside = (k % 2 ? 1 : -1) * reach * camera.rotation.row(k / 2).transpose();
    const Vector3 line = point + aside - eye;
    const double distance = line.norm();
    const Hit hit = scene.hit({eye, line / distance});
    const double most = bias + 4 * reach / cosine;
    if (hit.triangle < 0 || std::abs((hit.point - eye).norm() - distance) > most) return false;
  }
  return true;
}

Projector::Projector(const Surface& surface, std::span<const Vector3> places, double spacing,
                     const Progress& progress)
    : shared_(std::make_unique<Shared>(surface, places, spacing, progress)) {}
Projector::~Projector() = default;

std::optional<Projector::Shared::Sight> Projector::Shared::look(const PinholeCamera& camera,
                                                               const PhotographOptions& options,
                                                               std::size_t i) const {
  const Vector3 eye = camera.center();
  const Vector3 back = eye - points[i];
  const double distance = back.norm(), cosine = normals[i].dot(back) / distance;
  if (!(cosine > std::cos(options.steepest * std::numbers::pi / 180))) return std::nullopt;
  const auto place = camera.project(points[i]);
  const double bias = options.bias * diagonal;
  if (!place || !visible(eye, points[i], bias)) return std::nullopt;
  // Beside a fisheye z says nothing of the size of pixels, which the distance does.
  const double depth = std::max((camera.rotation * points[i] + camera.translation).z(), distance / 2);
  const double reach = options.outline * depth / camera.fx;
  if (reach > 0 && !clear(camera, eye, points[i], reach, cosine, bias)) return std::nullopt;
  const bool doubtful =
      options.doubtful > 1 && reach > 0 && !clear(camera, eye, points[i], options.doubtful * reach, cosine, bias);
  const double fine = spacing > 0 ? std::min(1.0, camera.fx * spacing / depth) : 1.0;
  const double inset =
      std::min({place->x(), place->y(), camera.width - place->x(), camera.height - place->y()});
  const double edge = options.border * std::min(camera.width, camera.height);
  return Sight{*place, (doubtful ? 0.1 : 1.0) * cosine * cosine * fine * (edge > 0 ? std::min(1.0, inset / edge) : 1.0)};
}

Partial Projector::project(const PinholeCamera& camera, const Image<float>& picture,
                           const PhotographOptions& options, const Progress& progress) const {
  require(picture.width() == camera.width && picture.height() == camera.height,
          fmt::format("the camera is of pictures of {} × {}, and the picture {} × {}", camera.width,
                      camera.height, picture.width(), picture.height()));
  std::vector<int> all(shared_->points.size());
  std::iota(all.begin(), all.end(), 0);
  return project(camera, picture, all, options, progress);
}

Partial Projector::project(const PinholeCamera& camera, const Image<float>& picture,
                           std::span<const int> places, const PhotographOptions& options,
                           const Progress& progress) const {
  const int channels = picture.channels(), colours = colour_channels(channels);
  const double across = double(picture.width()) / camera.width, down = double(picture.height()) / camera.height;
  Partial partial{Signal::Zero(std::ssize(places), colours), std::vector<double>(places.size(), 0.0)};
  parallel_blocks(std::ssize(places), 4096, [&](std::int64_t begin, std::int64_t end) {
    progress.check();
    std::vector<float> values(static_cast<std::size_t>(channels));
    for (std::int64_t i = begin; i < end; ++i) {
      const auto sight = shared_->look(camera, options, std::size_t(places[i]));
      if (!sight) continue;
      sample(picture, across * sight->place.x() - 0.5, down * sight->place.y() - 0.5, Wrap::clamp, values);
      const double alpha = colours < channels ? std::clamp(double(values.back()), 0.0, 1.0) : 1;
      for (int c = 0; c < colours; ++c) partial.values(i, c) = values[std::size_t(c)];
      partial.confidence[i] = alpha * sight->confidence;
    }
  });
  return partial;
}

std::vector<double> Projector::confidences(const PinholeCamera& camera, std::span<const int> places,
                                           const PhotographOptions& options, const Progress& progress) const {
  std::vector<double> result(places.size(), 0.0);
  parallel_blocks(std::ssize(places), 4096, [&](std::int64_t begin, std::int64_t end) {
    progress.check();
    for (std::int64_t i = begin; i < end; ++i)
      if (const auto sight = shared_->look(camera, options, std::size_t(places[i])))
        result[i] = sight->confidence;
  });
  return result;
}

Signal Projector::sampled(const PinholeCamera& camera, const Image<float>& picture,
                          std::span<const int> places) const {
  const int channels = picture.channels();
  const double across = double(picture.width()) / camera.width, down = double(picture.height()) / camera.height;
  Signal result = Signal::Zero(std::ssize(places), channels);
  parallel_blocks(std::ssize(places), 4096, [&](std::int64_t begin, std::int64_t end) {
    std::vector<float> values(static_cast<std::size_t>(channels));
    for (std::int64_t i = begin; i < end; ++i) {
      const auto place = camera.project(shared_->points[std::size_t(places[i])]);
      if (!place) continue;
      sample(picture, across * place->x() - 0.5, down * place->y() - 0.5, Wrap::clamp, values);
      for (int c = 0; c < channels; ++c) result(i, c) = values[std::size_t(c)];
    }
  });
  return result;
}

std::span<const Vector3> Projector::places() const { return shared_->points; }

double Projector::pixels_per_spacing(const PinholeCamera& camera, std::span<const int> places) const {
  double sum = 0, count = 0;
  for (const int i : places) {
    const double depth = (camera.rotation * shared_->points[std::size_t(i)] + camera.translation).z();
    if (depth > 0) sum += depth, count += 1;
  }
  return count > 0 ? camera.fx * shared_->spacing * count / sum : 0;
}

}  // namespace mq

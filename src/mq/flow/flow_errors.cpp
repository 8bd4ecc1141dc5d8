/// Baker et al., A database and evaluation methodology for optical flow, 2011, section 4.1; Menze
/// and Geiger, Object scene flow for autonomous vehicles, 2015, for what counts as an outlier.

#include "mq/flow/flow_errors.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "mq/base/error.h"

namespace mq {
namespace {

constexpr double outlier_pixels = 3, outlier_share = 0.05;

/// u and û of one pixel, in double.
struct Vectors {
  double u, v, true_u, true_v;

  double distance() const { return std::hypot(u - true_u, v - true_v); }

  /// Between (u, v, 1) and the true one, by sine and cosine: exact also for small angles.
  double angle() const {
    const double x = v - true_v, y = true_u - u, z = u * true_v - v * true_u;
    return std::atan2(std::hypot(x, y, z), u * true_u + v * true_v + 1);
  }
};

void require_alike(const Image<float>& field, const Image<float>& truth) {
  require(field.channels() == 2 && truth.channels() == 2 && field.width() == truth.width() &&
              field.height() == truth.height() && !field.empty(),
          fmt::format("two fields of one size with two values per pixel are wanted; found {} x {} "
                      "with {} and {} x {} with {}",
                      field.width(), field.height(), field.channels(), truth.width(),
                      truth.height(), truth.channels()));
}

std::optional<Vectors> vectors_at(const Image<float>& field, const Image<float>& truth, int x,
                                  int y) {
  const auto found = field.pixel(x, y), real = truth.pixel(x, y);
  if (!std::isfinite(real[0]) || !std::isfinite(real[1])) return {};
  const bool known = std::isfinite(found[0]) && std::isfinite(found[1]);
  return Vectors{known ? found[0] : 0.0, known ? found[1] : 0.0, real[0], real[1]};
}

}  // namespace

FlowErrors flow_errors(const Image<float>& field, const Image<float>& truth) {
  require_alike(field, truth);
  FlowErrors errors;
  double squares = 0;
  std::int64_t outliers = 0;
  for (int y = 0; y < field.height(); ++y)
    for (int x = 0; x < field.width(); ++x) {
      const auto vectors = vectors_at(field, truth, x, y);
      if (!vectors) continue;
      const double distance = vectors->distance();
      ++errors.pixels;
      errors.endpoint += distance;
      squares += distance * distance;
      errors.angular += vectors->angle();
      outliers += distance > outlier_pixels &&
                  distance > outlier_share * std::hypot(vectors->true_u, vectors->true_v);
    }
  require(errors.pixels > 0, "the true flow of no pixel is known");
  const double count = double(errors.pixels);
  errors.endpoint /= count;
  errors.endpoint_root_mean_square = std::sqrt(squares / count);
  errors.angular *= 180 / std::numbers::pi / count;
  errors.outliers = double(outliers) / count;
  return errors;
}

Image<float> endpoint_errors(const Image<float>& field, const Image<float>& truth) {
  require_alike(field, truth);
  Image<float> errors(field.width(), field.height(), 1, std::numeric_limits<float>::quiet_NaN());
  for (int y = 0; y < field.height(); ++y)
    for (int x = 0; x < field.width(); ++x)
      if (const auto vectors = vectors_at(field, truth, x, y))
        errors(x, y) = float(vectors->distance());
  return errors;
}

}  // namespace mq

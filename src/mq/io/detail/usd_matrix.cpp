// USD multiplies rows from the left, so that its matrices are the transposes of these. xformOp:rotateXYZ turns
// about x first; an orientation is a quaternion (w, x, y, z).
#include "mq/io/detail/usd_matrix.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "mq/base/error.h"
#include "mq/io/bytes.h"
#include "mq/mesh/mesh.h"

namespace mq {
namespace {

constexpr std::string_view inverse_mark = "!invert!", reset_mark = "!resetXformStack!", prefix = "xformOp:";
const std::string baked_points = "bake what moves it into its points";

class XformOp {
 public:
  XformOp(const UsdText& text, std::string_view value, std::string_view name)
      : text_(text), value_(value), numbers_(text.numbers(value)), name_(name) {}

  Eigen::Matrix4d matrix() const {
    std::string_view kind = name_.substr(prefix.size());
    kind = kind.substr(0, kind.find(':'));
    Eigen::Affine3d result = Eigen::Affine3d::Identity();
    if (kind == "translate") {
      result.translation() = vector();
    } else if (kind == "scale") {
      result.linear() = vector().asDiagonal();
    } else if (kind == "orient") {
      require_count(4);
      result.linear() =
          Eigen::Quaterniond(numbers_[0], numbers_[1], numbers_[2], numbers_[3]).normalized().toRotationMatrix();
    } else if (kind == "transform") {
      require_count(16);
      return Eigen::Matrix4d::Map(numbers_.data());
    } else if (kind.starts_with("rotate")) {
      result.linear() = rotation(kind.substr(6));
    } else {
      throw unknown();
    }
    return result.matrix();
  }

 private:
  Unsupported unknown() const {
    return Unsupported(fmt::format("{}: {} is not known; {}", text_.file(), shown(name_), baked_points));
  }

  void require_count(std::size_t count) const {
    if (numbers_.size() != count)
      text_.fail(value_, fmt::format("{} has {} numbers, wanted {}", shown(name_), numbers_.size(), count));
  }

  Vector3 vector() const {
    require_count(3);
    return {numbers_[0], numbers_[1], numbers_[2]};
  }

  /// Of axes such as "XYZ", the first of which turns first, or of one.
  Eigen::Matrix3d rotation(std::string_view axes) const {
    if (axes.empty() || axes.size() == 2 || axes.size() > 3 || axes.find_first_not_of("XYZ") != axes.npos)
      throw unknown();
    require_count(axes.size());
    Eigen::Matrix3d result = Eigen::Matrix3d::Identity();
    for (const char axis : axes) {
      const int k = axis - 'X';
      const double degrees = numbers_[axes.size() == 1 ? 0 : std::size_t(k)];
      result = Eigen::AngleAxisd(degrees * std::numbers::pi / 180, Vector3::Unit(k)).toRotationMatrix() * result;
    }
    return result;
  }

  const UsdText& text_;
  std::string_view value_;
  std::vector<double> numbers_;
  std::string_view name_;
};

}  // namespace

std::string_view usd_constant(const UsdText& text, const UsdPrim& prim, std::string_view name,
                              const std::string& remedy) {
  const UsdProperty* property = prim.property(name);
  if (!property) return {};
  if (property->samples.empty()) return property->value;
  for (const UsdSample& sample : property->samples)
    if (sample.value != property->samples.front().value)
      throw Unsupported(
          fmt::format("{}: {} of {} changes over time; {}", text.file(), name, shown(prim.name), remedy));
  return property->samples.front().value;
}

UsdTransform usd_transform(const UsdText& text, const UsdPrim& prim) {
  UsdTransform result;
  const UsdProperty* order = prim.property("xformOpOrder");
  if (!order) return result;
  for (std::string_view name : usd_words(order->value)) {
    if (name == reset_mark) {
      result = {.resets = true};
      continue;
    }
    const bool inverse = name.starts_with(inverse_mark);
    if (inverse) name.remove_prefix(inverse_mark.size());
    const std::string_view value = usd_constant(text, prim, name, baked_points);
    if (!name.starts_with(prefix) || value.empty())
      text.fail(order->value, fmt::format("it names {}, which {} does not have", shown(name), shown(prim.name)));
    const Eigen::Matrix4d matrix = XformOp(text, value, name).matrix();
    result.matrix *= inverse ? Eigen::Matrix4d(matrix.inverse()) : matrix;
  }
  return result;
}

}  // namespace mq

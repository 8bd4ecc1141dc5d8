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
  XformOp(const UsdText& text, const std::string& path, std::string_view value, std::string_view name)
      : text_(text), path_(path), value_(value), numbers_(text.numbers(value)), name_(name) {}

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
    return Unsupported(fmt::format("{}, {}: its {} is a transform that is not known; {}", text_.file(), path_,
                                   shown(name_), baked_points));
  }

  void require_count(std::size_t count) const {
    if (numbers_.size() != count)
      text_.fail(value_,
                 fmt::format("{}: its {} has {} numbers, wanted {}", path_, shown(name_), numbers_.size(), count));
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
  const std::string& path_;
  std::string_view value_;
  std::vector<double> numbers_;
  std::string_view name_;
};

}  // namespace

std::string_view usd_constant(const UsdText& text, const UsdPrim& prim, const std::string& path,
                              std::string_view name, const std::string& remedy) {
  const UsdProperty* property = prim.property(name);
  if (!property) return {};
  std::string_view constant = property->value;
  bool changes = property->has_spline;
  const UsdSample* first = nullptr;
  for (const UsdSample& sample : property->samples) {
    if (sample.value.empty()) continue;
    if (!first) constant = (first = &sample)->value;
    changes = changes || sample.value != constant;
  }
  if (changes)
    throw Unsupported(fmt::format("{}, {}: its {} changes over time; {}", text.file(), path, name, remedy));
  return constant;
}

UsdTransform usd_transform(const UsdText& text, const UsdPrim& prim, const std::string& path) {
  UsdTransform result;
  const UsdProperty* order = prim.property("xformOpOrder");
  if (!order) return result;
  for (std::string_view name : text.words(order->value)) {
    if (name == reset_mark) {
      result = {.resets = true};
      continue;
    }
    const bool inverse = name.starts_with(inverse_mark);
    if (inverse) name.remove_prefix(inverse_mark.size());
    const std::string_view value = usd_constant(text, prim, path, name, baked_points);
    if (!name.starts_with(prefix) || value.empty())
      text.fail(order->value, fmt::format("{}: xformOpOrder names {}, which has no value there; wanted one, or {}",
                                          path, shown(name), baked_points));
    const Eigen::Matrix4d matrix = XformOp(text, path, value, name).matrix();
    result.matrix *= inverse ? Eigen::Matrix4d(matrix.inverse()) : matrix;
  }
  return result;
}

}  // namespace mq

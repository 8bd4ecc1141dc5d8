#pragma once
/// Where a prim of USD stands (UsdGeomXformable).

#include <Eigen/Core>

#include "mq/io/detail/usd_text.h"

namespace mq {

/// The transform that the own xformOps of a prim at `path` make, parent from prim: the first of `xformOpOrder` is the
/// outermost. `resets` is set where it begins with !resetXformStack!, which leaves the parent's out. Throws
/// `Unsupported` where an operation changes over time, or is not known, and `IoError` with the line where it is
/// damaged.
struct UsdTransform {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  bool resets = false;
};
UsdTransform usd_transform(const UsdText& text, const UsdPrim& prim, const std::string& path);

/// The value of a property that must not change; empty: it has none. Throws `Unsupported` with `path` and `remedy`
/// where time samples differ, or it changes by a spline.
std::string_view usd_constant(const UsdText& text, const UsdPrim& prim, const std::string& path,
                              std::string_view name, const std::string& remedy);

}  // namespace mq

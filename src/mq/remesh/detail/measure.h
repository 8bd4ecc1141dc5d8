#pragma once
/// What local remeshing did, in numbers.

#include <vector>

#include "mq/mesh/closest_point.h"
#include "mq/remesh/remesh.h"

namespace mq {

/// Fills in the counts and distances of a result whose mesh and origins are there. `on_target` are
/// the points of the target nearest to the template's vertices, `on_template` the other way: what
/// did not change is not asked again.
void measure(Remeshed& result, const Surface& of_template, const Surface& target,
             const std::vector<ClosestPoint>& on_target,
             const std::vector<ClosestPoint>& on_template);

}  // namespace mq

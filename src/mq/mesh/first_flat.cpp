#include "mq/mesh/first_flat.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mq/mesh/geometry.h"

namespace mq {

double first_flat(std::span<const Triangle> triangles, std::span<const Vector2> x,
                  std::span<const Vector2> direction) {
  double first = std::numeric_limits<double>::infinity();
  for (const Triangle& t : triangles) {
    const Vector2 a = x[t[1]] - x[t[0]], b = x[t[2]] - x[t[0]];
    const Vector2 da = direction[t[1]] - direction[t[0]], db = direction[t[2]] - direction[t[0]];
    // area(s) = c0 + c1 s + c2 s² with c0 > 0; its smallest positive root
    const double c0 = cross(a, b), c1 = cross(a, db) + cross(da, b), c2 = cross(da, db);
    const double discriminant = c1 * c1 - 4 * c0 * c2;
    if (discriminant < 0) continue;
    const double q = -c1 + std::sqrt(discriminant);
    for (const double root : {q != 0 ? 2 * c0 / q : -1.0, c2 != 0 ? q / (2 * c2) : -1.0})
      if (root > 0) first = std::min(first, root);
  }
  return first;
}

}  // namespace mq

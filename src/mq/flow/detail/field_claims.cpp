#include "mq/flow/detail/field_claims.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mq {
namespace {

/// Of `misfit`, that a claim is made with.
constexpr float surest = 0.3F;

/// Motions that differ by less are one, pixels.
constexpr float same_motion = 1.5F;

/// Claims of one image, where p goes to p + factor·X(p).
Image<float> claims_of(const Image<float>& field, float factor, const Image<float>& misfit) {
  const int width = field.width(), height = field.height();
  Image<float> claims(width, height, 2, std::numeric_limits<float>::quiet_NaN());
  Image<float> least(width, height, 1, std::nextafter(surest, 1.0F));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const float cost = misfit(x, y), u = field(x, y, 0), v = field(x, y, 1);
      const int left = int(std::floor(float(x) + factor * u)), top = int(std::floor(float(y) + factor * v));
      for (int j = std::max(0, top); j <= std::min(height - 1, top + 1); ++j)
        for (int i = std::max(0, left); i <= std::min(width - 1, left + 1); ++i)
          if (cost < least(i, j)) {
            least(i, j) = cost;
            claims(i, j, 0) = u;
            claims(i, j, 1) = v;
          }
    }
  return claims;
}

}  // namespace

FieldClaims claimed(const Image<float>& field, double time, const Image<float>& misfit) {
  return {claims_of(field, float(-time), misfit), claims_of(field, float(1 - time), misfit)};
}

bool is_of_others(const Image<float>& claims, int x, int y, const float* way, const float* X) {
  const int i = std::clamp(int(std::lround(float(x) + way[0])), 0, claims.width() - 1);
  const int j = std::clamp(int(std::lround(float(y) + way[1])), 0, claims.height() - 1);
  const float u = claims(i, j, 0) - X[0], v = claims(i, j, 1) - X[1];
  return u * u + v * v > same_motion * same_motion;
}

FieldWays ways_along(const Image<float>& field, double time, FlowPath path) {
  return {displacement(field, -time, path), displacement(field, 1 - time, path)};
}

bool is_hidden(const Image<float>& field, const Image<float>& way, const Image<float>& claims, int x, int y) {
  return !lands_inside(way, x, y) || (!claims.empty() && is_of_others(claims, x, y, &way(x, y), &field(x, y)));
}

std::vector<char> seen_in_both(const Image<float>& field, const FieldClaims& claims) {
  const FieldWays ways = ways_along(field, 0.5, FlowPath::straight);
  std::vector<char> seen;
  for (int y = 0; y < field.height(); ++y)
    for (int x = 0; x < field.width(); ++x) seen.push_back(times_hidden(field, ways, claims, x, y) == 0);
  return seen;
}

}  // namespace mq

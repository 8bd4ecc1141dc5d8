#include "mq/track/detail/alone.h"

#include <cmath>

namespace mq {
namespace {

/// Points so many times farther from the other than the places they find there are from theirs, beyond the reach; and
/// all that hang together with these and are farther than this part of the reach.
constexpr double alone_times = 2, alone_part = 0.5;

}  // namespace

int nearest_corner(const Mesh& mesh, const ClosestPoint& p) {
  int corner = 0;
  p.barycentric.maxCoeff(&corner);
  return mesh.triangles[p.triangle][corner];
}

std::vector<char> alone(const Mesh& mesh, const std::vector<ClosestPoint>& from, const Mesh& other,
                        const std::vector<ClosestPoint>& back, double reach) {
  std::vector<char> found(from.size(), 0), open(from.size(), 0);
  bool any = false;
  for (std::size_t v = 0; v < from.size(); ++v) {
    const double distance = std::sqrt(from[v].squared_distance);
    open[v] = distance > alone_part * reach;
    if (!open[v]) continue;
    const double returned = std::sqrt(back[nearest_corner(other, from[v])].squared_distance);
    found[v] = distance > alone_times * returned + reach;
    any |= found[v] != 0;
  }
  for (bool grows = any; grows;) {
    grows = false;
    for (const Triangle& t : mesh.triangles) {
      if (!found[t[0]] && !found[t[1]] && !found[t[2]]) continue;
      for (const int v : t)
        if (open[v] && !found[v]) found[v] = 1, grows = true;
    }
  }
  return found;
}

}  // namespace mq

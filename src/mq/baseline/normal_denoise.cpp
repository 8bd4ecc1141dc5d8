// Both are means over neighbours in place and normal; the one repeats them on its own result, the
// other walks through the input.

#include "mq/baseline/normal_denoise.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/norm.h"

namespace mq {
namespace {

constexpr double reach = 3;           // in σ: what is farther counts less than 0.012
constexpr double still_below = 1e-3;  // a normal that turns by less has arrived

/// What both need of a mesh.
struct Facets {
  std::vector<double> area;
  std::vector<Vector3> normal, centroid;
  std::vector<int> begin, around;  ///< of each vertex its triangles with area
  double spacing = 0;              ///< mean distance of the centroids of neighbours

  explicit Facets(const Surface& surface)
      : area(triangle_areas(surface.mesh)),
        normal(triangle_normals(surface.mesh)),
        centroid(surface.mesh.triangles.size()),
        begin(surface.mesh.positions.size() + 1, 0) {
    const Mesh& mesh = surface.mesh;
    for (int t = 0; t < mesh.triangle_count(); ++t) {
      centroid[t] = (mesh.position(t, 0) + mesh.position(t, 1) + mesh.position(t, 2)) / 3;
      if (surface.degenerate[t]) area[t] = 0, normal[t].setZero();
      if (area[t] > 0)
        for (const int v : mesh.triangles[t]) ++begin[v + 1];
    }
    for (std::size_t v = 1; v < begin.size(); ++v) begin[v] += begin[v - 1];
    around.resize(begin.back());
    std::vector<int> next_place(begin.begin(), begin.end() - 1);
    for (int t = 0; t < mesh.triangle_count(); ++t)
      if (area[t] > 0)
        for (const int v : mesh.triangles[t]) around[next_place[v]++] = t;
    double sum = 0;
    std::int64_t count = 0;
    for (HalfEdge h = 0; h < HalfEdge(surface.twins.size()); ++h)
      if (surface.twins[h] > h) {
        sum += (centroid[h / 3] - centroid[surface.twins[h] / 3]).norm();
        ++count;
      }
    spacing = count > 0 ? sum / double(count) : 0;
  }
};

/// Calls f(t) for all triangles with area, many at once.
template <class Function>
void for_facets(const Facets& facets, std::int64_t block, const Progress& progress,
                const Function& f) {
  parallel_blocks(std::ssize(facets.area), block, [&](std::int64_t begin, std::int64_t end) {
    for (int t = int(begin); t < end; ++t)
      if (facets.area[t] > 0) f(t);
    progress.check();
  });
}

/// The triangles within a distance of each one, joined to it through triangles within; itself
/// first, in an order that depends on the mesh alone.
class Neighbourhoods {
 public:
  Neighbourhoods(const Mesh& mesh, const Facets& facets, double distance)
      : lists_(std::size_t(mesh.triangle_count())) {
    for_facets(facets, 1024, {}, [&](int t) { find(mesh, facets, distance, t, lists_[t]); });
  }

  const std::vector<int>& operator[](int t) const { return lists_[std::size_t(t)]; }

 private:
  static void find(const Mesh& mesh, const Facets& facets, double distance, int t,
                   std::vector<int>& found) {
    found.assign(1, t);
    std::vector<int> seen = found;
    for (std::size_t k = 0; k < found.size(); ++k)
      for (const int v : mesh.triangles[found[k]])
        for (int i = facets.begin[v]; i < facets.begin[v + 1]; ++i) {
          const int other = facets.around[i];
          const auto place = std::lower_bound(seen.begin(), seen.end(), other);
          if (place != seen.end() && *place == other) continue;
          seen.insert(place, other);
          if ((facets.centroid[other] - facets.centroid[t]).squaredNorm() <= distance * distance)
            found.push_back(other);
        }
  }

  std::vector<std::vector<int>> lists_;
};

void require_positive(double value, const char* what) {
  require(value > 0 && std::isfinite(value),
          fmt::format("{} is {}; it must be positive and finite", what, value));
}

/// Means around a triangle of normals near `normal`.
struct Mean {
  Vector3 normal = Vector3::Zero();
  Vector3 place = Vector3::Zero();
};
Mean mean_around(int t, const Vector3& normal, std::span<const int> neighbours,
                 const Facets& facets, const std::vector<Vector3>& normals, double place,
                 double difference) {
  Mean mean;
  double weights = 0;
  for (const int j : neighbours) {
    const double apart = (facets.centroid[t] - facets.centroid[j]).squaredNorm() / (place * place);
    const double turn = (normal - normals[j]).squaredNorm() / (difference * difference);
    const double weight = facets.area[j] * std::exp(-0.5 * (apart + turn));
    mean.normal += weight * normals[j];
    mean.place += weight * facets.centroid[j];
    weights += weight;
  }
  mean.normal = safe_unit(mean.normal);
  mean.place /= weights;
  return mean;
}

}  // namespace

std::vector<Vector3> bilateral_normals(const Surface& surface,
                                       const BilateralNormalOptions& options,
                                       const Progress& progress) {
  require_positive(options.place, "the reach of a bilateral filter");
  require_positive(options.difference, "the difference of normals of a bilateral filter");
  require(options.iterations >= 0, "a bilateral filter cannot have fewer iterations than none");
  const Facets facets(surface);
  const double place = options.place * facets.spacing;
  std::vector<Vector3> normals = facets.normal, next_normals = normals;
  if (!(place > 0) || options.iterations == 0) return normals;
  const Neighbourhoods neighbourhoods(surface.mesh, facets, reach * place);
  for (int k = 0; k < options.iterations; ++k) {
    progress.at(double(k) / options.iterations);
    for_facets(facets, 1024, progress, [&](int t) {
      const Vector3 mean =
          mean_around(t, normals[t], neighbourhoods[t], facets, normals, place, options.difference)
              .normal;
      next_normals[t] = mean.isZero(0) ? normals[t] : mean;
    });
    normals.swap(next_normals);
  }
  progress.at(1);
  return normals;
}

std::vector<Vector3> mean_shift_normals(const Surface& surface,
                                        const MeanShiftNormalOptions& options,
                                        const Progress& progress) {
  require_positive(options.place, "the bandwidth of a mean shift");
  require_positive(options.difference, "the bandwidth of normals of a mean shift");
  require(options.most_steps >= 0, "a mean shift cannot have fewer steps than none");
  const Facets facets(surface);
  const double place = options.place * facets.spacing;
  std::vector<Vector3> normals = facets.normal;
  if (!(place > 0) || options.most_steps == 0) return normals;
  const Neighbourhoods neighbourhoods(surface.mesh, facets, reach * place);
  for_facets(facets, 256, progress, [&](int t) {
    int at = t, before = t;
    for (int k = 0; k < options.most_steps; ++k) {
      const std::vector<int>& around = neighbourhoods[at];
      const Mean mean =
          mean_around(at, normals[t], around, facets, facets.normal, place, options.difference);
      if (mean.normal.isZero(0)) break;
      const double turn = (mean.normal - normals[t]).norm();
      normals[t] = mean.normal;
      const int next_place = *std::ranges::min_element(
          around, {}, [&](int j) { return (facets.centroid[j] - mean.place).squaredNorm(); });
      // The mean may lie between two centroids, which then take turns.
      if ((next_place == at || next_place == before) && turn < still_below) break;
      before = at;
      at = next_place;
    }
  });
  progress.at(1);
  return normals;
}

}  // namespace mq

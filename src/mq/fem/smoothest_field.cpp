#include "mq/fem/smoothest_field.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/fem/detail/returning_fields.h"
#include "mq/fem/exterior.h"
#include "mq/linear/direct.h"

namespace mq {
namespace {

/// What counts as a texture's smoothness: cells stretched more are slivers.
constexpr double most_stretch = 16;

void check_wishes(std::span<const WishedVector> wishes, const Surface& surface) {
  require(!wishes.empty(), "no vector is wished anywhere: the smoothest field would be 0");
  for (const WishedVector& wish : wishes) {
    if (wish.at.triangle < 0 || wish.at.triangle >= surface.triangle_count())
      throw InvalidInput(fmt::format("a vector is wished in triangle {} of {}", wish.at.triangle, surface.triangle_count()));
    if (!wish.vector.allFinite() || !wish.at.barycentric.allFinite() || !(wish.weight >= 0))
      throw InvalidInput(fmt::format("a vector wished in triangle {} is not finite", wish.at.triangle));
  }
}

double fading(const SmoothestFieldOptions& options, double area) {
  require(options.reach > 0 && options.hold > 0, "reach and hold are to be above 0");
  return 1 / std::min(options.reach * options.reach, 100 * area);
}

/// The weights and the weighted sums of what is wished at unknowns.
struct GatheredWishes {
  Vector weights, sums;  ///< one; two per unknown
  explicit GatheredWishes(int size) : weights(Vector::Zero(size)), sums(Vector::Zero(2 * Eigen::Index(size))) {}
  void add(int unknown, double weight, const Vector2& vector) {
    weights[unknown] += weight;
    sums.segment<2>(2 * Eigen::Index(unknown)) += weight * vector;
  }
};

}  // namespace

TangentField smoothest_field(const Surface& surface, std::span<const WishedVector> wishes,
                             const SmoothestFieldOptions& options, const Progress& progress) {
  check_wishes(wishes, surface);
  const double fade = fading(options, surface.area);
  const std::vector<FlatTriangle> shapes = flat_triangles(surface);
  const IntrinsicTriangulation delaunay = intrinsic_delaunay(surface, shapes);
  const ReturningFields back(surface, shapes, delaunay);
  const int vertices = surface.mesh.vertex_count();
  GatheredWishes gathered(vertices);
  for (const WishedVector& wish : wishes) {
    const int t = wish.at.triangle;
    if (shapes[std::size_t(t)].empty())
      throw InvalidInput(fmt::format("a vector is wished in triangle {}, which has no area", t));
    const Vector2 vector = frame_in_space(surface, t).transpose() * wish.vector;
    for (int k = 0; k < 3; ++k)
      gathered.add(surface.mesh.triangles[std::size_t(t)][k], options.hold * wish.weight * wish.at.barycentric[k],
                   back.at_vertex(3 * t + k, vector));
  }
  const HodgeStars stars = hodge_stars(make_edges(delaunay.surface, delaunay.shapes), delaunay.surface.mesh.triangles,
                                       delaunay.shapes, vertices);
  SparseMatrix A = connection_laplacian(delaunay.surface, delaunay.shapes) + fade * vertex_area_mass(stars.zero);
  Entries holds;
  for (int i = 0; i < 2 * vertices; ++i) holds.emplace_back(i, i, gathered.weights[i / 2]);
  A += sparse_matrix(2 * vertices, 2 * vertices, holds);
  const Vector z = DirectSolver(A, Factorisation::automatic, progress).solve(gathered.sums, progress);
  return field_in_space(surface, back.from_vertices(z));
}

SmoothestTexels smoothest_field(const TexelVectorSpace& vectors, std::span<const WishedVector> wishes,
                                const SmoothestFieldOptions& options, const Progress& progress) {
  check_wishes(wishes, vectors.surface());
  const Atlas& atlas = vectors.atlas();
  GatheredWishes gathered(vectors.size());
  for (const WishedVector& wish : wishes) {
    const int t = wish.at.triangle;
    if (atlas.chart[std::size_t(t)] < 0) continue;
    const TangentPlane here = vectors.plane_of(t);
    const std::complex<double> vector(here.first.dot(wish.vector), here.second.dot(wish.vector));
    for (const BasisWeight& basis : vectors.space().basis_at(t, wish.at.barycentric)) {
      if (!(basis.weight > 0)) continue;
      const std::complex<double> carried = here.turn(vectors.plane(basis.unknown)) * vector;
      gathered.add(basis.unknown, options.hold * wish.weight * basis.weight, {carried.real(), carried.imag()});
    }
  }
  require(gathered.weights.maxCoeff() > 0, "no vector is wished where the texture shows the surface");
  const double fade = fading(options, vectors.space().scale().area);
  BlockMatrix<double> A = vectors.regularised_system(fade, 1, vectors.bounded(most_stretch));
  for (int i = 0; i < vectors.size(); ++i)
    for (int e = A.starts[std::size_t(i)]; e < A.starts[std::size_t(i) + 1]; ++e)
      if (A.columns[std::size_t(e)] == i)
        A.blocks[std::size_t(e)][0] += gathered.weights[i], A.blocks[std::size_t(e)][3] += gathered.weights[i];
  BlockMultigrid multigrid(vectors.transfers(fade, 1, progress.step("levels", 0.3)), {.tolerance = options.tolerance});
  multigrid.set_matrix(std::move(A), progress.step("matrices", 0.2));
  SmoothestTexels result{Vector::Zero(2 * Eigen::Index(vectors.size())), {}};
  result.report = multigrid.solve(gathered.sums, result.field, progress.step("solve", 0.5));
  return result;
}

}  // namespace mq

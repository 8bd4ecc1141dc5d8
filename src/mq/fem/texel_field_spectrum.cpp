#include "mq/fem/texel_field_spectrum.h"

#include <cmath>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/linear/eigen.h"
#include "mq/mesh/geometry.h"

namespace mq {

FieldSpectrum texel_field_spectrum(const TexelVectorSpace& vectors, int count, const Progress& progress) {
  FieldSpectrum found;
  found.unknowns = 2 * std::int64_t(vectors.size());
  require(count >= 1 && count <= found.unknowns,
          fmt::format("{} eigenvalues were asked for; the texture has {}", count, found.unknowns));
  // Texels that hardly any point of the surface shows have next to nothing in either matrix.
  const SparseMatrix L = scalar_matrix(vectors.regularised_system(0, 1)), M = scalar_matrix(vectors.system(1, 0));
  const EigenPairs pairs = smallest_eigenpairs(L, M, {.count = count}, progress);
  found.values = pairs.values;
  const Surface& surface = vectors.surface();
  for (int k = 0; k < count; ++k) {
    TangentField field = vectors.on_triangles(pairs.vectors.col(k));
    double square = 0;
    for (int t = 0; t < surface.triangle_count(); ++t)
      square += triangle_area(surface.mesh, t) * field[std::size_t(t)].squaredNorm();
    if (square > 0)
      for (Vector3& vector : field) vector /= std::sqrt(square);
    found.fields.push_back(std::move(field));
  }
  return found;
}

}  // namespace mq

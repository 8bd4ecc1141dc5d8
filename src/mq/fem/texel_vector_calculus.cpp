#include "mq/fem/texel_vector_calculus.h"

#include <algorithm>
#include <complex>

#include "mq/base/error.h"
#include "mq/atlas/triangle_map.h"

namespace mq {
namespace {

/// visit(samples, map, plane, density) for the pieces of all triangles; `density` is area on the surface per texel².
template <class Visit>
void for_each_mapped_piece(const TexelVectorSpace& vectors, const Visit& visit) {
  const Surface& surface = vectors.surface();
  const Atlas& atlas = vectors.atlas();
  vectors.space().for_each_piece([&](const TexelSamples& samples) {
    const TriangleMap map(surface, atlas, samples.triangle);
    visit(samples, map, TangentPlane(map.normal()), texel_metric(surface, atlas, samples.triangle).density);
  });
}

/// ∫ ⟨turned(X), ∇φ_t⟩ dA.
template <class Turned>
Vector moments(const TexelVectorSpace& vectors, const Vector& z, const Turned& turned) {
  require(z.size() == 2 * std::int64_t(vectors.size()), "two components per texel are needed");
  Vector result = Vector::Zero(vectors.size());
  for_each_mapped_piece(vectors, [&](const TexelSamples& samples, const TriangleMap& map,
                                                             const TangentPlane& plane, double density) {
    const std::size_t count = samples.texels.size();
    std::vector<std::complex<double>> here(count);
    for (std::size_t k = 0; k < count; ++k) {
      const int i = samples.texels[k];
      here[k] = vectors.plane(i).turn(plane) * std::complex<double>(z[2 * i], z[2 * i + 1]);
    }
    for (Eigen::Index q = 0; q < samples.values.rows(); ++q) {
      std::complex<double> X = 0;
      for (std::size_t k = 0; k < count; ++k) X += samples.values(q, Eigen::Index(k)) * here[k];
      X = turned(X);
      const Vector2 way = map.texels(plane.in_space(X.real(), X.imag()));
      for (std::size_t k = 0; k < count; ++k)
        result[samples.texels[k]] += density * samples.weights[q] *
                                     (way.x() * samples.dx(q, Eigen::Index(k)) + way.y() * samples.dy(q, Eigen::Index(k)));
    }
  });
  return result;
}

}  // namespace

Vector divergence_moments(const TexelVectorSpace& vectors, const Vector& z) {
  return moments(vectors, z, [](std::complex<double> X) { return X; });
}

Vector curl_moments(const TexelVectorSpace& vectors, const Vector& z) {
  // ⟨X, JY⟩ = ⟨−JX, Y⟩
  return moments(vectors, z, [](std::complex<double> X) { return std::complex<double>(0, -1) * X; });
}

BlockMatrix<double> hodge_laplacian(const TexelVectorSpace& vectors) {
  BlockMatrix<double> H = vectors.system(0, 0);  // its pattern
  std::vector<std::complex<double>> turns, slopes;
  for_each_mapped_piece(vectors, [&](const TexelSamples& samples, const TriangleMap& map,
                                                             const TangentPlane& plane, double density) {
    const std::size_t count = samples.texels.size();
    turns.resize(count);
    for (std::size_t k = 0; k < count; ++k) turns[k] = vectors.plane(samples.texels[k]).turn(plane);
    std::vector<std::complex<double>> sums(count * count);
    slopes.resize(count);
    for (Eigen::Index q = 0; q < samples.values.rows(); ++q) {
      for (std::size_t k = 0; k < count; ++k) {
        const Vector3 slope = map.gradient({samples.dx(q, Eigen::Index(k)), samples.dy(q, Eigen::Index(k))});
        // div + i·curl of a vector X is conj(w)·X.
        slopes[k] = turns[k] * std::complex<double>(plane.first.dot(slope), -plane.second.dot(slope));
      }
      const double weight = density * samples.weights[q];
      for (std::size_t i = 0; i < count; ++i)
        for (std::size_t j = 0; j < count; ++j) sums[i * count + j] += weight * std::conj(slopes[i]) * slopes[j];
    }
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t j = 0; j < count; ++j) {
        const int row = samples.texels[i];
        const auto begin = H.columns.begin() + H.starts[std::size_t(row)],
                   end = H.columns.begin() + H.starts[std::size_t(row) + 1];
        const auto found = std::lower_bound(begin, end, samples.texels[j]);
        require(found != end && *found == samples.texels[j], "a piece couples texels that the matrix does not");
        std::array<double, 4>& block = H.blocks[std::size_t(found - H.columns.begin())];
        const double x = sums[i * count + j].real(), y = row == *found ? 0 : sums[i * count + j].imag();
        block[0] += x, block[1] -= y, block[2] += y, block[3] += x;
      }
  });
  return H;
}

}  // namespace mq

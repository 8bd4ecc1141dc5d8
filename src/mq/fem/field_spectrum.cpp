/// Every basis gives a pencil S, M, from which what has no mass is left out, and a way from its
/// coefficients to two components per triangle, in the frames of the surface.
///
/// The gradient basis needs no pencil of its own: with the lumped mass M₀ of functions and
/// S·φ = λ·M₀·φ, the fields ∇φ/√λ and J∇φ/√λ have the norm φᵀS·φ/λ = 1, and S·M₀⁻¹·S·φ = λ·S·φ.

#include "mq/fem/field_spectrum.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/fem/detail/returning_fields.h"
#include "mq/fem/exterior.h"
#include "mq/fem/intrinsic_delaunay.h"
#include "mq/fem/vector_basis.h"
#include "mq/fem/vertex_frames.h"
#include "mq/linear/connected_components.h"
#include "mq/linear/eigen.h"

namespace mq {
namespace {

/// Some of the unknowns, renumbered.
struct Kept {
  std::vector<int> number;  ///< per unknown its number among those kept, −1: left out
  int count = 0;
  explicit Kept(const std::vector<char>& keep) {
    for (const char k : keep) number.push_back(k ? count++ : -1);
  }

  SparseMatrix operator()(const SparseMatrix& A) const {
    Entries entries;
    for (int i = 0; i < A.outerSize(); ++i)
      for (SparseMatrix::InnerIterator entry(A, i); entry && number[i] >= 0; ++entry)
        if (number[entry.col()] >= 0)
          entries.emplace_back(number[i], number[entry.col()], entry.value());
    return sparse_matrix(count, count, entries);
  }

  /// 0 where it was left out.
  Vector whole(const Vector& x) const {
    Vector all = Vector::Zero(Eigen::Index(number.size()));
    for (std::size_t i = 0; i < number.size(); ++i)
      if (number[i] >= 0) all[Eigen::Index(i)] = x[number[i]];
    return all;
  }
};

std::vector<char> each_twice(const std::vector<char>& keep) {
  std::vector<char> twice;
  for (const char k : keep) twice.insert(twice.end(), 2, k);
  return twice;
}

std::vector<char> with_area(const std::vector<FlatTriangle>& shapes) {
  std::vector<char> keep(shapes.size());
  std::ranges::transform(shapes, keep.begin(), [](const FlatTriangle& s) { return !s.empty(); });
  return keep;
}

/// Vertices of triangles with area.
std::vector<char> reached(const Surface& surface, const std::vector<FlatTriangle>& shapes) {
  std::vector<char> keep(surface.mesh.positions.size(), 0);
  for (int t = 0; t < surface.triangle_count(); ++t)
    if (!shapes[t].empty())
      for (const int v : surface.mesh.triangles[t]) keep[v] = 1;
  return keep;
}

void require_unknowns(std::int64_t unknowns, int count) {
  require(count >= 1 && count <= unknowns,
          fmt::format("{} eigenvalues were asked for; the basis has {} on this surface", count,
                      unknowns));
}

class Spectrum {
 public:
  Spectrum(const Surface& surface, const FieldSpectrumOptions& options, const Progress& progress)
      : surface_(surface),
        options_(options),
        progress_(progress),
        shapes_(flat_triangles(surface)) {
    require(std::ranges::count(with_area(shapes_), 1) > 0, "the surface has no area");
  }

  FieldSpectrum find() {
    switch (options_.basis) {
      case FieldBasis::triangle: of_triangles(); break;
      case FieldBasis::gradient: of_gradients(); break;
      case FieldBasis::whitney: of_edges(); break;
      case FieldBasis::vertex: of_vertices(); break;
    }
    return std::move(found_);
  }

 private:
  /// A field of two components per triangle, scaled to ∫ |X|² dA = 1.
  void add(double value, Vector field) {
    double square = 0;
    for (std::size_t t = 0; t < shapes_.size(); ++t)
      square += shapes_[t].area() * field.segment<2>(2 * Eigen::Index(t)).squaredNorm();
    if (square > 0) field /= std::sqrt(square);
    values_.push_back(value);
    found_.values = Eigen::Map<const Vector>(values_.data(), Eigen::Index(values_.size()));
    found_.fields.push_back(field_in_space(surface_, field));
  }

  /// Eigenpairs of the pencil on what is kept, each as coefficients of all unknowns.
  template <class ToTriangles>
  void solve(const SparseMatrix& S, const SparseMatrix& M, const Kept& kept,
             const ToTriangles& to_triangles) {
    using Pencil = EigenOptions::Pencil;
    found_.unknowns = kept.count - found_.massless;
    require_unknowns(found_.unknowns, options_.count);
    const bool any = options_.centre == DualCentre::circumcentre_as_printed || options_.mass == WhitneyMass::one_point;
    const EigenPairs pairs = smallest_eigenpairs(
        kept(S), kept(M), {.pencil = any ? Pencil::any : Pencil::semidefinite, .count = options_.count}, progress_);
    for (int k = 0; k < options_.count; ++k)
      add(pairs.values[k], to_triangles(kept.whole(pairs.vectors.col(k))));
  }

  void of_triangles() {
    if (options_.centre != DualCentre::circumcentre) {
      const DualWeights weights = dual_weights(surface_, shapes_);
      const bool printed = options_.centre == DualCentre::circumcentre_as_printed;
      if (printed) found_.negative_weights = weights.negative;
      try {
        solve(vector_differences(surface_, shapes_, options_.centre), triangle_mass(shapes_),
              Kept(each_twice(with_area(shapes_))), [](const Vector& x) { return x; });
      } catch (const SolverError& error) {
        if (!printed) throw;
        throw SolverError(fmt::format("{} of {} edges are not Delaunay, so that circumcentres as printed give them "
                                      "negative weights, and the form is no smoothness: {}",
                                      weights.negative, weights.edges, error.what()));
      }
      return;
    }
    const IntrinsicTriangulation delaunay = intrinsic_delaunay(surface_, shapes_);
    found_.flips = delaunay.flips;
    const ReturningFields back(surface_, shapes_, delaunay);
    solve(vector_differences(delaunay.surface, delaunay.shapes, options_.centre),
          triangle_mass(delaunay.shapes), Kept(each_twice(with_area(delaunay.shapes))),
          [&](const Vector& x) { return delaunay.flips == 0 ? x : back.from_triangles(x); });
  }

  void of_edges() {
    const Edges edges = make_edges(surface_, shapes_);
    const HodgeStars stars =
        hodge_stars(edges, surface_.mesh.triangles, shapes_, surface_.mesh.vertex_count());
    const SparseMatrix M = whitney_mass(edges, shapes_), P = whitney_prolongation(edges, shapes_);
    if (options_.mass == WhitneyMass::one_point) found_.massless = massless_rotations(edges, shapes_);
    solve(hodge_laplacian(edges, stars, M), whitney_mass(edges, shapes_, options_.mass),
          Kept(std::vector<char>(std::size_t(edges.count()), 1)),
          [&](const Vector& omega) { return Vector(P * omega); });
  }

  void of_vertices() {
    const IntrinsicTriangulation delaunay = intrinsic_delaunay(surface_, shapes_);
    found_.flips = delaunay.flips;
    const ReturningFields back(surface_, shapes_, delaunay);
    const Surface& flipped = delaunay.surface;
    const HodgeStars stars =
        hodge_stars(make_edges(flipped, delaunay.shapes), flipped.mesh.triangles, delaunay.shapes,
                    flipped.mesh.vertex_count());
    solve(connection_laplacian(flipped, delaunay.shapes), vertex_area_mass(stars.zero),
          Kept(each_twice(reached(surface_, shapes_))),
          [&](const Vector& z) { return back.from_vertices(z); });
  }

  /// Functions on some of the vertices, and how many of them are constant on a component.
  struct Functions {
    Kept kept;
    int constants = 0;
    int count() const { return kept.count - constants; }
  };

  EigenPairs eigenfunctions(const Functions& functions, const SparseMatrix& S,
                            const SparseMatrix& M, int count, const Progress& progress) const {
    const int wanted = std::min(functions.kept.count, count + functions.constants);
    if (wanted == 0) return {};
    return smallest_eigenpairs(functions.kept(S), functions.kept(M), {.count = wanted}, progress);
  }

  void of_gradients() {
    const VertexSpace space(surface_);
    const HodgeStars stars = hodge_stars(make_edges(surface_, shapes_), surface_.mesh.triangles,
                                         shapes_, surface_.mesh.vertex_count());
    const SparseMatrix S = space.stiffness(), M = diagonal_matrix(stars.zero);
    std::vector<char> keep = reached(surface_, shapes_), inner = keep;
    for (HalfEdge h = 0; h < HalfEdge(surface_.twins.size()); ++h)
      if (const HalfEdge twin = surface_.twins[h];
          !shapes_[h / 3].empty() && (twin < 0 || shapes_[twin / 3].empty()))
        inner[surface_.mesh.triangles[h / 3][h % 3]] =
            inner[surface_.mesh.triangles[h / 3][(h + 1) % 3]] = 0;
    const Functions kappa{Kept(keep), constants(S, keep, keep)},
        xi{Kept(inner), constants(S, keep, inner)};
    found_.unknowns = kappa.count() + xi.count();
    require_unknowns(found_.unknowns, options_.count);
    const bool closed = inner == keep;
    const int count = closed ? (options_.count + 1) / 2 : options_.count;
    const EigenPairs gradients =
        eigenfunctions(kappa, S, M, count, progress_.step("gradients", closed ? 1 : 0.5));
    const EigenPairs turned_ones =
        closed ? gradients
               : eigenfunctions(xi, S, M, count, progress_.step("turned gradients", 0.5));
    add_sorted(space, kappa, gradients, xi, turned_ones);
  }

  /// How many components of the surface have all their vertices among `inner`.
  static int constants(const SparseMatrix& S, const std::vector<char>& keep,
                       const std::vector<char>& inner) {
    const std::vector<int> component = connected_components(S);
    std::vector<char> whole(component.size(), 0);
    for (std::size_t v = 0; v < keep.size(); ++v)
      if (keep[v]) whole[component[v]] = 1;
    for (std::size_t v = 0; v < keep.size(); ++v)
      if (keep[v] && !inner[v]) whole[component[v]] = 0;
    return int(std::ranges::count(whole, 1));
  }

  void add_sorted(const VertexSpace& space, const Functions& kappa, const EigenPairs& gradients,
                  const Functions& xi, const EigenPairs& turned_ones) {
    Eigen::Index i = kappa.constants, j = xi.constants;
    for (int k = 0; k < options_.count; ++k) {
      const bool turns =
          i >= gradients.values.size() ||
          (j < turned_ones.values.size() && turned_ones.values[j] < gradients.values[i]) ||
          (j < i && j < turned_ones.values.size() && turned_ones.values[j] == gradients.values[i]);
      const EigenPairs& from = turns ? turned_ones : gradients;
      Eigen::Index& at = turns ? j : i;
      Vector field = space.gradient((turns ? xi : kappa).kept.whole(from.vectors.col(at)));
      for (Eigen::Index t = 0; t < field.size() && turns; t += 2)
        field.segment<2>(t) = turned(Vector2(field.segment<2>(t)));
      add(from.values[at], std::move(field));
      ++at;
    }
  }

  const Surface& surface_;
  const FieldSpectrumOptions& options_;
  const Progress& progress_;
  std::vector<FlatTriangle> shapes_;
  std::vector<double> values_;
  FieldSpectrum found_;
};

}  // namespace

FieldSpectrum field_spectrum(const Surface& surface, const FieldSpectrumOptions& options,
                             const Progress& progress) {
  return Spectrum(surface, options, progress).find();
}

}  // namespace mq

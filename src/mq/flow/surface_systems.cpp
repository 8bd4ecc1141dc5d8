#include "mq/flow/surface_systems.h"

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/base/stopwatch.h"
#include "mq/fem/edges.h"
#include "mq/fem/exterior.h"
#include "mq/fem/vector_basis.h"
#include "mq/fem/vector_differences.h"

namespace mq {

namespace {

/// Of a usual diagonal value, so that nothing is singular where there is nothing to see.
constexpr double trace_of_mass = 1e-9;
constexpr double pin = 1e-8;        // of the mass, where a basis has constants that mean nothing
constexpr double rounding = 1e-12;  // of each diagonal value, which slivers have very large
constexpr double rest = 1e-3;       // c of `DataTerms::held`

using Block = BlockMatrix<double>::Block;

/// The rotation that takes vectors at the target of h to its source, as a block.
Block along(const FlowMesh& mesh, HalfEdge h, double factor) {
  const auto [c, s] = mesh.edge_turns()[h];
  return {factor * c, -factor * s, factor * s, factor * c};
}

void add(Block& to, const Block& B, double factor) {
  for (int k = 0; k < 4; ++k) to[k] += factor * B[k];
}

Block transposed(const Block& B) { return {B[0], B[2], B[1], B[3]}; }

/// R_iᵀ·G·R_j / 9 for rotations given by cosine and sine.
Block between(const std::array<double, 2>& i, const DataTerms::Triangle& G,
              const std::array<double, 2>& j) {
  const auto [c, s] = i;
  const auto [d, t] = j;
  const double a = c * G.xx + s * G.xy, b = c * G.xy + s * G.yy;  // first row of R_iᵀG
  const double e = c * G.xy - s * G.xx, f = c * G.yy - s * G.xy;  // second row
  return {(a * d + b * t) / 9, (b * d - a * t) / 9, (e * d + f * t) / 9, (f * d - e * t) / 9};
}

/// The median of a diagonal: slivers, whose values are large beyond measure, do not move it.
double usual_value(const SparseMatrix& A) {
  Vector diagonal = A.diagonal();
  if (diagonal.size() == 0) return 1;
  double* middle = diagonal.data() + diagonal.size() / 2;
  std::nth_element(diagonal.data(), middle, diagonal.data() + diagonal.size());
  return *middle > 0 ? *middle : diagonal.maxCoeff();
}

/// G as a matrix on vectors per triangle.
SparseMatrix data_matrix(const DataTerms& data) {
  Entries entries;
  for (std::size_t t = 0; t < data.triangles.size(); ++t) {
    const DataTerms::Triangle& G = data.triangles[t];
    const int i = 2 * int(t);
    entries.insert(entries.end(),
                   {{i, i, G.xx}, {i, i + 1, G.xy}, {i + 1, i, G.xy}, {i + 1, i + 1, G.yy}});
  }
  const int size = 2 * int(data.triangles.size());
  return sparse_matrix(size, size, entries);
}

/// Per vertex 1, or 0 on the boundary of what has area.
Vector away_from_boundary(const Surface& surface, const std::vector<FlatTriangle>& shapes) {
  Vector inner = Vector::Ones(surface.mesh.vertex_count());
  for (HalfEdge h = 0; h < HalfEdge(surface.twins.size()); ++h)
    if (const HalfEdge twin = surface.twins[h];
        !shapes[h / 3].empty() && (twin < 0 || shapes[twin / 3].empty()))
      for (const int k : {h % 3, (h + 1) % 3}) inner[surface.mesh.triangles[h / 3][k]] = 0;
  return inner;
}

/// Which coefficients of the gradient basis count, κ then ξ: ξ is 0 on the boundary, where
/// gradients and turned gradients would otherwise overlap.
Vector kept_potentials(const Vector& inner) {
  return (Vector(2 * inner.size()) << Vector::Ones(inner.size()), inner).finished();
}

/// `curl_and_div` with ξ = 0 on the boundary: the curl is measured at the other vertices alone.
SparseMatrix curl_and_div_inside(const VertexSpace& space, const Vector& areas,
                                 const Vector& inner) {
  const SparseMatrix S = curl_and_div(space, areas);
  if (inner.minCoeff() == 1) return S;
  const SparseMatrix stiffness = space.stiffness();
  const SparseMatrix held = inner.asDiagonal() * SparseMatrix(stiffness * inner.asDiagonal());
  const SparseMatrix weighted = areas.cwiseInverse().asDiagonal() * held;
  const SparseMatrix of_curl = held.transpose() * weighted;
  Entries entries;
  for (int i = 0; i < space.size(); ++i) {
    for (SparseMatrix::InnerIterator e(S, i); e; ++e)
      entries.emplace_back(i, int(e.col()), e.value());
    for (SparseMatrix::InnerIterator e(of_curl, i); e; ++e)
      entries.emplace_back(space.size() + i, space.size() + int(e.col()), e.value());
  }
  return sparse_matrix(2 * space.size(), 2 * space.size(), entries);
}

/// ‖D‖ of the triangle basis in the thesis' coefficients, along two edges of each triangle, whose
/// lengths are those of a surface of area 1.
double triangle_frobenius(const DataTerms& data, const VertexSpace& space) {
  double sum = 0;
  for (std::size_t t = 0; t < data.triangles.size(); ++t) {
    const DataTerms::Triangle& G = data.triangles[t];
    Eigen::Matrix2d edges, middle;
    edges << space.shapes()[t].corner(1), space.shapes()[t].corner(2);
    middle << G.xx, G.xy, G.xy, G.yy;
    sum += (edges.transpose() * middle * edges).squaredNorm();
  }
  return std::sqrt(sum) / space.scale().area;
}

}  // namespace

std::array<double, 2> DataTerms::products(const Vector& Y) const {
  const Eigen::Array2d sum = parallel_sum(
      std::ssize(triangles), Eigen::Array2d(0, 0), [&](std::int64_t begin, std::int64_t end) {
        Eigen::Array2d part(0, 0);
        for (std::int64_t t = begin; t < end; ++t) {
          const Triangle& G = triangles[t];
          const double x = Y[2 * t], y = Y[2 * t + 1];
          part += Eigen::Array2d(G.x * x + G.y * y, G.xx * x * x + 2 * G.xy * x * y + G.yy * y * y);
        }
        return part;
      });
  return {sum[0], sum[1]};
}

DataTerms DataTerms::held(const std::vector<FlatTriangle>& shapes, double area) const {
  DataTerms result = *this;
  const double share = area > 0 ? rest * trace / area : 0;
  parallel_for(std::ssize(triangles), [&](std::int64_t t) {
    result.triangles[t].xx += share * shapes[t].area();
    result.triangles[t].yy += share * shapes[t].area();
  });
  return result;
}

DataTerms data_terms(const VertexSpace& space, const Signal& difference, const Signal& gradient_of,
                     double robust, const Vector* field) {
  DataTerms data;
  data.triangles.resize(space.triangle_count());
  data.trace = parallel_sum(space.triangle_count(), 0.0, [&](std::int64_t begin, std::int64_t end) {
    double trace = 0;
    for (std::int64_t t = begin; t < end; ++t) {
      const FlatTriangle& shape = space.shapes()[t];
      if (shape.empty()) continue;
      const mq::Triangle& v = space.triangles()[t];
      const Vector2 g1 = shape.gradient(1), g2 = shape.gradient(2);
      const double area = shape.area();
      DataTerms::Triangle& G = data.triangles[t];
      for (Eigen::Index c = 0; c < difference.cols(); ++c) {
        const double m = gradient_of(v[0], c);
        const Vector2 slope = (gradient_of(v[1], c) - m) * g1 + (gradient_of(v[2], c) - m) * g2;
        const double delta = (difference(v[0], c) + difference(v[1], c) + difference(v[2], c)) / 3;
        double w = area;
        if (field != nullptr && robust > 0) {
          const double left = (delta + slope.dot(field->segment<2>(2 * t))) / robust;
          w /= std::sqrt(1 + left * left);
        }
        G.xx += w * slope.x() * slope.x();
        G.xy += w * slope.x() * slope.y();
        G.yy += w * slope.y() * slope.y();
        G.x += w * delta * slope.x();
        G.y += w * delta * slope.y();
      }
      trace += G.xx + G.yy;
    }
    return trace;
  });
  return data;
}

VertexSystem vertex_system(const FlowMesh& mesh, const DataTerms& data, double weight,
                           const std::vector<double>& shares) {
  const int vertices = mesh.vertex_count();
  const Mesh& m = mesh.surface().mesh;
  VertexSystem system;
  BlockMatrix<double>& A = system.matrix;
  system.right_hand_side = Vector::Zero(2 * std::int64_t(vertices));

  A.starts = mesh.space().row_starts();
  A.columns = mesh.space().columns();
  A.blocks.assign(A.starts[vertices], Block{});
  const double floor = trace_of_mass * (data.trace + weight * vertices) / std::max(1, vertices);

  parallel_for(vertices, [&](std::int64_t i) {
    const auto block = [&](int column) -> Block& {
      int e = A.starts[i];
      while (A.columns[e] != column) ++e;
      return A.blocks[e];
    };
    Block& own = block(int(i));
    own[0] = own[3] = floor;
    for (const int* corner = mesh.space().corners_begin(int(i));
         corner != mesh.space().corners_end(int(i)); ++corner) {
      const int t = *corner / 3, k = *corner % 3;
      const DataTerms::Triangle& G = data.triangles[t];
      const std::array<double, 2>& here = mesh.turns()[*corner];
      system.right_hand_side[2 * i] -= (here[0] * G.x + here[1] * G.y) / 3;
      system.right_hand_side[2 * i + 1] -= (here[0] * G.y - here[1] * G.x) / 3;
      add(own, between(here, G, here), 1);
      const double w = weight * (shares.empty() ? 1 : shares[t]);
      for (const int step : {1, 2}) {
        const int other = 3 * t + (k + step) % 3;
        Block& to = block(m.triangles[t][other % 3]);
        add(to, between(here, G, mesh.turns()[other]), 1);
        const HalfEdge h = step == 1 ? *corner : other;  // towards the other, or from it
        const double coupling = w * mesh.edge_weights()[h];
        own[0] += coupling;
        own[3] += coupling;
        const Block r = along(mesh, h, coupling);
        add(to, step == 1 ? r : transposed(r), -1);
      }
    }
  });
  return system;
}

/// Per triangle Σ over its edges of its part of the energy.
template <class Visit>
static void for_each_energy(const FlowMesh& mesh, const Vector& z, const Visit& visit) {
  const Mesh& m = mesh.surface().mesh;
  parallel_for(m.triangle_count(), [&](std::int64_t t) {
    double energy = 0;
    for (int k = 0; k < 3; ++k) {
      const HalfEdge h = 3 * int(t) + k;
      if (!(mesh.edge_weights()[h] > 0)) continue;
      const Block r = along(mesh, h, 1);
      const double *a = &z[2 * m.triangles[t][k]], *b = &z[2 * m.triangles[t][(k + 1) % 3]];
      const double x = a[0] - r[0] * b[0] - r[1] * b[1], y = a[1] - r[2] * b[0] - r[3] * b[1];
      energy += mesh.edge_weights()[h] * (x * x + y * y);
    }
    visit(t, energy);
  });
}

std::vector<double> smoothness_shares(const FlowMesh& mesh, const Vector& z, double robust) {
  std::vector<double> shares(mesh.surface().triangle_count(), 1.0);
  for_each_energy(mesh, z, [&](std::int64_t t, double energy) {
    const double area = mesh.space().shapes()[t].area();
    if (area > 0) shares[t] = 1 / std::sqrt(1 + energy / area / (robust * robust));
  });
  return shares;
}

double smoothness_energy(const FlowMesh& mesh, const Vector& z, const std::vector<double>& shares) {
  std::vector<double> energies(mesh.surface().triangle_count());
  for_each_energy(mesh, z,
                  [&](std::int64_t t, double energy) { energies[t] = shares.empty() ? energy : shares[t] * energy; });
  return parallel_sum(std::ssize(energies), 0.0, [&](std::int64_t begin, std::int64_t end) {
    double sum = 0;
    for (std::int64_t t = begin; t < end; ++t) sum += energies[t];
    return sum;
  });
}

static DataTerms no_data(std::size_t triangles) {
  DataTerms data;
  data.triangles.resize(triangles);
  return data;
}

DirectFlowSolver::DirectFlowSolver(const FlowMesh& mesh, FlowBasis basis,
                                   const std::optional<ThesisFlow>& thesis)
    : mesh_(mesh), basis_(basis), thesis_(thesis) {
  const Surface& surface = mesh.surface();
  const VertexSpace& space = mesh.space();
  const std::vector<FlatTriangle>& shapes = space.shapes();
  const Edges edges = make_edges(surface, shapes);
  const HodgeStars stars =
      hodge_stars(edges, surface.mesh.triangles, shapes, surface.mesh.vertex_count());
  switch (basis) {
    case FlowBasis::vertex:
      prolongation_ = vertex_prolongation(surface, shapes, mesh.frames());
      smoothness_ = scalar_matrix(vertex_system(mesh, no_data(shapes.size()), 1).matrix);
      pins_ = vertex_area_mass(stars.zero);
      break;
    case FlowBasis::triangle:
      prolongation_ = diagonal_matrix(Vector::Ones(2 * std::int64_t(shapes.size())));
      smoothness_ = vector_differences(surface, shapes,
                                       thesis ? DualCentre::barycentre : DualCentre::circumcentre);
      pins_ = prolongation_;
      break;
    case FlowBasis::gradient: {
      const Vector inner = away_from_boundary(surface, shapes);
      prolongation_ = gradient_prolongation(space) * kept_potentials(inner).asDiagonal();
      // Vertices of triangles without area are held like the others, so that no row is empty.
      const double usual = space.scale().area / double(stars.zero.size());
      const Vector areas = stars.zero.unaryExpr([&](double a) { return a > 0 ? a : usual; });
      smoothness_ = curl_and_div_inside(space, areas, inner);
      pins_ = diagonal_matrix((Vector(2 * areas.size()) << areas, areas).finished() /
                              space.scale().area);
      break;
    }
    case FlowBasis::whitney:
      prolongation_ = whitney_prolongation(edges, shapes);
      circulation_ = circulation_along_edges(surface, shapes, mesh.frames(), edges);
      // With the diagonal star rows have 11 entries; with the Whitney mass 29, and dearer factors.
      smoothness_ = hodge_laplacian(edges, stars, diagonal_matrix(stars.one));
      pins_ = diagonal_matrix(Vector::Ones(edges.count()));
      break;
  }
  transposed_ = prolongation_.transpose();
}

Vector DirectFlowSolver::coefficients_of(const Vector& at_vertices) const {
  require(basis_ != FlowBasis::gradient, "potentials do not follow from vectors at vertices");
  return basis_ == FlowBasis::whitney    ? Vector(circulation_ * at_vertices)
         : basis_ == FlowBasis::triangle ? mesh_.triangle_field(at_vertices)
                                         : at_vertices;
}

Vector DirectFlowSolver::solve(const DataTerms& data, double weight, const Progress& progress,
                               const std::function<void(const DirectSolver&)>& analysed) {
  const Stopwatch building;
  const SparseMatrix weighted = data_matrix(data) * prolongation_;
  const SparseMatrix D = transposed_ * weighted;
  if (thesis_) {
    // ½ε·S on the surface scaled to area 1, against D/‖D‖: ½ε‖D‖·S, where S of gradients and of
    // forms has the unit 1/area.
    const bool potentials = basis_ == FlowBasis::gradient || basis_ == FlowBasis::whitney;
    const double norm =
        potentials ? D.norm() * mesh_.space().scale().area : triangle_frobenius(data, mesh_.space());
    weight = 0.5 * thesis_->epsilon * norm;
  }
  SparseMatrix A = D + weight * smoothness_;
  const double pins =
      (basis_ == FlowBasis::gradient ? pin : trace_of_mass) * usual_value(A) / usual_value(pins_);
  A += pins * pins_ + diagonal_matrix(rounding * Vector(A.diagonal()));
  A.makeCompressed();
  Vector g(2 * std::int64_t(data.triangles.size()));
  for (std::size_t t = 0; t < data.triangles.size(); ++t)
    g.segment<2>(2 * std::int64_t(t)) = Vector2(data.triangles[t].x, data.triangles[t].y);
  const Vector b = -(transposed_ * g);
  cost_ = {.unknowns = A.rows(),
           .smoothness_entries = smoothness_.nonZeros(),
           .entries = A.nonZeros(),
           .build_seconds = building.seconds()};
  if (!factor_) {
    factor_.emplace(
        DirectSolver::analysed(A, Factorisation::automatic, progress.step("analysis", 0.1)));
    cost_.analyse_seconds = factor_->analyse_seconds();
    if (analysed) analysed(*factor_);
  }
  factor_->refactor(A, progress.step("factorisation", 1));
  cost_.factor_seconds = factor_->factor_seconds();
  const Stopwatch substituting;
  coefficients_ = factor_->solve(b, progress).col(0);
  weight_ = weight;
  cost_.substitute_seconds = substituting.seconds();
  return prolongation_ * coefficients_;
}

}  // namespace mq

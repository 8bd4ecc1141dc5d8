// Rows are gathered as those of the scalar matrices are, with the turns of each cell's texels made on the way: four
// rotations for a cell and row, less than keeping them would cost to read.

#include "mq/fem/texel_vector_space.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/fem/detail/texel_space_data.h"
#include "mq/atlas/triangle_map.h"
#include "mq/fem/texel_hierarchy.h"

namespace mq {
namespace {

using Complex = std::complex<double>;

/// One entry of a row of a complex matrix.
struct TurnedTerm {
  int column;
  Complex value;
};

/// Sorted by column, those of one column added up in the order they came.
void add_up(std::vector<TurnedTerm>& terms) {
  std::ranges::stable_sort(terms, {}, &TurnedTerm::column);
  std::size_t kept = 0;
  for (std::size_t k = 1; k < terms.size(); ++k)
    if (terms[k].column == terms[kept].column)
      terms[kept].value += terms[k].value;
    else
      terms[++kept] = terms[k];
  terms.resize(std::min(terms.size(), kept + 1));
}

/// Turns of some texels to the mean of their planes.
class Turns {
 public:
  template <class PlaneOf>
  void find(std::size_t count, const PlaneOf& plane_of) {
    planes_.clear();
    Vector3 sum = Vector3::Zero();
    for (std::size_t k = 0; k < count; ++k) {
      planes_.push_back(plane_of(k));
      sum += planes_.back().normal;
    }
    const TangentPlane mean(sum.norm() > 1e-6 ? sum : planes_.front().normal);
    turns_.clear();
    for (const TangentPlane& plane : planes_) turns_.push_back(plane.turn(mean));
  }
  const Complex& operator[](std::size_t k) const { return turns_[k]; }

 private:
  std::vector<TangentPlane> planes_;
  std::vector<Complex> turns_;
};

Complex at(const Vector& z, int i) { return {z[2 * i], z[2 * i + 1]}; }

}  // namespace

TangentPlane::TangentPlane(const Vector3& n) : normal(n.normalized()) {
  int least = 0;
  normal.cwiseAbs().minCoeff(&least);
  first = (Vector3::Unit(least) - normal[least] * normal).normalized();
  second = normal.cross(first);
}

Complex TangentPlane::turn(const TangentPlane& to) const {
  // R·v = v − ⟨v, n'⟩ (n + n') / (1 + ⟨n, n'⟩) of a v orthogonal to n, seen along axes orthogonal to n'.
  const double sum = 1 + normal.dot(to.normal);
  if (sum < 1e-9) return 1;
  const double share = first.dot(to.normal) / sum;
  return {to.first.dot(first) - share * to.first.dot(normal), to.second.dot(first) - share * to.second.dot(normal)};
}

TexelVectorSpace::TexelVectorSpace(const Surface& surface, const Atlas& atlas, const TexelSpace& space)
    : surface_(&surface), atlas_(&atlas), space_(&space), normals_(std::size_t(space.size())) {
  const TexelSpace::Data& d = *space.data_;
  std::vector<Vector3> normals(atlas.chart.size(), Vector3::Zero());
  for (std::size_t t = 0; t < normals.size(); ++t)
    if (atlas.chart[t] >= 0) normals[t] = TriangleMap(surface, atlas, int(t)).normal().normalized();
  parallel_for(space.size(), [&](std::int64_t i) {
    Vector3 own = Vector3::Zero(), any = Vector3::UnitZ();
    float largest = -1;
    d.for_each_cell(d.texels.places[std::size_t(i)], [&](const Incidence& cell) {
      if (!d.active(cell.cell)) return;
      const TexelCells::CutInfo info = d.cut_info(d.cells.kind[cell.cell]);
      if (info.triangle < 0) return;
      const Vector3& normal = normals[std::size_t(info.triangle)];
      if (info.largest > largest) largest = info.largest, any = normal;
      if (atlas.chart[std::size_t(info.triangle)] == d.texels.chart[std::size_t(i)])
        own += double(info.largest) * normal;
    });
    // Where triangles fold back on each other the largest one decides.
    const Vector3 normal = own.norm() > 0.1 * largest ? own.normalized() : any;
    normals_[std::size_t(i)] = {float(normal.x()), float(normal.y()), float(normal.z())};
  });
}

TangentPlane TexelVectorSpace::plane(int texel) const {
  return TangentPlane(normal(texel));
}

Vector3 TexelVectorSpace::normal(int texel) const {
  const auto& [x, y, z] = normals_[std::size_t(texel)];
  return Vector3(x, y, z).normalized();
}

BlockMatrix<double> TexelVectorSpace::system(double a, double b, std::span<const float> conductivity) const {
  const TexelSpace::Data& d = *space_->data_;
  require(conductivity.empty() || std::ssize(conductivity) == space_->element_count(),
          "one conductivity per element is needed");
  const auto factor = [&](int element) { return conductivity.empty() ? b : b * conductivity[std::size_t(element)]; };
  BlockMatrix<double> A;
  A.starts = d.row_starts();
  A.columns.resize(std::size_t(A.starts.back()));
  A.blocks.resize(A.columns.size());
  parallel_blocks(size(), 4096, [&](std::int64_t begin, std::int64_t end) {
    std::vector<TurnedTerm> terms;
    Turns turns;
    for (std::int64_t i = begin; i < end; ++i) {
      terms.clear();
      d.for_each_cell(d.texels.places[std::size_t(i)], [&](const Incidence& cell) {
        if (!d.active(cell.cell)) return;
        const CellIntegrals& integrals = d.integrals(cell.cell);
        turns.find(4, [&](std::size_t k) { return plane(d.unknown[cell.corners[k]]); });
        const double c = factor(cell.cell);
        double diagonal = 0;
        for (int k = 0; k < 4; ++k) {
          double value = a * integrals.mass[mass_at[cell.corner][k]];
          if (k != cell.corner) {
            const double s = c * integrals.stiffness[stiffness_at[cell.corner][k]];
            value += s;
            diagonal -= s;
          }
          terms.push_back({d.unknown[cell.corners[std::size_t(k)]],
                           value * std::conj(turns[std::size_t(cell.corner)]) * turns[std::size_t(k)]});
        }
        terms.push_back({int(i), diagonal});
      });
      for (const TexelSpace::Data::Part& part : d.blocks_of(int(i))) {
        const SeamBlocks::Block& block = d.cells.seams.blocks[part.block];
        const int* texels = d.cells.seams.texels.data() + block.first;
        turns.find(std::size_t(block.count), [&](std::size_t k) { return plane(texels[k]); });
        const Complex own = std::conj(turns[std::size_t(part.index)]);
        const double c = factor(d.element_of_block(part.block));
        std::size_t k = 0;
        d.visit_block(part, [&](int j, double m, double s) {
          terms.push_back({j, (a * m + c * s) * own * turns[k]});
          ++k;
        });
      }
      add_up(terms);
      int at = A.starts[std::size_t(i)];
      for (const TurnedTerm& term : terms) {
        A.columns[std::size_t(at)] = term.column;
        const double x = term.value.real(), y = term.column == i ? 0 : term.value.imag();
        A.blocks[std::size_t(at++)] = {x, -y, y, x};
      }
    }
  });
  return A;
}

BlockMatrix<double> TexelVectorSpace::regularised_system(double a, double b,
                                                         std::span<const float> conductivity) const {
  BlockMatrix<double> A = system(a, b, conductivity);
  const auto entry_of = [&](int i, int j) -> std::array<double, 4>* {
    const auto begin = A.columns.begin() + A.starts[std::size_t(i)], end = A.columns.begin() + A.starts[std::size_t(i) + 1];
    const auto found = std::lower_bound(begin, end, j);
    return found != end && *found == j ? &A.blocks[std::size_t(found - A.columns.begin())] : nullptr;
  };
  const auto add = [](std::array<double, 4>& block, double x, double y) {
    block[0] += x, block[1] -= y, block[2] += y, block[3] += x;
  };
  space_->data_->for_each_held(a, b, [&](int i, int j, double weight) {
    std::array<double, 4>* const coupling = entry_of(i, j);
    if (!coupling) return;
    const Complex turn = weight * plane(j).turn(plane(i));
    add(*coupling, -turn.real(), -turn.imag());
    add(*entry_of(j, i), -turn.real(), turn.imag());
    add(*entry_of(i, i), weight, 0);
    add(*entry_of(j, j), weight, 0);
  });
  return A;
}

std::vector<float> TexelVectorSpace::bounded(double stretch) const {
  const TexelSpace::Data& d = *space_->data_;
  std::vector<float> result(std::size_t(space_->element_count()), 1.0F);
  const double most = 4.0 / 3 * (stretch + 1 / stretch);  // the trace of a whole cell's matrix
  const auto bound = [most](double trace) { return trace > most ? float(most / trace) : 1.0F; };
  d.for_each_grid_cell([&](int id, const std::array<int, 4>&) {
    double trace = 0;
    for (const double s : d.integrals(id).stiffness) trace -= 2 * s;
    result[std::size_t(id)] = bound(trace);
  });
  for (std::size_t b = 0; b < d.cells.seams.blocks.size(); ++b) {
    const SeamBlocks::Block& block = d.cells.seams.blocks[b];
    double trace = 0;
    for (int i = 0; i < block.count; ++i)
      trace += d.cells.seams.stiffness[std::size_t(block.first_value + SeamBlocks::index(i, i, block.count))];
    result[std::size_t(d.element_of_block(int(b)))] = bound(trace);
  }
  return result;
}

/// visit(e, ∫_e |∇X|² dA, area_e), from several threads.
template <class Visit>
void TexelVectorSpace::for_each_energy(const Vector& z, const Visit& visit) const {
  require(z.size() == 2 * std::int64_t(size()), "two components per texel are needed");
  const TexelSpace::Data& d = *space_->data_;
  d.for_each_grid_cell([&](int id, const std::array<int, 4>& corners) {
    thread_local Turns turns;
    turns.find(4, [&](std::size_t k) { return plane(d.unknown[corners[k]]); });
    const CellIntegrals& cell = d.integrals(id);
    double energy = 0, area = 0;
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < 4; ++j) {
        area += cell.mass[mass_at[i][j]];
        if (i < j)
          energy -= cell.stiffness[stiffness_at[i][j]] *
                    std::norm(turns[i] * at(z, d.unknown[corners[i]]) - turns[j] * at(z, d.unknown[corners[j]]));
      }
    visit(id, energy, area);
  });
  const SeamBlocks& seams = d.cells.seams;
  parallel_for(std::ssize(seams.blocks), [&](std::int64_t b) {
    const SeamBlocks::Block& block = seams.blocks[std::size_t(b)];
    const int* texels = seams.texels.data() + block.first;
    thread_local Turns turns;
    turns.find(std::size_t(block.count), [&](std::size_t k) { return plane(texels[k]); });
    double energy = 0, area = 0;
    for (int i = 0; i < block.count; ++i)
      for (int j = i; j < block.count; ++j) {
        const auto value = std::size_t(block.first_value + SeamBlocks::index(i, j, block.count));
        area += (i == j ? 1 : 2) * seams.mass[value];
        if (i < j)
          energy -= seams.stiffness[value] * std::norm(turns[std::size_t(i)] * at(z, texels[i]) -
                                                       turns[std::size_t(j)] * at(z, texels[j]));
      }
    visit(d.element_of_block(int(b)), energy, area);
  });
}

std::vector<float> TexelVectorSpace::gradient_norms(const Vector& z) const {
  std::vector<float> norms(std::size_t(space_->element_count()), 0.0F);
  for_each_energy(z, [&](int e, double energy, double area) {
    if (area > 0 && energy > 0) norms[std::size_t(e)] = float(std::sqrt(energy / area));
  });
  return norms;
}

double TexelVectorSpace::smoothness_energy(const Vector& z, std::span<const float> conductivity) const {
  require(conductivity.empty() || std::ssize(conductivity) == space_->element_count(),
          "one conductivity per element is needed");
  std::vector<double> energies(std::size_t(space_->element_count()), 0.0);
  for_each_energy(z, [&](int e, double energy, double) {
    energies[std::size_t(e)] = conductivity.empty() ? energy : double(conductivity[std::size_t(e)]) * energy;
  });
  return parallel_sum(std::ssize(energies), 0.0, [&](std::int64_t begin, std::int64_t end) {
    return std::accumulate(energies.begin() + begin, energies.begin() + end, 0.0);
  });
}

TangentPlane TexelVectorSpace::plane_of(int triangle) const {
  return TangentPlane(TriangleMap(*surface_, *atlas_, triangle).normal());
}

Vector3 TexelVectorSpace::value(const Vector& z, int triangle, const Vector3& barycentric) const {
  const TangentPlane here = plane_of(triangle);
  Complex sum = 0;
  for (const BasisWeight& w : space_->basis_at(triangle, barycentric))
    sum += w.weight * plane(w.unknown).turn(here) * at(z, w.unknown);
  return here.in_space(sum.real(), sum.imag());
}

TangentField TexelVectorSpace::on_triangles(const Vector& z) const {
  require(z.size() == 2 * std::int64_t(size()), "two components per texel are needed");
  TangentField field(atlas_->chart.size(), Vector3::Zero());
  parallel_for(std::ssize(field), [&](std::int64_t t) {
    if (atlas_->chart[std::size_t(t)] < 0) return;
    const auto& p = atlas_->corners[std::size_t(t)];
    const double area = std::abs((p[1].column() - p[0].column()) * (p[2].row() - p[0].row()) -
                                 (p[1].row() - p[0].row()) * (p[2].column() - p[0].column())) / 2;
    const int n = std::clamp(int(std::ceil(std::sqrt(area))), 1, 32);
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < 2 * (n - i) - 1; ++j) {  // the n² triangles alike, row by row
        const double third = j % 2 == 0 ? 1.0 / 3 : 2.0 / 3;
        const double u = (i + third) / n, v = (j / 2 + third) / n;
        field[std::size_t(t)] += value(z, int(t), {1 - u - v, u, v}) / (n * n);
      }
  });
  return field;
}

template <class Counts>
Vector TexelVectorSpace::mean_around(const TangentField& field, const Counts& counts) const {
  require(field.size() == atlas_->chart.size(), "one vector per triangle is needed");
  Vector sums = Vector::Zero(2 * std::int64_t(size())), weights = Vector::Zero(size());
  space_->for_each_piece([&](const TexelSamples& samples) {
    const TangentPlane here = plane_of(samples.triangle);
    const Vector3& X = field[std::size_t(samples.triangle)];
    const Complex vector(here.first.dot(X), here.second.dot(X));
    const double density = texel_metric(*surface_, *atlas_, samples.triangle).density;
    for (std::size_t k = 0; k < samples.texels.size(); ++k) {
      const int i = samples.texels[k];
      if (!counts(samples.triangle, i)) continue;
      const double weight = density * samples.weights.dot(samples.values.col(Eigen::Index(k)));
      if (!(weight > 0)) continue;
      const Complex carried = weight * here.turn(plane(i)) * vector;
      sums.segment<2>(2 * i) += Vector2(carried.real(), carried.imag());
      weights[i] += weight;
    }
  });
  for (int i = 0; i < size(); ++i)
    if (weights[i] > 0) sums.segment<2>(2 * i) /= weights[i];
  return sums;
}

Vector TexelVectorSpace::from_triangles(const TangentField& field) const {
  return mean_around(field, [](int, int) { return true; });
}

std::vector<Complex> TexelVectorSpace::rightward() const {
  TangentField along(atlas_->chart.size(), Vector3::Zero());
  std::vector<int> first(atlas_->charts.size(), -1);  // triangle of each chart, for texels that none of it reaches
  for (std::size_t t = along.size(); t-- > 0;)
    if (atlas_->chart[t] >= 0) first[std::size_t(atlas_->chart[t])] = int(t);
  parallel_for(std::ssize(along), [&](std::int64_t t) {
    if (atlas_->chart[std::size_t(t)] < 0) return;
    const TriangleMap map(*surface_, *atlas_, int(t));
    const Vector3 way = map.way({1, 0});
    along[std::size_t(t)] = way.normalized();
  });
  const std::vector<int>& chart = space_->texels().chart;
  const Vector mean = mean_around(
      along, [&](int triangle, int i) { return atlas_->chart[std::size_t(triangle)] == chart[std::size_t(i)]; });
  std::vector<Complex> result(std::size_t(size()), Complex(1, 0));
  for (int i = 0; i < size(); ++i)
    if (const double length = std::abs(at(mean, i)); length > 1e-12) {
      result[std::size_t(i)] = at(mean, i) / length;
    } else if (const int own = chart[std::size_t(i)]; own >= 0 && first[std::size_t(own)] >= 0) {
      const TangentPlane there = plane_of(first[std::size_t(own)]);
      const Vector3& X = along[std::size_t(first[std::size_t(own)])];
      result[std::size_t(i)] = there.turn(plane(i)) * Complex(there.first.dot(X), there.second.dot(X));
    }
  return result;
}

std::vector<std::array<double, 2>> TexelVectorSpace::velocities(const Vector& z) const {
  require(z.size() == 2 * std::int64_t(size()), "two components per texel are needed");
  const TexelSpace::Data& d = *space_->data_;
  std::vector<Vector3> in_space;
  in_space.resize(std::size_t(size()));
  parallel_for(size(), [&](std::int64_t i) {
    in_space[std::size_t(i)] = plane(int(i)).in_space(z[2 * i], z[2 * i + 1]);
  });
  std::vector<std::array<double, 2>> result(std::size_t(d.grid.cell_count()));
  d.for_each_grid_cell([&](int id, const std::array<int, 4>& corners) {
    const int triangle = d.cut_info(d.cells.kind[id]).triangle;
    if (triangle < 0) return;
    const TriangleMap map(*surface_, *atlas_, triangle);
    const Vector3 here = map.normal().normalized();
    Vector3 sum = Vector3::Zero();
    for (const int corner : corners) {
      const int i = d.unknown[corner];
      sum += 0.25 * carried(in_space[std::size_t(i)], normal(i), here);
    }
    const Vector2 velocity = map.texels(sum);
    result[std::size_t(id)] = {velocity.x(), velocity.y()};
  });
  return result;
}

Signal TexelVectorSpace::gradient(const Signal& psi) const {
  require(psi.rows() == size(), "one row per texel is needed");
  const TexelSpace::Data& d = *space_->data_;
  const Eigen::Index channels = psi.cols();
  Signal result = Signal::Zero(2 * std::int64_t(size()), channels);
  parallel_blocks(size(), 4096, [&](std::int64_t begin, std::int64_t end) {
    Eigen::Matrix3Xd sum(3, channels);
    for (std::int64_t i = begin; i < end; ++i) {
      const TangentPlane here = plane(int(i));
      double total = 0;
      sum.setZero();
      d.for_each_cell(d.texels.places[std::size_t(i)], [&](const Incidence& cell) {
        if (!d.active(cell.cell)) return;
        const TexelCells::CutInfo info = d.cut_info(d.cells.kind[cell.cell]);
        if (info.triangle < 0) return;
        // Cells near seams have their integrals elsewhere: what lies in them counts alike.
        const double share = info.surface;
        const TriangleMap map(*surface_, *atlas_, info.triangle);
        const Vector3 there = map.normal().normalized();
        total += share;
        for (Eigen::Index c = 0; c < channels; ++c) {
          const auto of = [&](std::size_t k) { return psi(d.unknown[cell.corners[k]], c); };
          const Vector2 rates(of(1) - of(0) + of(3) - of(2), of(2) - of(0) + of(3) - of(1));
          sum.col(c) += carried(0.5 * share * map.gradient(rates), there, here.normal);
        }
      });
      if (!(total > 0)) continue;
      result.row(2 * i) = here.first.transpose() * sum / total;
      result.row(2 * i + 1) = here.second.transpose() * sum / total;
    }
  });
  return result;
}

std::vector<std::shared_ptr<const BlockTransfer>> TexelVectorSpace::transfers(double a, double b,
                                                                              const Progress& progress) const {
  const SparseMatrix A = space_->regularised_system(a, b);
  const Hierarchy hierarchy = texel_hierarchy(A, space_->texels(), {}, progress);
  std::vector<Vector3> normals(normals_.size());
  for (std::size_t i = 0; i < normals.size(); ++i) normals[i] = Vector3(normals_[i][0], normals_[i][1], normals_[i][2]);
  std::vector<std::shared_ptr<const BlockTransfer>> result;
  for (const auto& level : hierarchy.multigrid().levels) {
    const LevelTransfer& scalar = *level->transfer;
    if (std::size_t(scalar.coarse_rows()) >= normals.size()) break;  // charts of a few texels: no coarser level
    std::vector<Vector3> coarse(std::size_t(scalar.coarse_rows()), Vector3::Zero());
    parallel_for(std::ssize(coarse), [&](std::int64_t j) {
      std::vector<WeightedIndex> children;
      scalar.children(int(j), children);
      Vector3 sum = Vector3::Zero();
      for (const WeightedIndex& child : children) sum += double(child.weight) * normals[std::size_t(child.index)];
      coarse[std::size_t(j)] = sum.norm() > 1e-6 ? sum.normalized() : Vector3(Vector3::UnitZ());
    });
    auto P = std::make_shared<BlockTransfer>();
    P->columns = scalar.coarse_rows();
    std::array<WeightedIndex, 4> parents;
    for (int i = 0; i < scalar.fine_rows(); ++i)
      P->starts.push_back(P->starts.back() + scalar.parents(i, parents));
    P->entries.resize(std::size_t(P->starts.back()));
    parallel_for(scalar.fine_rows(), [&](std::int64_t i) {
      std::array<WeightedIndex, 4> of_row;
      const int count = scalar.parents(int(i), of_row);
      const TangentPlane fine(normals[std::size_t(i)]);
      for (int k = 0; k < count; ++k) {
        const WeightedIndex& parent = of_row[std::size_t(k)];
        const Complex turn = double(parent.weight) * TangentPlane(coarse[std::size_t(parent.index)]).turn(fine);
        P->entries[std::size_t(P->starts[std::size_t(i)] + k)] = {parent.index, float(turn.real()), float(turn.imag())};
      }
    });
    P->finish();
    normals = std::move(coarse);
    result.push_back(std::move(P));
  }
  return result;
}

}  // namespace mq

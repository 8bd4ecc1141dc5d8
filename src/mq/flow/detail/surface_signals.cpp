/// Light is what varies slowly: Smooth(φ, length²), found on the coarsest mesh that shows the
/// length.

#include "mq/flow/detail/surface_signals.h"

#include <cmath>

#include "mq/base/parallel.h"
#include "mq/fem/vertex_multigrid.h"
#include "mq/linear/conjugate_gradients.h"

namespace mq {

namespace {

constexpr double spacings_per_light = 2;  // of the mesh on which light is found, at least

/// Means and variances of the channels.
struct SurfaceMoments {
  Eigen::RowVectorXd mean, variance;

  SurfaceMoments(const Vector& mass, const Signal& signal) {
    const double total = mass.sum();
    mean = mass.transpose() * signal / total;
    variance = mass.transpose() * (signal.rowwise() - mean).array().square().matrix() / total;
  }
};

}  // namespace

Signal smoothed(const FlowMesh& mesh, const Signal& signal, double weight, double tolerance) {
  if (!(weight > 0)) return signal;
  const SparseMatrix A = mesh.space().system(1, weight);
  const Signal change = -weight * mesh.space().stiffness_times(signal);
  Signal correction = Signal::Zero(signal.rows(), signal.cols());
  const double spacing = mesh.spacing();
  if (weight > 100 * spacing * spacing)
    vertex_multigrid_solver(mesh.surface().mesh.positions, {.tolerance = tolerance})(A, {})->solve(
        change, correction);
  else
    conjugate_gradients(A, change, correction, jacobi_preconditioner(A), {.tolerance = tolerance});
  return signal + correction;
}

Signal without_light(const FlowMeshes& meshes, const Signal& signal, double detail, LightOn where) {
  if (!(detail > 0)) return signal;
  int m = 0;
  const bool exact = where == LightOn::finest;
  while (!exact && m + 1 < meshes.count() && meshes[m + 1].spacing() * spacings_per_light <= detail)
    ++m;
  Signal low = signal;
  for (int k = 0; k < m; ++k) low = meshes.restricted(k, low);
  low = smoothed(meshes[m], low, detail * detail, exact ? 1e-6 : 1e-3);
  for (int k = m; k > 0; --k) low = meshes.prolongated(k - 1, low);
  return signal - low;
}

Signal with_slopes(const FlowMesh& mesh, const Signal& signal, double factor) {
  const Signal gradients = mesh.space().gradient(signal);
  const Eigen::Index channels = signal.cols();
  Signal result(signal.rows(), 2 * channels);
  result.leftCols(channels) = signal;
  parallel_for(signal.rows(), [&](std::int64_t v) {
    Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(channels);
    double area = 0;
    for (const int* c = mesh.space().corners_begin(int(v)); c != mesh.space().corners_end(int(v));
         ++c) {
      const double share = mesh.space().shapes()[*c / 3].area();
      sum += share * gradients.middleRows(2 * (*c / 3), 2).colwise().squaredNorm();
      area += share;
    }
    result.row(v).tail(channels) = factor * (sum / (area > 0 ? area : 1)).cwiseSqrt();
  });
  return result;
}

void bring_to_scale(const FlowMesh& mesh, Signal& source, Signal& target) {
  const SurfaceMoments of_source(mesh.lumped_mass(), source), of_target(mesh.lumped_mass(), target);
  const Eigen::RowVectorXd mean = (of_source.mean + of_target.mean) / 2;
  const auto bring = [&](Signal& signal, double variance) {
    signal.rowwise() -= mean;
    if (variance > 0) signal /= std::sqrt(variance);
  };
  bring(source, of_source.variance.mean());
  bring(target, of_target.variance.mean());
}

void bring_to_scale_of(const FlowMesh& mesh, Signal& details, const Signal& original) {
  const SurfaceMoments before(mesh.lumped_mass(), original), after(mesh.lumped_mass(), details);
  for (Eigen::Index c = 0; c < details.cols(); ++c)
    if (after.variance[c] > 0) details.col(c) *= std::sqrt(before.variance[c] / after.variance[c]);
}

}  // namespace mq

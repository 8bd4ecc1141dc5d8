/// By what factor the residual falls per cycle, on the samples and for weights from small to
/// infinite: the counterpart of thesis Figures 5.10 to 5.12.
///
///     convergence_bench [texture size [sample ...]]

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>

#include "mq/fem/multigrid_solver.h"
#include "mq/fem/texel_space.h"
#include "mq/sample/sample.h"

namespace mq {
namespace {

void print_rates(const std::string& name, int size) {
  const Sample sample = make_sample(name, {.texture_size = size});
  const Surface surface = make_surface(sample.mesh);
  const Atlas atlas = make_atlas(surface, {sample.texture});
  const TexelSpace space(surface, atlas);
  const SurfaceScale scale = space.scale();

  Signal psi(space.size(), 3);
  for (Eigen::Index i = 0; i < psi.size(); ++i) psi.data()[i] = double(i * 7919 % 10007) / 10007;
  for (const double alpha : {1e-4, 1e-2, std::numeric_limits<double>::infinity()}) {
    const bool singular = std::isinf(alpha);
    const SparseMatrix A = singular ? space.stiffness() : space.solvable(1, alpha * scale.area);
    const Signal B = singular ? Signal(A * psi) : Signal(space.mass() * psi);
    Signal X = Signal::Zero(A.rows(), 3);
    const SolveReport report = multigrid_solver(space.texels())(A, {})->solve(B, X);
    const double rate = std::pow(report.residuals.back(), 1.0 / report.cycles);
    std::printf("%-16s %9d texels %5zu charts  alpha %-6g %2d cycles  factor per cycle %.1f%s\n",
                name.c_str(), space.size(), atlas.charts.size(), alpha, report.cycles, 1 / rate,
                report.converged ? "" : "  (not converged)");
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace mq

int main(int argc, char** argv) {
  const int size = argc > 1 ? std::atoi(argv[1]) : 512;
  if (argc > 2)
    for (int i = 2; i < argc; ++i) mq::print_rates(argv[i], size);
  else
    for (const mq::SampleInfo& sample : mq::sample_names())
      if (sample.name != "bust_3000") mq::print_rates(sample.name, size);
}

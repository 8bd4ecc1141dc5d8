// With R_p the texels of process p and its rim, D_p their shares, C_p our cycle on A_p = R_p A R_pᵀ, and P the
// functions of a coarse level of every process's cycle, times its shares:
//
//     S = Σ_p R_pᵀ √D_p C_p √D_p R_p,   Q = P (Pᵀ A P)⁻¹ Pᵀ,
//     z = Q r,   z += S (r − A z),   z += Q (r − A z).
//
// Functions of P sum to 1 and are as smooth over the borders of processes as within them, and there are enough of
// them that S has only waves shorter than its rim left to deal with: so iterations hardly depend on how many
// processes there are.

#include <cmath>
#include <span>

#include "mq/fem/texel_cycle.h"
#include "preconditioners.h"
#include "rim.h"

namespace mq::shared {
namespace {

constexpr int rim_steps = 12;            ///< couplings, about texels
constexpr double coarse_share = 1.0 / 30;  ///< of the rows that the coarse level has at most

class SchwarzMultigrid final : public SharedPreconditioner {
 public:
  SchwarzMultigrid(const Processes& processes, const SharedMatrix& matrix, const Numbering& numbering,
                   const TexelPart& part, const Texels& texels)
      : matrix_(matrix),
        rim_(processes, matrix, numbering, part, texels, rim_steps),
        cycle_(rim_.matrix(), rim_.texels()) {
    for (const double share : rim_.share()) root_.push_back(std::sqrt(share));
    rim_.let_go_of_matrix();
    make_coarse_level(processes);
  }

  void apply(const Signal& R, Signal& Z) const override {
    coarse(R, Z);
    Signal left = residual(R, Z);
    Z += local(left);
    left = residual(R, Z);
    coarse(left, left);
    Z += left;
  }

  std::string name() const override { return "conjugate gradients, multigrid in every process"; }

 private:
  Signal residual(const Signal& R, const Signal& Z) const {
    Signal left;
    matrix_.multiply(Z, left);
    left = R - left;
    return left;
  }

  /// S·R.
  Signal local(const Signal& R) const {
    Signal around = rim_.with_rim(R);
    scale(around);
    cycle_.apply(around, around);
    scale(around);
    return rim_.summed(around);
  }

  void scale(Signal& values) const {
    for (Eigen::Index i = 0; i < values.rows(); ++i) values.row(i) *= root_[std::size_t(i)];
  }

  /// Z = Q·R, which may be one signal.
  void coarse(const Signal& R, Signal& Z) const {
    matrix_.for_each_channel(R, Z, [&](Vec r, Vec z) {
      check(MatMultTranspose(interpolation_, r, coarse_b_));
      check(PCApply(coarse_solver_, coarse_b_, coarse_x_));
      check(MatMult(interpolation_, coarse_x_, z));
    });
  }

  void make_coarse_level(const Processes& processes);

  const SharedMatrix& matrix_;
  Rim rim_;
  TexelCycle cycle_;
  std::vector<double> root_;
  OwnedMat interpolation_, coarse_;
  OwnedPC coarse_solver_;
  OwnedVec coarse_b_, coarse_x_;
};

void SchwarzMultigrid::make_coarse_level(const Processes& processes) {
  // Columns without a share in anything are left out; how many entries a row gets from this process is counted.
  std::vector<char> used(std::size_t(rim_.size()), 0);
  Signal entries = Signal::Zero(rim_.size(), 1);
  const int columns = cycle_.for_each_interpolated(coarse_share, [&](int i, std::span<const WeightedIndex> terms) {
    if (rim_.share()[std::size_t(i)] <= 0) return;
    entries(i, 0) = double(terms.size());
    for (const WeightedIndex& term : terms) used[std::size_t(term.index)] = 1;
  });
  used.resize(std::size_t(columns));
  std::vector<PetscInt> column(used.size(), -1);
  PetscInt count = 0, first = 0;
  for (std::size_t k = 0; k < used.size(); ++k)
    if (used[k]) column[k] = count++;
  std::vector<double> counts(std::size_t(processes.count()), 0);
  counts[std::size_t(processes.rank())] = double(count);
  processes.sum(counts);
  for (int p = 0; p < processes.rank(); ++p) first += PetscInt(counts[std::size_t(p)]);

  const Signal all = rim_.summed(entries), of_own = rim_.own_rows(entries);
  std::vector<PetscInt> own(std::size_t(all.rows()), 0), others(std::size_t(all.rows()), 0);
  for (Eigen::Index n = 0; n < all.rows(); ++n) {
    own[std::size_t(n)] = PetscInt(of_own(n, 0));
    others[std::size_t(n)] = PetscInt(all(n, 0) - of_own(n, 0));
  }
  check(MatCreateAIJ(PETSC_COMM_WORLD, PetscInt(all.rows()), count, PETSC_DETERMINE, PETSC_DETERMINE, 0, own.data(), 0,
                     others.data(), interpolation_.place()));
  std::vector<PetscInt> places;
  std::vector<PetscScalar> values;
  cycle_.for_each_interpolated(coarse_share, [&](int i, std::span<const WeightedIndex> terms) {
    const double share = rim_.share()[std::size_t(i)];
    if (share <= 0) return;
    places.clear(), values.clear();
    for (const WeightedIndex& term : terms) {
      places.push_back(first + column[std::size_t(term.index)]);
      values.push_back(share * double(term.weight));
    }
    const auto row = PetscInt(rim_.numbers()[std::size_t(i)]);
    check(MatSetValues(interpolation_, 1, &row, PetscInt(places.size()), places.data(), values.data(), INSERT_VALUES));
  });
  check(MatAssemblyBegin(interpolation_, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(interpolation_, MAT_FINAL_ASSEMBLY));
  // Without holding a product of A and P; one process has no such way.
  if (processes.count() > 1) check(PetscOptionsSetValue(nullptr, "-matptap_via", "allatonce_merged"));
  check(MatPtAP(matrix_.matrix(), interpolation_, MAT_INITIAL_MATRIX, PETSC_DEFAULT, coarse_.place()));
  check(MatSetOption(coarse_, MAT_SPD, PETSC_TRUE));
  check(MatCreateVecs(coarse_, coarse_x_.place(), coarse_b_.place()));
  check(PCCreate(PETSC_COMM_WORLD, coarse_solver_.place()));
  check(PCSetOperators(coarse_solver_, coarse_, coarse_));
  check(PCSetOptionsPrefix(coarse_solver_, "coarse_"));
  check(PCSetType(coarse_solver_, PCHYPRE));
  check(PCHYPRESetType(coarse_solver_, "boomeramg"));
  // Converges for any matrix that is positive definite, which keeps the whole so.
  check(PetscOptionsSetValue(nullptr, "-coarse_pc_hypre_boomeramg_relax_type_all", "l1scaled-SOR/Jacobi"));
  check(PCSetFromOptions(coarse_solver_));
  check(PCSetUp(coarse_solver_));
}

}  // namespace

std::unique_ptr<SharedPreconditioner> schwarz_multigrid(const Processes& processes, const SharedMatrix& matrix,
                                                        const Numbering& numbering, const TexelPart& part,
                                                        const Texels& texels) {
  return std::make_unique<SchwarzMultigrid>(processes, matrix, numbering, part, texels);
}

}  // namespace mq::shared

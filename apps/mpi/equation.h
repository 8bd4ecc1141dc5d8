#pragma once
/// An equation of the whole model such as (M + w·S)·δ = B, its rows parted among processes.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "mq/base/options.h"
#include "mq/fem/texel_part.h"
#include "numbering.h"
#include "shared_matrix.h"
#include "shell/run.h"
#include "subdomain.h"

namespace mq::shared {

/// Adds --solver, of these choices besides multigrid, boomeramg and gamg, --tolerance and --cycles.
void add_shared_solver_options(OptionTable& table, const std::string& usual_solver = "multigrid",
                               const std::vector<std::string>& further_solvers = {});

class SharedEquation {
 public:
  /// The matrix of a part's space, whose rows of own texels are those of the whole.
  using Assemble = std::function<SparseMatrix(const TexelSpace& space, const Progress& progress)>;

  /// `assemble` may let the part let go of its space. Every process must call it, and `solve`.
  SharedEquation(app::Run& run, const Processes& processes, const Numbering& numbering, const TexelPart& part,
                 const Assemble& assemble);

  /// M + w·S, which BDDC solves too; `part` lets go of its space.
  SharedEquation(app::Run& run, const Processes& processes, const Numbering& numbering, TexelPart& part, double weight);

  /// δ of the own texels, for their rows of B. Once.
  Signal solve(const Signal& B);

 private:
  app::Run& run_;
  const Processes& processes_;
  const Numbering& numbering_;
  const TexelPart& part_;
  std::unique_ptr<SharedMatrix> matrix_;
  Texels texels_;
  Subdomain subdomain_;  ///< for BDDC
};

}  // namespace mq::shared

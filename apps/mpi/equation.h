#pragma once
/// (M + w·S)·δ = B of the whole model, its rows parted among processes.

#include <functional>
#include <memory>
#include <string>

#include "mq/base/options.h"
#include "mq/fem/texel_part.h"
#include "numbering.h"
#include "shared_matrix.h"
#include "shell/run.h"

namespace mq::shared {

/// Adds --solver, --tolerance and --cycles.
void add_shared_solver_options(OptionTable& table, const std::string& usual_solver = "multigrid");

class SharedEquation {
 public:
  /// `part` lets go of its space. Every process must call it, and `solve`.
  SharedEquation(app::Run& run, const Processes& processes, const Numbering& numbering, TexelPart& part, double weight);

  /// A·δ = B for any matrix of the part's space, by itself of each process.
  using Assemble = std::function<SparseMatrix(const TexelSpace& space, const Progress& progress)>;
  SharedEquation(app::Run& run, const Processes& processes, const Numbering& numbering, TexelPart& part,
                 const Assemble& assemble);

  /// δ of the own texels, for their rows of B. Once.
  Signal solve(const Signal& B);

 private:
  app::Run& run_;
  const Processes& processes_;
  const Numbering& numbering_;
  const TexelPart& part_;
  std::unique_ptr<SharedMatrix> matrix_;
  Texels texels_;
};

}  // namespace mq::shared

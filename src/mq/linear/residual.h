#pragma once
/// The residual of a linear system, summed the same way for any number of threads.

#include "mq/linear/matrix.h"

namespace mq {

/// B − A·X, by rows in parallel.
Signal residual(const SparseMatrix& A, const Signal& X, const Signal& B);

/// ⟨X, Y⟩ of each channel.
Eigen::RowVectorXd channel_dots(const Signal& X, const Signal& Y);

/// max over channels of ‖R‖ / ‖R₀‖ given their squared norms; a channel with ‖R₀‖ = 0 counts as 0.
double worst_ratio(const Eigen::RowVectorXd& squared, const Eigen::RowVectorXd& squared_at_start);

}  // namespace mq

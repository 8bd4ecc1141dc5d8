#pragma once
/// Products, residuals and sums over all channels at once, in one order for any number of threads.

#include "mq/linear/matrix.h"

namespace mq {

/// Y = A·X, by rows in parallel; Y is given its shape.
void multiply(const SparseMatrix& A, const Signal& X, Signal& Y);

/// B − A·X.
Signal residual(const SparseMatrix& A, const Signal& X, const Signal& B);

/// ⟨X, Y⟩ of each channel.
Eigen::RowVectorXd channel_dots(const Signal& X, const Signal& Y);

/// Y += X·diag(a).
void add_scaled(Signal& Y, const Signal& X, const Eigen::RowVectorXd& a);

/// max over channels of ‖R‖ / ‖R₀‖ given their squared norms; a channel with ‖R₀‖ = 0 counts as 0.
double worst_ratio(const Eigen::RowVectorXd& squared, const Eigen::RowVectorXd& squared_at_start);

}  // namespace mq

#pragma once
/// Gradients that a model's signal is to have in place of its own.

#include <filesystem>
#include <vector>

#include "mq/io/edge_differences.h"
#include "mq/model/model_field.h"

namespace mq {

/// ∫ ⟨X, ∇φ_i⟩ dA per unknown, as `ScreenedPoisson::solve_towards` takes it (thesis 5.7.1), of a field as it is: of its
/// vectors per texel where it has some, else of those per triangle, exactly. Vectors are changes per model unit of length,
/// in the values of the signal. Sums to 0.
Vector gradient_moments(const TexturedModel& model, const ModelSignal& signal, const ModelField& field);

/// The same of a field that changes by the differences of a table along its pairs, and by β (ψ_j − ψ_i) along all others
/// that have functions in common (thesis 5.6, (5.14)): one column per channel of ψ, all alike where the table has one.
/// Texels are those of the pictures; vertices those of the model's file. Throws `InvalidInput` that names the lines whose
/// places the signal does not have, which are not next to each other, or which are there twice, and for another count of
/// channels.
Signal gradient_moments(const TexturedModel& model, const ModelSignal& signal, const Signal& psi, double beta,
                        const EdgeDifferences& table);

}  // namespace mq

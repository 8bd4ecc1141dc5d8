#pragma once
/// The gradients that --gradient names, in place of a signal's own.

#include "mq/model/model_signal.h"
#include "shell/run.h"

namespace mq::app {

/// Adds --gradient and --gradient-scale.
void add_gradient_options(OptionTable& table, const std::string& group);

/// Reads what can be read before there is a signal, so that a file that cannot be used is refused before any work.
void check_gradient(const OptionValues& options, const TexturedModel& model);

/// Their moments, as `ScreenedPoisson::solve_towards` takes them, one column per channel of ψ. Given once they are of all
/// channels but alpha, which keeps its own.
Signal asked_gradient_moments(Run& run, const TexturedModel& model, const ModelSignal& signal, const Signal& psi,
                              const Progress& progress);

}  // namespace mq::app

#pragma once
/// What denoising up to edges is asked for, whatever program does it.

#include "mq/base/options.h"
#include "mq/filter/denoise.h"
#include "shell/run.h"

namespace mq::app {

/// Adds --strength.
void add_noise_strength_option(OptionTable& table);
/// Adds --edge, and --steps.
void add_edge_option(OptionTable& table);
void add_steps_option(OptionTable& table);

/// --strength as a part.
double asked_noise_strength(const OptionValues& options);

/// All that `denoise` is asked for, on a surface of this scale with this mean spacing of unknowns.
DenoiseOptions asked_edges(const OptionValues& options, const SurfaceScale& scale, double spacing);

/// Reports the edge that was kept, and says of one that was measured how high it is.
void say_edge(Run& run, const DenoiseOptions& wanted, double edge);

/// Of a signal of which nothing is noise.
void say_that_it_is_clean(Run& run);

}  // namespace mq::app

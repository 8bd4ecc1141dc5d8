#pragma once
/// What the options of the verb shock say.

#include "mq/base/length.h"
#include "mq/base/options.h"
#include "mq/filter/texture_shock.h"

namespace mq::app {

/// --time, or --absolute-time.
ShockTime asked_time(const OptionValues& options);

/// --smooth and --smooth-potential.
ShockWeights asked_weights(const OptionValues& options, const SurfaceScale& scale);

/// What --solver and --tolerance say, for systems of vertices.
VertexSolver vertex_solver(const OptionValues& options);

/// --longest-edge, or what is usual for so many texels.
double asked_longest_edge(const OptionValues& options, int texels);

}  // namespace mq::app

#pragma once
/// Colours of one model carried to another, as verbs do that make the other.

#include <memory>

#include "mq/model/baked_signal.h"
#include "shell/run.h"

namespace mq::app {

/// Bakes the source onto the target and gives it the result: pictures for its texture coordinates,
/// or colours `at_vertices`. Says and reports what was found; the target's seams too.
enum class BakeTo { textures, vertices };
void bake_onto(Run& run, const TexturedModel& source, TexturedModel& target, BakeTo to,
               const BakeOptions& options, double share);

}  // namespace mq::app

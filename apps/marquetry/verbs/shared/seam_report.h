#pragma once
/// How far textures jump across seams, for the report.

#include "shell/run.h"
#include "options/model_options.h"

namespace mq::app {

/// "rms", "p99" and "largest" of the model's textures as they are now, values as stored.
Json seams_json(const TexturedModel& scene);

}  // namespace mq::app

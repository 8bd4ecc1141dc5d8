#pragma once
/// How far textures jump across seams, for the report.

#include "shell/run.h"
#include "scene.h"

namespace mq::app {

/// "rms", "p99" and "largest" of the model's textures as they are now, values as stored.
Json seams_json(const Scene& scene);

}  // namespace mq::app

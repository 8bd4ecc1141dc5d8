#pragma once
/// How far textures jump across seams, for the report.

#include "shell/run.h"
#include "mq/model/model_signal.h"
#include "options/model_options.h"

namespace mq::app {

/// "rms", "p99" and "largest" of the model's textures as they are now, values as stored; or of others
/// in their place.
Json seams_json(const TexturedModel& scene);

/// The same; with frames, of the normals in tangent space that the textures are, in the model's
/// axes.
Json seams_json(const TexturedModel& scene, const ShadingFrames* frames);

/// The same; where the signal is of normals in tangent space, of the normals in the model's axes.
Json seams_json(const TexturedModel& scene, const TextureSignal& signal);
Json seams_json(const TexturedModel& scene, const std::vector<Texture>& textures);

}  // namespace mq::app

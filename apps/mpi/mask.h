#pragma once
/// How strongly a filter works where, on the texels of one of several processes: --mask and --spot.

#include <vector>

#include "mq/fem/texel_part.h"
#include "mq/model/textured_model.h"
#include "numbering.h"
#include "processes.h"
#include "shell/run.h"

namespace mq::shared {

/// Refuses files of --mask that cannot be read, or are models, before any work.
void check_mask(app::Run& run, const TexturedModel& scene);

/// β per unknown of the part's space. The picture of a texture is read by the processes that have texels of it. Every
/// process must call it.
std::vector<double> asked_modulation(app::Run& run, const Processes& processes, const TexturedModel& scene,
                                     const TexelPart& part, const Numbering& numbering);

}  // namespace mq::shared

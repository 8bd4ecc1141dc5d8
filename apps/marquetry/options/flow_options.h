#pragma once
/// Options of optical flow, the same for pictures and models.

#include "mq/base/options.h"
#include "mq/flow/image_flow.h"
#include "mq/model/signal_pair.h"
#include "shell/run.h"

namespace mq::app {

/// Adds what is aligned ("mesh" and "texture", --weld, --flipped, --vertices) and how.
void add_flow_options(OptionTable& table);

/// What the options say of pictures. Throws `InvalidInput` where one is for models only.
ImageFlowOptions image_flow_options(const OptionValues& options);

/// Throws `InvalidInput` where --smallest is above the largest scale of pictures of this size.
void require_scales(const OptionValues& options, const ImageFlowOptions& flow, int width,
                    int height);

/// What they say of models. Throws `InvalidInput` where one is for pictures only.
ModelFlowOptions model_flow_options(const OptionValues& options);

/// `error`, `levels` and the largest and mean length of the field, for the result.
Json flow_json(const ImageFlow& flow);
Json flow_json(const MeshFlow& flow);

}  // namespace mq::app

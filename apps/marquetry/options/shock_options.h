#pragma once
/// What the options of the verb shock say.

#include "mq/base/options.h"
#include "mq/model/model_shock.h"

namespace mq::app {

/// All that they say.
ShockRequest shock_request(const OptionValues& options);

/// --time, or --absolute-time.
ShockTime asked_time(const OptionValues& options);

}  // namespace mq::app

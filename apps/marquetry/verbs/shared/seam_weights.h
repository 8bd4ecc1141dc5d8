#pragma once
/// What both programs are asked about texels at seams and outside charts.

#include "mq/base/options.h"

namespace mq::app {

/// Adds --weight of `seams`.
void add_seam_weight_option(OptionTable& table);

/// Adds --distance and --weight of `fill`.
void add_fill_options(OptionTable& table);

}  // namespace mq::app

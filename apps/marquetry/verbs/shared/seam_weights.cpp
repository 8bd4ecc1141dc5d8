#include "verbs/shared/seam_weights.h"

#include "mq/filter/seam_values.h"
#include "mq/model/texture_fill.h"
#include "shell/arguments.h"

namespace mq::app {

void add_seam_weight_option(OptionTable& table) {
  table.add({.name = "weight",
             .type = Option::Type::number,
             .default_value = as_typed(usual_seam_weight),
             .least = 0,
             .most = 1e9,
             .group = "Seams",
             .help = "of agreement against smoothness, per texel of a seam"});
}

void add_fill_options(OptionTable& table) {
  table.add({.name = "distance",
             .type = Option::Type::number,
             .unit = "texels",
             .least = 0,
             .most = 1e6,
             .group = "Fill",
             .help = "how far beyond the charts' own texels; without it everywhere"});
  table.add({.name = "weight",
             .type = Option::Type::number,
             .default_value = as_typed(FillOptions{}.weight),
             .least = 0,
             .most = 1e9,
             .group = "Fill",
             .help = "of agreement at seams against smoothness, per texel of a seam",
             .details = "0: charts go on by themselves."});
}

}  // namespace mq::app

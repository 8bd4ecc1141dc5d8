#pragma once
/// How strong `filter` is, and what of colours it works on.

#include "mq/base/length.h"
#include "mq/base/options.h"
#include "mq/filter/halo_limit.h"
#include "mq/io/model.h"

namespace mq::app {

/// Adds --strength, --radius and --beta.
void add_strength_options(OptionTable& table);

/// Adds --luminance.
void add_luminance_option(OptionTable& table);

/// Throws `InvalidInput`, with the verb's examples, where neither --beta nor --strength is given.
void require_strength(const OptionValues& options);

/// The factor on gradients, by --beta or --strength.
double asked_beta(const OptionValues& options);

/// The weight of `ScreenedPoisson`, by --radius, --length or --alpha; with a strength alone by the usual radius.
double asked_weight(const OptionValues& options, const SurfaceScale& scale);

/// Whether the brightness of colours is filtered alone. Of colours: values of other slots, and normals, have no
/// luminance. Sharpened channel by channel they get fringes, which nobody wants who says how strong it is to be.
bool by_luminance(const OptionValues& options, const Model& model);

/// Adds --threshold.
void add_threshold_option(OptionTable& table);

/// What limits halos, by --halo and --threshold; `largest` is the largest of the values. Throws `InvalidInput` for a
/// threshold where halos are as the equation has them.
HaloOptions asked_halos(const OptionValues& options, const Model& model, double largest);

}  // namespace mq::app

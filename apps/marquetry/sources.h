#pragma once
/// Where distances begin: --from and --from-mask.

#include <vector>

#include "domain.h"
#include "mq/filter/geodesic.h"

namespace mq::app {

void add_source_options(OptionTable& table);

/// What they say, as unknowns of the domain. Throws `InvalidInput` with what was found and the
/// remedy where they say nothing, or something that is not on the surface.
std::vector<GeodesicSource> asked_sources(Run& run, const Scene& scene, const Domain& domain);

}  // namespace mq::app

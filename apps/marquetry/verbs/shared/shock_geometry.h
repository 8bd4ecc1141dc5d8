#pragma once
/// marquetry shock MESH --geometry: the shape sharpened by the shock filter of its normals.

#include "mq/model/model_shock.h"
#include "shell/run.h"
#include "shell/verb.h"

namespace mq::app {

/// Adds --geometry and what belongs to it.
void add_shock_geometry_options(OptionTable& table);

/// The run of the verb where --geometry is given.
Exit shock_geometry(Run& run, const ShockRequest& request);

}  // namespace mq::app

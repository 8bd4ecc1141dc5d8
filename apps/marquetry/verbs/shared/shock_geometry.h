#pragma once
/// marquetry shock MESH --geometry: the shape sharpened by the shock filter of its normals.

#include "mq/filter/shock.h"
#include "mq/filter/texture_shock.h"
#include "shell/run.h"
#include "shell/verb.h"

namespace mq::app {

/// Adds --geometry and what belongs to it.
void add_shock_geometry_options(OptionTable& table);

/// The run of the verb where --geometry is given; `time` and the lengths `signal` and `potential`
/// and `solver` are those of the verb's other inputs.
Exit shock_geometry(Run& run, const ShockTime& time, const std::string& signal,
                    const std::string& potential, const VertexSolver& solver);

}  // namespace mq::app

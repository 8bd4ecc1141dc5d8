#pragma once
/// What verbs that change the shape of a model have in common.

#include <vector>

#include "mq/linear/solver.h"
#include "shell/results.h"
#include "shell/run.h"
#include "options/model_options.h"

namespace mq::app {

/// Throws `InvalidInput` where pictures are named beside a shape.
void refuse_pictures_of_shape(const OptionValues& options);

/// The scene of a verb that leaves textures alone: no atlas, no pictures asked for.
TexturedModel read_shape(Run& run, double share);

/// Where the changed model goes.
Outputs shape_outputs(const OptionValues& options, const TexturedModel& scene);

/// Adds --fit-weight and --fit-steps under the heading.
void add_fit_options(OptionTable& table, const std::string& group);

/// Puts new positions of the surface's vertices into the model, whose stored normals turn with them
/// (`move_vertices`); says and reports how far vertices moved and what area and volume became.
/// Where one of these changed by more than 10 % a warning says so, followed by `advice`.
void put_positions(Run& run, TexturedModel& scene, const std::vector<Vector3>& positions,
                   const std::string& advice);

}  // namespace mq::app

#pragma once
/// Options that verbs of signals share: where the result goes, in which values is worked, how far
/// something reaches.

#include <string>

#include "mq/base/length.h"
#include "mq/base/options.h"
#include "mq/io/model.h"
#include "scene.h"

namespace mq::app {

/// Whether something else than the default is asked for: a report that is repeated says defaults
/// too.
bool asks_for(const OptionValues& options, const std::string& name);

/// Adds --output of pictures or models.
void add_output_option(OptionTable& table);

/// Adds --alpha (with this default) and --length, which exclude each other; `group` is their
/// heading, `help` what alpha does, `zero` what 0 does. Where `infinite`, alpha may be inf.
void add_spread_options(OptionTable& table, const std::string& default_alpha,
                        const std::string& group, const std::string& help, bool infinite = false,
                        const std::string& zero = "0 changes nothing.");

/// What --length says, or --alpha.
Length spread(const OptionValues& options);

/// The same as the weight w = length² of `ScreenedPoisson`.
double spread_weight(const OptionValues& options, const SurfaceScale& scale);

/// Adds --space.
void add_space_option(OptionTable& table);

/// Adds --normals.
void add_normals_option(OptionTable& table);

/// Adds --vertices; `help` says what it does.
void add_vertices_option(OptionTable& table, const std::string& help);

/// Whether colours at vertices are meant: asked for, or all there is. Throws `InvalidInput` where
/// there are neither these nor texture coordinates ("there is nothing to `verb`"), or where --space
/// was asked for.
bool at_vertices(const OptionValues& options, const Scene& scene);

/// Throws `InvalidInput` where pictures are named beside colours at vertices, see `at_vertices`.
void refuse_pictures(const OptionValues& options);

/// Adds --depth.
void add_depth_option(OptionTable& table);

/// Gives all pictures and colours of a model the depth that --depth asks for.
void set_depth(const OptionValues& options, Model& model);

}  // namespace mq::app

#pragma once
/// Options that verbs of signals share: which signal, in which values is worked, how far something
/// reaches, where the result goes.

#include <memory>
#include <string>

#include "mq/base/length.h"
#include "mq/base/options.h"
#include "mq/model/model_signal.h"
#include "options/model_options.h"
#include "shell/run.h"

namespace mq::app {

/// Whether something else than the default is asked for: a report that is repeated says defaults
/// too.
bool asks_for(const OptionValues& options, const std::string& name);

/// Adds --output of pictures or models.
void add_output_option(OptionTable& table);

/// The same where models may come out: --compress too.
void add_model_output_option(OptionTable& table);

/// Adds --alpha and --length, which exclude each other; `usual` is the default, of --alpha where it
/// is one and else of --length; `group` is their heading, `help` what alpha does, `zero` what 0
/// does. Where `infinite`, alpha may be inf.
void add_spread_options(OptionTable& table, const Length& usual, const std::string& group,
                        const std::string& help, bool infinite = false,
                        const std::string& zero = "0 changes nothing.");

/// What --length says, or --alpha.
Length spread(const OptionValues& options);

/// The same as the weight w = length² of `ScreenedPoisson`.
double spread_weight(const OptionValues& options, const SurfaceScale& scale);

/// Adds --halo, under the heading.
void add_halo_option(OptionTable& table, const std::string& group);

/// How far halos may go (`HaloOptions::fraction`): as asked for; else the usual way, but of normals, and of light
/// (values that are decoded to it, or the `largest` of which is beyond white), of which contrast is no part, inf: as the
/// equation has them.
double asked_halo(const OptionValues& options, const Model& model, double largest);

/// The largest of the values, 0 of none.
double largest_value(const Signal& values);

/// Adds --space.
void add_space_option(OptionTable& table, const std::string& usual = "stored");

/// Adds --normals and --normal-space.
void add_normals_option(OptionTable& table);

/// Refuses both where the base colour of a model that has a normal map is processed, as without --slot.
void refuse_normals_of_colours(const OptionValues& options, const Model& model);

/// Adds --normal-space alone; `remark` ends what is said of it.
void add_normal_space_option(OptionTable& table, const std::string& remark);

/// Adds --vertices; `help` says what it does.
void add_vertices_option(OptionTable& table, const std::string& help);

/// Whether colours at vertices are meant: asked for, or all there is. Throws `InvalidInput` where
/// there are neither these nor texture coordinates ("there is nothing to `verb`"), or where --space
/// was asked for.
bool at_vertices(const OptionValues& options, const TexturedModel& model);

/// Throws `InvalidInput` where pictures are named beside colours at vertices, see `at_vertices`.
void refuse_pictures(const OptionValues& options);

/// What --normal-space says.
NormalAxes normal_axes(const OptionValues& options);

/// What --space, --normals and --normal-space say, where the verb has them.
ValueSpace value_space(const OptionValues& options);

/// The signal that a verb changes, as the options ask for it (see `at_vertices`); what was found
/// wrong with its space goes into the report. The model must outlive it.
std::unique_ptr<ModelSignal> make_signal(Run& run, const TexturedModel& model,
                                         const Progress& progress);

/// The unknowns of a field that a verb computes: texels, or vertices where `--vertices` is given or
/// there are no texture coordinates. The verb must have the option.
std::unique_ptr<ModelSignal> make_field_signal(
    Run& run, const TexturedModel& model, const Progress& progress,
    TextureSignalOptions::SharedTexels shared = TextureSignalOptions::SharedTexels::one_unknown,
    TextureSignalOptions::Pictures pictures = TextureSignalOptions::Pictures::replaced,
    const TexelSpaceOptions& space = {});

/// Whether that will be vertices.
bool works_at_vertices(const OptionValues& options, const TexturedModel& model);

/// Puts what was found wrong with the space of a signal into the report, and says it.
void say_defects(Run& run, const ModelSignal& signal);

/// A signal of textures, with what was found wrong with its space in the report.
std::unique_ptr<TextureSignal> make_texture_signal(Run& run, const TexturedModel& model,
                                                   TextureSignalOptions options,
                                                   const Progress& progress);

}  // namespace mq::app

#pragma once
/// Colours of one model carried to another, as verbs do that make the other.

#include <functional>
#include <string>
#include <vector>

#include "mq/model/bake_target.h"
#include "mq/model/baked_signal.h"
#include "mq/model/outputs.h"
#include "shell/run.h"

namespace mq::app {

enum class BakeTo { textures, vertices };

/// The slots of a source to be baked: those that --slot names; else, into a model that has words
/// for them or a folder, all; else one. Empty: the source has no slots.
std::vector<std::string> slots_to_bake(const OptionValues& options, const Model& source);

/// The source with a slot's pictures.
using SourceOfSlot = std::function<TexturedModel(const std::string& slot)>;

/// What --normal-space says of the source's normal maps, where the verb has it.
NormalAxes asked_axes(const OptionValues& options);

/// Bakes each slot of the source onto the target and gives it the result: pictures for its texture
/// coordinates, or colours at its vertices. Says and reports what was found; the target's seams
/// too. Where there are several slots, "slots" has a report for each. Normal maps are in tangent
/// space where the output is glTF.
void bake_onto(Run& run, const std::vector<std::string>& slots, const SourceOfSlot& source,
               TexturedModel& target, BakeTo to, BakeOptions options, double share);

/// Where a model goes that gets pictures for texture coordinates that it has not yet.
Outputs unwrapped_outputs(const OptionValues& options, const Model& model,
                          const std::vector<std::string>& slots, const std::vector<SharedSlot>& shared = {});

/// Gives `scene`, just unwrapped for `size` texels, what the source showed, as `bake_onto` does. Its
/// triangles keep their materials; outside glTF the factors of these go into the pictures.
void bake_unwrapped(Run& run, const std::vector<std::string>& slots, const std::vector<SharedSlot>& shared,
                    const SourceOfSlot& source, const LoadOptions& load, TexturedModel& scene, double share);

}  // namespace mq::app

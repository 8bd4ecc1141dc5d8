#pragma once
/// Photographs, given as textures of their own (--partial and --confidence) or with their cameras
/// (--views).

#include <vector>

#include "mq/draw/photograph.h"
#include "mq/filter/stitch.h"
#include "options/signal_options.h"

namespace mq::app {

/// Adds --steepest and --bias, what a photograph with a camera shows, under the heading.
void add_sight_options(OptionTable& table, const std::string& group);

/// What they say.
PhotographOptions asked_sight(const OptionValues& options);

/// Adds --partial and --confidence, and --views with what belongs to it.
void add_partial_options(OptionTable& table);

/// Whether the options name any.
bool has_partials(const OptionValues& options);

/// Whether photographs come with cameras, so that the model needs no pictures of its own.
bool has_views(const OptionValues& options);

/// Refuses what cannot be read of these files, before any work. Throws `InvalidInput` or `IoError`.
void check_partials(const OptionValues& options, const TexturedModel& scene);

/// The photographs that the pictures of --labels choose where they are given beside photographs,
/// one per unknown; `unseen`: that which shows it best. `count` is how many there are. Throws
/// `InvalidInput` or `IoError` naming the file.
std::vector<int> asked_photographs(const OptionValues& options, const TexturedModel& scene,
                                   const TextureSignal& target, int count);

/// The pictures of --labels.
std::vector<Texture> read_labels(const OptionValues& options);

/// The partial signals that the options name. Throws `InvalidInput` or `IoError` naming the file.
std::vector<Partial> read_partials(Run& run, const TexturedModel& scene,
                                   const TextureSignal& target, const Progress& progress);

}  // namespace mq::app

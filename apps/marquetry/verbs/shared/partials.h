#pragma once
/// Photographs given as textures of their own (--partial and --confidence), and labels that choose between
/// photographs.

#include <vector>

#include "mq/filter/stitch.h"
#include "options/signal_options.h"

namespace mq::app {

/// Adds --partial and --confidence.
void add_partial_options(OptionTable& table);

/// Whether the options name any.
bool has_partials(const OptionValues& options);

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
std::vector<Partial> read_partials(const OptionValues& options, const TexturedModel& scene,
                                   const TextureSignal& target);

/// Adds --labels, --borders, --exposure of `stitch`.
void add_labels_option(OptionTable& table);
void add_borders_option(OptionTable& table);
void add_levels_option(OptionTable& table);

/// The gains of regions before they are stitched (`Stitcher::levels`); none where --exposure keeps them, or values are
/// no colours.
RegionLevels asked_levels(const OptionValues& options, const Model& model, const Stitcher& stitcher, const Signal& psi);

}  // namespace mq::app

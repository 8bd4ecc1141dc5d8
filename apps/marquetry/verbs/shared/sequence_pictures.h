#pragma once
/// Pictures of how well a sequence was followed, as options ask for them.

#include <filesystem>
#include <functional>
#include <vector>

#include "mq/io/evolving_file.h"
#include "mq/io/followed_frame.h"
#include "mq/io/model.h"
#include "shell/run.h"

namespace mq::app {

/// Adds --plot.
void add_plot_option(OptionTable& table);

/// Adds --plot and --strip, which is seen from where the verb's --view says.
void add_sequence_picture_options(OptionTable& table);

/// The files they name.
std::vector<std::filesystem::path> sequence_picture_paths(const OptionValues& options);

/// Writes what --plot asks for: see `sequence_plot`. Throws `InvalidInput` where nothing is known
/// of the frames.
void write_plot(const Run& run, const std::vector<FollowedFrame>& frames);

/// Writes what --strip asks for: see `sequence_strip`.
void write_strip(const Run& run, const EvolvingReader& reader,
                 const std::function<Model(int frame)>& captured, const Progress& progress);

}  // namespace mq::app

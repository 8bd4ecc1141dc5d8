#pragma once
/// How well a sequence was followed, as pictures: a plot over time, and a strip of frames.

#include <filesystem>
#include <functional>
#include <vector>

#include "mq/io/evolving_file.h"
#include "mq/io/model.h"
#include "shell/run.h"

namespace mq::app {

/// Adds --plot.
void add_plot_option(OptionTable& table);

/// Adds --plot and --strip, which is seen from where the verb's --view says.
void add_sequence_picture_options(OptionTable& table);

/// The files they name.
std::vector<std::filesystem::path> sequence_picture_paths(const OptionValues& options);

/// What a store holds of what was measured of its frames, an object each.
Json measured_of(const EvolvingReader& reader);

/// Writes what --plot asks for: distances, triangles, distortion and time over the frames' numbers.
/// `frames` are what was measured, as `result.frames` of the report has it; what is missing in some
/// is left out.
void write_plot(const Run& run, const Json& frames);

/// Writes what --strip asks for: captured frames, what follows them in the colours of the first, and
/// how far it is from them. `captured` reads the frame of a store with this index.
void write_strip(const Run& run, const EvolvingReader& reader,
                 const std::function<Model(int frame)>& captured, const Progress& progress);

}  // namespace mq::app

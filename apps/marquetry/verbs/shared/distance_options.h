#pragma once
/// What both programs are asked about distances, and how they show them.

#include <filesystem>

#include "mq/base/options.h"
#include "mq/image/image.h"
#include "mq/linear/matrix.h"

namespace mq::app {

/// Adds --time, --metric, --show and --isolines.
void add_distance_options(OptionTable& table);

/// Whether --metric asks for that of the texture.
bool by_texture(const OptionValues& options);

/// Whether distances are written as numbers: asked for, or the format is one for numbers.
bool writes_numbers(const OptionValues& options, const std::filesystem::path& path);

/// A row per distance, in as many channels; −1 where it is not finite.
Signal distances_as_numbers(const Vector& distance, int channels);

/// Its colours, of distances up to `most` on texels of this size.
Signal distances_as_colours(const OptionValues& options, const Vector& distance, double most, double texel_spacing);

}  // namespace mq::app

#pragma once
/// What the options of `marquetry render` ask for.

#include <string>
#include <vector>

#include "mq/model/model_picture.h"
#include "options/model_options.h"
#include "shell/run.h"

namespace mq::app {

/// Whether `parse_view` knows it.
bool is_view(const std::string& text);

/// --view with one view: from where pictures are that a verb draws beside its work.
void add_view_option(OptionTable& table, const std::string& group);

/// Throws `InvalidInput` where the option names no picture that can be written; to be called before any work.
void require_picture_name(const OptionValues& options, const std::string& name);

/// --up.
void add_up_option(OptionTable& table, const std::string& group);
View::Up asked_up(const OptionValues& options);

/// Camera, picture, numbers and layout: everything but the model and the output.
void add_render_options(OptionTable& table);

/// Throws `InvalidInput` where the model lacks what is asked for.
ModelPictureOptions asked_picture(const OptionValues& options, const TexturedModel& scene);

/// The pictures of --compare. Throws `IoError`, or `InvalidInput` where they do not fit the
/// model's.
std::vector<Texture> read_compared(const OptionValues& options, const TexturedModel& scene);

/// What an option says that holds so many numbers.
std::vector<double> numbers_of(const OptionValues& options, const std::string& name,
                               std::size_t count);

}  // namespace mq::app

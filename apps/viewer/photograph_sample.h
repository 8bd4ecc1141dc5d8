#pragma once
/// Photographs with their cameras to try the task with, of a model that the program makes itself.

#include <filesystem>

#include "mq/base/progress.h"
#include "mq/model/textured_model.h"

namespace mq::view {

/// Draws six views around the model into a folder, each exposed a little differently, as photographs are, with the file
/// of their cameras, which it returns.
std::filesystem::path make_photographs(const TexturedModel& model, const std::filesystem::path& folder,
                                       const Progress& progress);

}  // namespace mq::view

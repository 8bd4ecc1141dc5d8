#pragma once
/// Models that are looked at while they are read: the shape before the pictures.

#include <filesystem>
#include <functional>

#include "mq/io/model.h"

namespace mq {

/// Called by the thread that reads, twice: with the mesh and its colours once these are there, without textures, and
/// with all that was read. What it throws ends the reading.
using ModelWatch = std::function<void(const Model&)>;

/// As `read_model`, watched.
Model read_model(const std::filesystem::path& path, const ReadModelOptions& options, const Progress& progress,
                 const ModelWatch& watch);

}  // namespace mq

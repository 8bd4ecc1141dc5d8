#pragma once
/// What a model has of slots, sets of texture coordinates and tiles, and which of them are processed.

#include <string>
#include <utility>
#include <vector>

#include "shell/run.h"

namespace mq::app {

/// "uv_sets": how many; "slots": per slot its name, whether it is processed, and its pictures with the
/// set each uses; "tiles": names of the textures that are tiles.
Json slots_json(const Model& model);

/// The same for people, as names and values; only what there is to choose or to know: nothing for a
/// model of one slot, one set and no tiles.
std::vector<std::pair<std::string, std::string>> slots_rows(const Model& model);

}  // namespace mq::app

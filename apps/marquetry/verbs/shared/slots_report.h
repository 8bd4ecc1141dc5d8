#pragma once
/// What a model has of slots, sets of texture coordinates and tiles, and which of them are processed.

#include <string>
#include <utility>
#include <vector>

#include "mq/model/textured_model.h"
#include "shell/run.h"

namespace mq::app {

/// "uv_sets": how many; "slots": per slot its name, whether it is processed, and its pictures with the
/// set each uses; "tiles": names of the textures that are tiles.
Json slots_json(const Model& model);

/// The same for people, as names and values; only what there is to choose or to know: nothing for a
/// model of one slot, one set and no tiles.
std::vector<std::pair<std::string, std::string>> slots_rows(const Model& model);

/// Where the pictures are a slot's normals: "axes", object or tangent, as verbs take them; "upright", the
/// share of texels that point along z; and in tangent space "frames", where these are from. Else null.
Json normals_json(const TexturedModel& model);

/// The same for people, a row or none.
std::vector<std::pair<std::string, std::string>> normals_rows(const Json& normals);

}  // namespace mq::app

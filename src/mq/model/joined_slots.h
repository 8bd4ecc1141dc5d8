#pragma once
/// Several slots of one model, each processed by itself, as one model again.

#include <string>
#include <vector>

#include "mq/io/model.h"

namespace mq {

/// The slots that a word asks for, of those a file has: "all", or names between commas. Normals come
/// first, since they are what may be refused. Of slots that share all their pictures in a glTF file the
/// first is enough. Throws `InvalidInput` as `chosen_slot` does, and where there is none.
std::vector<std::string> slots_asked_for(const Model& model, const std::string& asked);

/// Puts the textures of `other`, the same model with another slot processed, among the `others` of
/// `model`. Pictures that are textures of both stay as `model` has them.
void join_slot(Model other, Model& model);

/// The same model with the textures of all slots that have pixels as its textures, to be written as
/// pictures alone.
Model all_pictures(Model model);

}  // namespace mq

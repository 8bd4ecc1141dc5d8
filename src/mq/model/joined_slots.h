#pragma once
/// Several slots of one model, each processed by itself, as one model again.

#include <string>
#include <vector>

#include "mq/io/model.h"

namespace mq {

/// Whether a word asks for several: "all", or names between commas.
bool names_several_slots(const std::string& asked);

/// The slots that a word asks for, of those a file has: "all", or names between commas. Normals come
/// first, since they are what may be refused. Of slots that share all their pictures in a glTF file the
/// first is enough. Throws `InvalidInput` as `chosen_slot` does, and where there is none.
std::vector<std::string> slots_asked_for(const Model& model, const std::string& asked);

/// Puts the textures of `other`, the same model with another slot processed, among the `others` of
/// `model`. Pictures that are textures of both stay as `model` has them.
void join_slot(Model other, Model& model);

/// Makes a model one that has pictures for these slots: its `textures` for the first, and beside
/// each of them one for each of the others, all without pixels, those named after the slots.
/// Pictures that it had are forgotten, and so is its file but for its normals: written, it is made
/// anew.
void begin_slots(const std::vector<std::string>& slots, std::size_t textures, Model& model);

/// A slot of glTF materials all of whose pictures are those of another: occlusion in the red of
/// metallic-roughness.
struct SharedSlot {
  std::string name, with;
};
std::vector<SharedSlot> shared_slots(const Model& model, const std::vector<std::string>& with);

/// Gives such a model these slots too.
void share_slots(const std::vector<SharedSlot>& shared, Model& model);

/// Gives such a model what was made for one of its slots, a picture for each of its textures.
void put_slot(const std::string& slot, std::vector<Texture> pictures, Model& model);

/// The same model with the textures of all slots that have pixels, or will have (`begin_slots`), as its
/// textures, to be written as pictures alone.
Model all_pictures(Model model);

}  // namespace mq

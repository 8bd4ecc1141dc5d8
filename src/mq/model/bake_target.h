#pragma once
/// What becomes of a model that textures are baked to: its slots, its materials, its colours at vertices.

#include <filesystem>
#include <string>
#include <vector>

#include "mq/model/baked_signal.h"
#include "mq/model/joined_slots.h"
#include "mq/model/messages.h"
#include "mq/model/textured_model.h"

namespace mq {

/// The target as it will be: with pictures for several slots, for one that it has not or with `shared` ones, it
/// is made anew.
void begin_bake(const std::vector<std::string>& slots, const std::vector<SharedSlot>& shared, TexturedModel& target);

/// Whether a user named a slot, or wants to see what the source shows.
enum class BakedSlots { named, as_the_source };

/// The same, for a target that lies on the source and is written to `output`. As the source, a target whose
/// material looks otherwise, or whose colours at vertices would multiply the picture, is made anew too, with one
/// material for all (`joined`). Remarks on what is lost by that.
void begin_bake_as(const Model& source, const std::vector<std::string>& slots, BakedSlots asked,
                   const std::filesystem::path& output, TexturedModel& target, Messages& messages);

/// Where factors of the source's materials go when one material is made of them: into the pictures where
/// they differ, or where colours at vertices multiply them.
BakeOptions::Factors factors_for_one(const Model& source);

/// For a format whose pictures stand for its factors (MTL): takes the factors of these slots from the model's
/// materials, into whose pictures they are to be baked. That of alpha stays.
BakeOptions::Factors factors_into_pictures(const std::vector<std::string>& slots, Model& model);

/// In glTF they would multiply a picture that was made of them. Remarks on it.
void leave_out_colours(Model& model, Messages& messages);

}  // namespace mq

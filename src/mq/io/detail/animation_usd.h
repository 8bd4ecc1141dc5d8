#pragma once
/// An evolving mesh as the text of a USD layer.

#include <string>
#include <vector>

#include "mq/io/animation.h"

namespace mq {

/// The layer that `write_animation` describes; the part was checked. `pictures` are the names of the
/// segments' pictures beside it, empty of one that has none, or no names.
std::string animation_usda(const EvolvingReader& reader, const AnimationPart& part,
                           const std::vector<std::string>& pictures, const Progress& progress);

}  // namespace mq

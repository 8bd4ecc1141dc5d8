#pragma once
/// Textures whose values are kept exactly, in place of those of a model.

#include <string>
#include <vector>

#include "mq/io/model.h"

namespace mq {

/// Gives the model these pictures, one per texture, as PNG named after the textures it has, or
/// where one has no name, STEM_0 and so on. Empty pictures are for `Outputs` to know names by.
void replace_with_lossless(Model& model, std::vector<Image<float>> pictures,
                           const std::string& stem);

}  // namespace mq

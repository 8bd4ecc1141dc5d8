#pragma once
/// A page that shows how a texture was made of photographs.

#include <span>
#include <string>

#include "mq/draw/render.h"
#include "mq/model/photograph_texture.h"

namespace mq {

/// From four sides: the model in the colours of the photographs that were chosen (`colours_of_labels`) beside its
/// texture, then in colours of how many photographs show a place, and how many are rejected there, and below what these colours are, with the
/// photographs' `names` and how many hundredths of the texels each has. `numbers`: the model with textures of the size
/// of `target`, whatever they hold. Throws what `ModelRenderer::draw` throws.
Image<float> draw_photographs(const TexturedModel& model, const TextureSignal& target, const PhotographTexture& found,
                              std::span<const std::string> names, View::Up up);

}  // namespace mq

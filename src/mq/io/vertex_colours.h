#pragma once
/// The colours a model shows at its vertices, and anywhere on it.

#include <array>

#include "mq/io/model.h"
#include "mq/linear/matrix.h"
#include "mq/video/texture_frame.h"

namespace mq {

/// A row per vertex of `model.mesh`: its colours if it has any (the first three channels), else the
/// mean of its textures as its corners see them, grey as three equal channels. Vertices that show
/// nothing get the mean of the others. Without any colours there are no columns.
Signal vertex_colours(const Model& model);

/// The display value of the colour of a vertex; grey in all three channels.
std::array<float, 3> displayed_colour(const VertexSignal& colors, int vertex);

/// The same colours as light, or as display values; alpha stays. Light of 8 bits gets 16.
VertexSignal as_light(VertexSignal colors);
VertexSignal as_displayed(VertexSignal colors);

/// The texture whose picture a triangle shows; −1: none.
int shown_texture(const Model& model, int triangle);

/// Whether it has any: at vertices, or a texture on some triangle.
bool has_colours(const Model& model);

/// The colour a model shows at a point of its mesh: between those of the triangle's corners if it
/// has any, else of its textures, bilinear; grey as three equal channels, and mid grey where it
/// shows nothing. The model must stay.
ColourAt surface_colours(const Model& model);

}  // namespace mq

#pragma once
/// Strokes of a file as vectors wished on the surface.

#include <span>
#include <vector>

#include "mq/fem/smoothest_field.h"
#include "mq/io/field_strokes.h"
#include "mq/model/textured_model.h"

namespace mq {

/// A wish every `spacing` (model units) along each stroke, of the stroke's direction there and its strength: of strokes in
/// space at the closest point of the surface, of those in a texture wherever a chart is. `atlas` may be null where the
/// model's triangles count, not its texture.
///
/// Throws `InvalidInput` naming the stroke: a texture that is not there, points farther from the surface than a tenth of
/// √area (other units, or another model), or a stroke that lies nowhere on it.
std::vector<WishedVector> stroke_wishes(const TexturedModel& model, const Atlas* atlas,
                                        std::span<const FieldStroke> strokes, double spacing);

}  // namespace mq

#pragma once
/// The vector fields that change least on a textured surface, with a vector per texel.

#include "mq/fem/field_spectrum.h"
#include "mq/fem/texel_vector_space.h"

namespace mq {

/// The `count` smallest λ of L·z = λ·M·z (`TexelVectorSpace::system`) and their fields, across all seams: those of ∫ |∇X|²
/// dA, as the triangle and vertex bases have them (`field_spectrum`), of second order in the size of texels and whatever the
/// triangles. Fields are free at boundaries. What they are on triangles is the mean there (`TexelVectorSpace::on_triangles`),
/// scaled to ∫ |X|² dA = 1; triangles without a chart have none.
///
/// Costs a factorisation of L + σM, two unknowns per texel, and 3·count solves. Throws as `field_spectrum` does.
FieldSpectrum texel_field_spectrum(const TexelVectorSpace& vectors, int count, const Progress& progress = {});

}  // namespace mq

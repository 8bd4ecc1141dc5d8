#pragma once
/// The one place that converts between lengths on a surface and the thesis' weight alpha.
///
/// The screened Poisson weight alpha multiplies squared gradients, so it is an area; the thesis
/// scales every surface to unit area first. A surface of area A keeps its size here, and
///
///     alpha (unit area) = (length / sqrt(A))²,   weight in model units = alpha · A = length².

#include <string>

namespace mq {

/// A distance over which values spread, as a user states it.
struct Length {
  enum class Unit {
    model,        ///< the model's own unit
    percent,      ///< percent of the square root of the surface's area
    texels,       ///< mean texel spacings on the surface
    alpha         ///< not a length but the thesis' weight on the unit-area surface
  };
  double value = 0;
  Unit unit = Unit::model;
};

/// Reads "0.02", "1%" or "8tx" (a plain number is in model units). Throws `InvalidInput`.
Length parse_length(const std::string& text);

/// What a surface says of itself for the conversion.
struct SurfaceScale {
  double area = 1;           ///< model units squared
  double texel_spacing = 0;  ///< mean distance of neighbouring texels, model units; 0: no texels
};

/// The thesis' weight, for the surface scaled to unit area.
double alpha_from_length(const Length& length, const SurfaceScale& scale);

/// The weight that multiplies the stiffness of the unscaled surface: alpha · area.
double weight_from_length(const Length& length, const SurfaceScale& scale);

}  // namespace mq

#pragma once
/// The lines of vector fields on a model, as shades of grey (`line_integral`).

#include <cstdint>
#include <optional>

#include "mq/fem/tangent_fields.h"
#include "mq/filter/line_integral.h"
#include "mq/model/model_signal.h"

namespace mq {

struct FieldLinesOptions {
  double alpha = 0.0016;  ///< how far values spread along the field: weight at unit area
  double kappa = 400;     ///< how many times less far they spread across it
  /// Of the noise that is spread, and so the width of lines: spacings of texels; none: `usual_grain`.
  std::optional<double> grain = {};
  double deviations = 2;    ///< standard deviations from grey to black and to white
  double tolerance = 0.02;  ///< relative residual at which iterations stop
  std::uint64_t seed = 0;   ///< of the noise
};

/// Sharpening by the grain, an eighth of the length at most as it would bring out where lines end, and evening over three
/// grains.
LineIntegralOptions suiting(double weight, double grain);

/// Draws any number of fields with the same noise.
class FieldLines {
 public:
  /// The signal's space has the unknowns; it must outlive the object.
  explicit FieldLines(const ModelSignal& signal, const FieldLinesOptions& options = {});

  /// One column of greys from 0 to 1, and how both equations were solved. `field`: one vector per
  /// triangle of the surface, the longest of length 1. Solves by multigrid.
  LineIntegral draw(const TangentField& field, const Progress& progress = {}) const;

 private:
  const ModelSignal& signal_;
  FieldLinesOptions options_;
  double grain_;
  Signal noise_;
};

}  // namespace mq

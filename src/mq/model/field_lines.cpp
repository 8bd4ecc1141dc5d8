#include "mq/model/field_lines.h"

namespace mq {

FieldLines::FieldLines(const ModelSignal& signal, const FieldLinesOptions& options)
    : signal_(signal),
      options_(options),
      noise_(solid_noise(signal.space().positions(), options.grain * signal.scale().texel_spacing,
                         options.seed)) {}

LineIntegral FieldLines::draw(const TangentField& field, const Progress& progress) const {
  const SignalSpace& space = signal_.space();
  const double area = space.scale().area;
  const auto across = signal_.space_across(field, options_.kappa, progress.step("metric", 0.4));
  LineIntegral lines = line_integral(
      *across, space, noise_,
      {.weight = options_.alpha * area, .sharpen_weight = options_.sharpen * area},
      space.multigrid({.tolerance = options_.tolerance}), progress.step("solve", 0.6));
  lines.signal = with_contrast(lines.signal, options_.deviations);
  return lines;
}

}  // namespace mq

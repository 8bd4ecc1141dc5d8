#include "mq/model/field_lines.h"

#include <algorithm>

namespace mq {

FieldLines::FieldLines(const ModelSignal& signal, const FieldLinesOptions& options)
    : signal_(signal),
      options_(options),
      grain_(options.grain ? *options.grain * signal.scale().texel_spacing : usual_grain(signal.space())),
      noise_(solid_noise(signal.space().positions(), grain_, options.seed)) {}

LineIntegralOptions suiting(double weight, double grain) {
  constexpr double even = 3, eighth = 1.0 / 8;
  const double grains = grain * grain;
  return {.weight = weight,
          .sharpen_weight = std::min(grains, eighth * eighth * weight),
          .even_weight = even * even * grains};
}

LineIntegral FieldLines::draw(const TangentField& field, const Progress& progress) const {
  const SignalSpace& space = signal_.space();
  const double area = space.scale().area;
  const auto across = signal_.space_across(field, options_.kappa, progress.step("metric", 0.4));
  LineIntegral lines = line_integral(
      *across, space, noise_, suiting(options_.alpha * area, grain_),
      space.multigrid({.tolerance = options_.tolerance}), progress.step("solve", 0.6));
  lines.signal = with_contrast(lines.signal, options_.deviations);
  return lines;
}

}  // namespace mq

#pragma once
/// Rasters smoothed by a Gaussian.

#include <span>

#include "mq/image/image.h"

namespace mq {

/// A Gaussian of variance 2·weight pixels² in place, cut off at four standard deviations, the
/// border a mirror: it damps a wave of wave number k by exp(−weight·k²), as 1 / (1 + weight·k²)
/// does at first. `values` has width · height · channels numbers, pixel by pixel, row by row. The
/// sum over all pixels is kept. Throws `InvalidInput` where the weight is negative or the size does
/// not fit.
void smooth(std::span<double> values, int width, int height, int channels, double weight);

/// The same of an image.
Image<float> smoothed(const Image<float>& image, double weight);

}  // namespace mq

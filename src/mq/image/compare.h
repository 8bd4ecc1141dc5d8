#pragma once
/// How far two pictures are apart.

#include <cstdint>
#include <limits>
#include <vector>

#include "mq/image/image.h"

namespace mq {

struct Comparison {
  double rms = 0;  ///< √ mean (a − b)² over all channels of the pixels compared
  double psnr = std::numeric_limits<double>::infinity();  ///< 20 log10(peak / rms), decibels
  double largest = 0;                                     ///< max |a − b| ...
  int x = 0, y = 0;    ///< ... at this pixel (the first in reading order, where several) ...
  int channel = 0;     ///< ... and channel
  float a = 0, b = 0;  ///< the two values there
  std::vector<double> channel_rms;
  std::int64_t pixels = 0;  ///< compared
};

struct CompareOptions {
  const Image<float>* coverage = nullptr;  ///< one channel, same size: pixels above 0 are compared;
                                           ///< null: all are
  double peak = 1;                         ///< the value psnr refers to
};

/// Throws `InvalidInput` when sizes or channels differ, when nothing is covered, or when a value
/// compared is not a number. Equal bits for any number of threads.
Comparison compare(const Image<float>& a, const Image<float>& b,
                   const CompareOptions& options = {});

}  // namespace mq

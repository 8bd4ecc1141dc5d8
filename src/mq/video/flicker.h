#pragma once
/// How much a signal changes at points of a surface that stay where they are.

#include <cstdint>
#include <vector>

#include "mq/video/detail/time_links.h"

namespace mq {

/// In the unit of the values, over channels.
struct Flicker {
  /// √ of the temporal variance: Σ (φ − mean of the texel's life)² over all frames, by the number
  /// of frames less one for each life.
  double deviation = 0;
  double step = 0;  ///< √(½ mean (φ_f − φ_{f−1})²): the same of noise that is white in time
  std::int64_t values = 0;  ///< texels times frames that count
};

/// Takes frames in their order. A texel's life lasts while it is linked to itself, so that motion
/// is left out; what is not `counted` (texels at seams, say) is left out too.
class FlickerMeter {
 public:
  void add(const TimeLinks& links, const std::vector<char>& counted, const Signal& signal);
  Flicker finish();

 private:
  void end_life(int row);

  Signal sum_, squares_, last_;
  std::vector<int> lived_;
  double deviations_ = 0, freedoms_ = 0, steps_ = 0, step_count_ = 0;
  std::int64_t values_ = 0;
};

}  // namespace mq

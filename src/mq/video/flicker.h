#pragma once
/// How much a signal changes at points of a surface, where they stay or along what they are seen to drift.

#include <cstdint>
#include <optional>
#include <vector>

#include "mq/video/detail/time_links.h"
#include "mq/video/frame_drift.h"

namespace mq {

/// In the unit of the values, over channels.
struct Flicker {
  /// √ of the temporal variance: Σ (φ − mean of the texel's life)² over all frames, by the number
  /// of frames less one for each life.
  double deviation = 0;
  double step = 0;  ///< √(½ mean (φ_f − φ_{f−1})²): the same of noise that is white in time
  /// √(½ mean (φ_f(p₊) − φ_{f−1}(p₋))²), p₋ and p₊ where a point that is at a texel half-way between both frames was in
  /// the one and is in the other: what slides under texels is left out. None where nothing was followed.
  std::optional<double> along = {};
  std::int64_t values = 0;  ///< texels times frames that count
};

/// Takes frames in their order. A texel's life lasts while it is linked to itself, so that motion
/// is left out; what is not `counted` (texels at seams, say) is left out too.
///
/// `along` looks both frames up half a step away, so that what a lookup loses is lost in both: of a pattern that slides
/// as its drift says O(h^2.5) is left as texels h shrink (h³ but at extrema, as lookups stay within values; h² beside
/// seams), and of flicker that is smooth on the surface all. Of noise of texels that counts which lookups leave.
class FlickerMeter {
 public:
  /// `drift` to the frame before, null: not known. To compare signals take the same one for all.
  void add(const TimeLinks& links, const std::vector<char>& counted, const Signal& signal,
           const FrameDrift* drift = nullptr);
  Flicker finish();

 private:
  void end_life(int row);
  void add_along(const TimeLinks& links, const std::vector<char>& counted, const Signal& signal,
                 const FrameDrift& drift);

  Signal sum_, squares_, last_;
  std::vector<int> lived_;
  double deviations_ = 0, freedoms_ = 0, steps_ = 0, step_count_ = 0, along_ = 0, along_count_ = 0;
  std::int64_t values_ = 0;
};

}  // namespace mq

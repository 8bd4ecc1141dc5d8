#pragma once
/// How far photographs that are right may be apart at a place, as far as that is known from how far they are.

#include <vector>

namespace mq {

/// How far a photograph is off what is agreed on at a place.
struct Residual {
  double size;    ///< absolute
  double detail;  ///< how much it tells of where the photograph lies: its weight times its squared gradient
};

/// Of which residuals the scale is taken that parts them from outliers.
enum class Usual {
  everywhere,  ///< their median: what is aligned, and off by noise
  at_detail,   ///< twice the median of what they tell, `detail`, if that is more: what lies pixels apart
};

/// 0 where there are none; reorders them. Plain places of photographs that were exposed alike agree to a rounding: by
/// the median of all, print on them that lies beside itself is an outlier, though it alone tells how far it is off.
double usual_residual(std::vector<Residual>& residuals, Usual usual);

}  // namespace mq

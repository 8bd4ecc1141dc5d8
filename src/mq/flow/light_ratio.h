#pragma once
/// Two images in another light: how much more of it the one has, from place to place.

#include "mq/image/image.h"

namespace mq {

/// The ratio of the light in the second image to that in the first, which changes slowly: its logarithm, a value per
/// channel, at the pixels of either.
struct LightRatio {
  Image<float> of_source, of_target;
  double size = 0;  ///< root mean square of the logarithm over the pixels halfway and channels
};

/// Whether the ratio may jump, as at the edge of a shadow that lies otherwise in each.
enum class LightBreaks { none, found };

/// What lies along a straight field X halfway, φ₀(p − X/2) and φ₁(p + X/2), tells the ratio of means around p: of the
/// pixels seen in both, by a Gaussian of 8 % of the root of the area, to each of which a hundredth of the mean of both
/// images is added. What is as light as the image can be, above 97 % of its largest value, says nothing. A field that is
/// wrong in details tells it nearly as well, as means over so much change little with them. Images of no negative
/// values; swapped images have the negative logarithm.
///
/// With `found` means are also taken over those pixels alone whose own ratio, the median over 3 % of the root of the area
/// of means over 0.6 %, differs by little from that of p: weights exp(−δ²/(2·0.12²)) of the difference δ of logarithms,
/// on a grid of at most 400 × 400 pixels (a bilateral grid [chen2007bilateral]). That is the ratio where a
/// tenth of its values differs by more than 0.1 from the other: a shadow that covers a third and takes half of the light
/// makes that 0.14 and more, light that falls off towards corners 0.06, other exposures and tints 0.01.
LightRatio light_ratio(const Image<float>& source, const Image<float>& target, const Image<float>& X,
                       LightBreaks breaks = LightBreaks::none);

/// The images in the light of time t, 0 that of the source, 1 that of the target: times 1 + t(r − 1) and
/// 1/r + t(1 − 1/r), r the ratio.
struct LitImages {
  Image<float> source, target;
};
LitImages in_light(const LightRatio& ratio, const Image<float>& source, const Image<float>& target, double t);

/// Both in the light that lies between, so that neither is meant: times √r and 1/√r, and no lighter than the largest
/// value of the other one is then, which may be cut off there.
LitImages in_mean_light(const LightRatio& ratio, const Image<float>& source, const Image<float>& target);

}  // namespace mq

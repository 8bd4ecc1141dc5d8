#pragma once
/// Keyframes as Collet et al. choose them [collet2015high], which the thesis compares texture videos with (6.1, 6.5.1).
///
/// A keyframe is followed forwards and backwards as far as it shows what was captured; then another one is. A frame
/// is a good one where much is apart and nothing is joined that others show open: many components, small genus,
/// large area. Of a frame i with the components C(i),
///
///   S(i) = Σ_{c∈C(i)} 1 + (g_max − g_c) + A_c / (A_max + 1),
///
/// with the largest genus g_max and the largest area A_max of a component of all frames. As published the last term
/// depends on the unit of length; here A_max is 1, so that it is at most ½.

#include <functional>
#include <span>
#include <vector>

#include "mq/mesh/surface.h"

namespace mq {

/// A connected part of a surface.
struct ComponentShape {
  int genus = 0;    ///< with its holes closed: (2 − χ − boundary loops) / 2
  double area = 0;  ///< square model units
};

/// The parts of a surface that have at least `least_part` of its area, the largest first. Linear in the mesh.
std::vector<ComponentShape> component_shapes(const Surface& surface, double least_part = 1e-3);

/// S of every frame, from the parts of each. A frame without parts has 0.
std::vector<double> keyframe_scores(std::span<const std::vector<ComponentShape>> frames);

/// The frames that a keyframe shows, counted from 0, `first` and `last` included.
struct KeyframeRange {
  int keyframe = 0, first = 0, last = 0;
};

/// How far a keyframe is followed of the frames from `first` to `last`, it being one of them.
using FollowKeyframe = std::function<KeyframeRange(int keyframe, int first, int last)>;

/// Of the frames that no keyframe shows, the one of the largest score (the first of equals) becomes the next
/// keyframe, and is followed both ways through those next to it that none shows, until all are shown. By increasing
/// first frame; every frame is in one range. `follow` is called once for each range found. Throws `InvalidInput`
/// where a score is no number, and where what `follow` returns leaves the frames it was asked for or is not around the
/// keyframe.
std::vector<KeyframeRange> choose_keyframes(std::span<const double> scores, const FollowKeyframe& follow);

}  // namespace mq

#pragma once
/// What a change of the surface is, and what a capture only shows for a moment: holes and handles that
/// come and go.

#include <vector>

#include "mq/mesh/surface.h"
#include "mq/remesh/remesh.h"

namespace mq {

/// Per vertex of a template whether the template shows there what is not in the frame, or the frame has
/// what the template does not; or both.
using SeedPlaces = std::vector<unsigned char>;
inline constexpr unsigned char seed_of_template = 1, seed_of_target = 2;

/// Where seeds are, those of the frame at the nearest corner of the template; and within so many edges
/// of these.
SeedPlaces places_of(const RemeshSeeds& seeds, const Surface& of_template, int edges);

/// Where nothing is to be replaced in a frame, as the frames after it do not ask for it as well.
struct PassingPlaces {
  std::vector<char> of_template, of_target;  ///< per vertex
  /// Per vertex of the template 1 at such seeds, and a few edges around: what is distorted there was
  /// pulled by what passes.
  std::vector<char> pulled;
  int seeds = 0;                             ///< seeds of this frame that are there
  int asked = 0;                             ///< and those that are not
};

/// Per vertex of a template 1 where the nearest place of a frame is on its border: over a hole.
std::vector<char> over_holes(const Surface& of_template, const Surface& frame,
                             const ClosestPointFinder& on_frame);

/// Of seeds of the template only those over holes can pass: what else the frame does not have is gone.
/// Seeds within a few edges of each other go together: they pass unless for half of those of either kind,
/// or more, all frames after have seeds of that kind there. `places` are, for each of these frames, those of the
/// same template, which may move a little (`places_of`). Without any nothing passes. O(n).
PassingPlaces passing_places(const RemeshSeeds& now, const Surface& of_template,
                             const std::vector<char>& over_hole,
                             const std::vector<SeedPlaces>& places);

}  // namespace mq

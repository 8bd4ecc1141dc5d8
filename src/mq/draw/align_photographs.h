#pragma once
/// Cameras moved a little, and pictures bent, so that photographs show the same on the surface.

#include <span>
#include <vector>

#include "mq/base/progress.h"
#include "mq/draw/pinhole.h"
#include "mq/image/image.h"

namespace mq {

/// A photograph as it is aligned.
struct AlignedPhotograph {
  PinholeCamera camera;
  Image<float> grey;          ///< brightness, of any size of the camera's proportions
  std::vector<int> places;    ///< that it shows, by number
  std::vector<float> weights; ///< of these, above 0
  double moved = 0;           ///< by alignment: root mean square of its places as far as they are believed, pixels of the camera
};

/// Minimises Σ_v Σ_i w_vi ρ(a_v I_v(π_v(x_i)) + b_v − g_i) over the rotations and translations of all cameras, g_i the
/// mean over the photographs that show place i, robust: by Cauchy's weights of the distances from their median: twenty
/// rounds of a Gauss–Newton step each with g as it was, on pictures reduced to a quarter, to a half and whole
/// ([zhou2014color], with rigid cameras), held where they were by a hundredth
/// of what data weigh at a place. Then ten rounds each, at half size and whole, of steps of their corrections
/// (pinhole.h; a lattice of 24 cells along the longer side), + μ (Σ |f_i − f_j|² over neighbours of the lattice +
/// Σ |f_i|² / 200), μ a fifth of what data weigh at a point in the mean. ρ is Cauchy's, its scale twice the median
/// residual, or while cameras are moved that at detail (detail/usual_residual.h), as is that of the means; a_v, b_v give
/// I_v the mean and the spread that g has at first, robust too, from the median difference on. At
/// first and in every fifth round weights are multiplied by how far the part of the picture in which a place lies shows
/// what the others show (detail/parts_that_agree.h), of cells of that lattice, so that a passer-by moves cameras and
/// bends pictures little. What all cameras have in common, against the
/// mesh, no photograph tells: it is taken back after each size.
///
/// Errors of some pixels are found where there is detail; a photograph that shares fewer than 50 places
/// with others stays. Equal bits for any number of threads.
void align_photographs(std::span<const Vector3> places, std::vector<AlignedPhotograph>& photographs,
                       const Progress& progress = {});

}  // namespace mq

#pragma once
/// What is done at every point of a cell near a seam and for every piece of one that a triangle cuts, in the forms
/// of base/kernel_forms.h; see detail/seam_basis.h.

#include "mq/base/instruction_set.h"
#include "mq/base/kernel_forms.h"

namespace mq {

/// A segment a, a + e of a seam, in a cell.
struct SeamSegment {
  double ax, ay, ex, ey;
  double square;  ///< |e|²
};

/// Of eight points the weight λ of one seam and its gradient; where it is not 0, the parameter s of the nearest
/// point of the segment and its gradient.
struct SeamWeights {
  static constexpr int points = 8;

  int segment;
  double lambda[points], lambda_x[points], lambda_y[points];
  double s[points], s_x[points], s_y[points];
};

/// Values along one seam at one point: λ times what `curve` has at s.
struct SeamCurveTerm {
  int curve;
  double s, s_x, s_y;  ///< parameter from the curve's middle, and its gradient
  double lambda, lambda_x, lambda_y;
};

/// Points of a cell and the functions of its texels, which are columns here.
struct SeamPoints {
  int points, columns;
  int stride;  ///< columns rounded up to a multiple of `column_step`
  const double *x, *y;
  /// What the values are multiplied by, so that their products are those of the mass; then the gradient (gx, gy)
  /// becomes (along·gx + across·gy, down·gy), whose products are those of the stiffness.
  const double *mass, *along, *across, *down;
  const int* first_term;  ///< point q has terms[first_term[q]] … terms[first_term[q + 1] − 1]
  const SeamCurveTerm* terms;
  const double* curves;   ///< per curve c_0, then c_1, then c_2 of all columns: c_0 + c_1 s + c_2 s²
  const double* corners;  ///< px, then qx, py, qy of all columns: bilinear parts (px + qx x)(py + qy y)
};

inline constexpr int column_step = 8;

/// Six points of a rule for triangles, and two more of weight 0.
struct RuleLanes {
  double l1[8] = {}, l2[8] = {}, weight[8] = {};
};

struct SeamKernels {
  /// The weights of eight points that seams within `reach` have, at a distance of `on_seam` or more; returns of how
  /// many seams.
  int (*weights)(const SeamSegment* segments, int count, const double* x, const double* y, double reach,
                 double on_seam, SeamWeights* found);
  /// Upper triangles by rows of mass and stiffness. Room: (3 × points + 4) × stride values.
  void (*block)(const SeamPoints& of, double* room, double* mass, double* stiffness);
  /// ∫ β_p β_q over a convex polygon of `count` corners (x, y), at index p + 3 q (`bernstein_moments`).
  void (*moments)(const RuleLanes& rule, const double* polygon, int count, double* moments);
};

MARQUETRY_KERNELS(SeamKernels, seam_kernels)

}  // namespace mq

#pragma once
/// Exposure of regions: one gain for each region and channel that takes most of the steps between regions out, before
/// what is left of them is spread (stitch.h).
///
/// With l the logarithm of light, let m_ab be the median, over the pairs of neighbouring unknowns i of region a and j
/// of region b, of l_j − l_i, weighted by −S_ij and by how much the pair can say: next to nothing where it is dark, and
/// nothing where a display value has reached white. The logarithms o of the gains minimise
///
///     Σ_ab (o_b − o_a + m_ab)² / σ_ab² + Σ_a o_a² / s²,
///
/// σ_ab how sure the median is: the spread of the differences (1.4826 times their median absolute deviation, or that
/// of all borders where it is less) over the root of the border's length in stretches of `border_stretch` pairs, as
/// neighbouring pairs see the same things; s twice the root mean square of m_ab, borders counted by their pairs. So a
/// long border along which the same step is seen everywhere has its way, and one where two photographs show different
/// things has little. A median, not a mean: what stands before one side of a border only is not light.
/// `bench/stitch_rows` measures it.
///
/// A gradient-domain solve that spreads corrections over the whole surface finds levels too, but from means, and
/// believes all borders alike: over a row of photographs its errors add up.

#include <array>
#include <span>
#include <vector>

#include "mq/fem/space.h"
#include "mq/image/colour.h"

namespace mq {

/// The label of an unknown that no photograph shows.
inline constexpr int unseen = -1;

/// How many pairs of a border count as one that is independent.
inline constexpr double border_stretch = 8;

/// Pairs of neighbouring unknowns in two regions a < b: what all borders have to say.
struct RegionPairs {
  std::vector<std::array<int, 2>> regions;  ///< a, b
  std::vector<double> weights;              ///< −S_ij
  Signal from, to;                          ///< values of i in a, and of j in b
};

/// Those whose unknown of the lower label is one of `rows`, in their order; in a part of a space its own rows. Throws
/// `InvalidInput` where sizes differ.
RegionPairs region_pairs(const SparseMatrix& stiffness, const Signal& psi, std::span<const int> labels,
                         std::span<const int> rows);

class RegionLevels {
 public:
  /// None: nothing is changed.
  RegionLevels() = default;

  /// Of regions of equal labels, from 0 on; what is `unseen` has none. The last of two or four channels is alpha, and
  /// stays. The mean of o over regions that border on each other, directly or by others, is 0, by area (`mass`).
  /// Throws `InvalidInput` where sizes differ.
  RegionLevels(const SparseMatrix& stiffness, const Vector& mass, const Signal& psi, std::span<const int> labels,
               LightLaw law);

  /// The same of all pairs and the area of each region.
  RegionLevels(const RegionPairs& pairs, std::span<const double> areas, LightLaw law);

  /// Logarithms of the gains, a row for each label and a column for each colour channel; no rows: none.
  const Signal& gains() const { return gains_; }

  /// Values of a region as they are with its gain.
  void raise(int label, Eigen::Ref<Eigen::RowVectorXd> values) const;

  /// The same of all; what is unseen stays.
  Signal raised(const Signal& psi, std::span<const int> labels) const;

 private:
  Signal gains_;
  LightLaw law_ = LightLaw::log;
};

}  // namespace mq

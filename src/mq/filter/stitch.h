#pragma once
/// Stitching: one signal of several that were taken apart (photographs of parts of a surface), each
/// right up to an offset of its own.
///
/// The gradients of each part are kept, the steps between parts are not believed, and the rest is a
/// screened Poisson equation (thesis 5.9.2; [prada2018gradient]). In a triangle, or in a cell
/// between texels, that lies in one region the target is ∇ψ. Where several regions ℓ meet it is the
/// mean, weighted by how many corners each has, of the gradients of functions with the values
///
///     v_j = ψ_j inside ℓ,   mean over its corners i of  ψ_i + g_i·(x_j − x_i)  elsewhere,
///
/// g_i a least-squares slope of ψ around i in its own region, by no more than three times the
/// largest step to a neighbour: each region goes on smoothly past its border. So offsets added to a
/// function that is linear there are removed exactly; at a seam this is to say that both sides have
/// the same values. (The thesis puts differences 0 across borders, which is off by a step of the
/// slope at every one of them: `Borders::level`.)
///
/// The functions below return the change Σ_e S_e (v^e − ψ) of S·ψ that this asks for, summed over
/// the elements e where regions meet, which is what `ScreenedPoisson::solve_change` takes: exactly
/// 0 where there is one region, of sum 0 per channel, and bounded in energy by the steps
/// themselves, so that texels that hardly matter cannot be driven away.

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "mq/atlas/atlas.h"
#include "mq/fem/space.h"
#include "mq/fem/texels.h"
#include "mq/filter/region_levels.h"
#include "mq/filter/screened_poisson.h"
#include "mq/image/image.h"
#include "mq/mesh/mesh.h"

namespace mq {

/// What is asked of the differences between regions where they meet.
enum class Borders {
  continued,  ///< those of each going on past its border, as said above
  level,      ///< none: z_ij = 0 between regions (thesis 5.9.2), see `SignalSpace::edge_divergence`; all must be seen
  published   ///< the same, and where something is unseen none either: it keeps its values and loses its differences
};

/// The pixel of a label picture, of any size, that is nearest to a texel of a texture of this size.
std::span<const float> nearest_pixel(const Texels::Place& texel, const TextureSize& texture, const Image<float>& picture);

/// Labels that pictures show, one for each texture and painted in its coordinates: texels of equal
/// colour at the nearest pixel have equal labels, counted from 0 in the order of the unknowns.
/// Texels of the colour `unseen_colour` (all its values within 5e-6), and where a last of two or
/// four channels is 0, are `unseen`. Throws `InvalidInput` where there is not one picture per
/// texture.
std::vector<int> labels_of_pictures(const Texels& texels, std::span<const TextureSize> textures,
                                    std::span<const Image<float>> pictures,
                                    const std::optional<std::vector<float>>& unseen_colour = {});

/// One signal put together from regions: unknowns of equal labels come from one photograph. Nothing
/// is asked of elements where something is unseen. Throws `InvalidInput` where sizes differ.
Signal stitch_regions(const SignalSpace& space, const Signal& psi, std::span<const int> labels);

/// The same as published: −∫ ⟨ω, ∇φ_t⟩ dA of the field ω = Σ (ψ_j − ψ_i)(φ_i ∇φ_j − φ_j ∇φ_i) over the pairs (i, j) of
/// different labels, both seen, that S couples. It leaves no slope across a border, of a step and of what is there alike.
Signal level_borders(const SignalSpace& space, const SparseMatrix& stiffness, const Signal& psi,
                     std::span<const int> labels);

/// How regions go on around the unknowns where they meet, a row for each unknown of the space: the three components of g
/// channel by channel, then the largest step to a neighbour of each. 0 elsewhere. In a part of a space, whose rows
/// of S are whole for its own unknowns alone, theirs are right and the others are to be fetched.
Signal region_slopes(const SignalSpace& space, const SparseMatrix& stiffness, const Signal& psi,
                     std::span<const int> labels);

/// `stitch_regions` with these slopes.
Signal stitch_regions(const SignalSpace& space, const Signal& psi, std::span<const int> labels, const Signal& slopes);

/// One photograph, as a signal on the whole surface and how well it shows each unknown.
struct Partial {
  Signal values;
  std::vector<double> confidence;  ///< 0: does not show it; otherwise positive
};

/// The numbers of photographs that pictures show, one for each texture and painted in its
/// coordinates: the first channel of the nearest pixel times `steps[k]` for the picture of texture
/// k, rounded. Where a last of two or four channels is 0, `unseen`. Throws `InvalidInput` where
/// there is not one picture per texture.
std::vector<int> numbers_of_pictures(const Texels& texels, std::span<const TextureSize> textures,
                                     std::span<const Image<float>> pictures,
                                     std::span<const double> steps);

/// The signal of which each unknown has the value of one photograph, and that photograph's number,
/// or `unseen` and the mean of what is seen.
struct Composite {
  Signal values;
  std::vector<int> labels;
};
/// Of the photograph with the number `wanted` where that one shows the unknown, else of the one
/// that shows it best (of equals the first). No numbers, or `unseen`: always of that one. Throws
/// `InvalidInput` for a number that no photograph has.
Composite best_of(std::span<const Partial> partials, std::span<const int> wanted = {});

/// Of the photographs with these numbers, each of which shows its unknown, or `unseen`.
Composite composite_of(std::span<const Partial> partials, std::vector<int> labels);

/// The same for a composite; where a region goes on past its border and its photograph still shows
/// what is there, v_j is the photograph's own value.
Signal stitch_partials(const SignalSpace& space, std::span<const Partial> partials,
                       const Composite& composite);

/// What photographs show of unknowns for which others were chosen, where regions meet. Of many photographs
/// so little is asked that they need not be held at once:
///
///     BeyondBorders beyond(space, labels, channels);
///     for (int k = 0; k < photographs; ++k)            // one after another
///       for (int i : beyond.unknowns_of(k))
///         if (shown) beyond.put(k, i, values);
class BeyondBorders {
 public:
  /// Labels are numbers of photographs, or `unseen`.
  BeyondBorders(const SignalSpace& space, std::span<const int> labels, int channels);

  /// What `Stitcher` asks of a photograph, increasing.
  std::span<const int> unknowns_of(int photograph) const;

  /// Throws `InvalidInput` where that is not asked.
  void put(int photograph, int unknown, const Eigen::RowVectorXd& values);

  /// Whether it was put; then `values` become it.
  bool find(int photograph, int unknown, Eigen::RowVectorXd& values) const;

 private:
  std::ptrdiff_t place_of(int photograph, int unknown) const;

  std::vector<std::ptrdiff_t> offsets_;  ///< per photograph
  std::vector<int> unknowns_;
  std::vector<char> known_;
  Signal values_;
};

/// Solves for stitched signals of one partition. What is unseen has no value that could be kept and
/// no gradient: the equation is solved on the surface without it, and it is filled by the harmonic
/// function of what is around it. A component of which nothing is seen becomes constant.
///
///     const Filtered result = Stitcher(space, weight, labels).stitch(psi);
class Stitcher {
 public:
  /// Where something is unseen, two systems are solved instead of one.
  enum class Systems {
    kept,     ///< prepared once
    one_each  ///< prepared whenever they are needed and then forgotten: for one signal, in half the memory
  };

  /// Assembles the stiffness, and throws what `ScreenedPoisson` throws, which `one_each` leaves to the others.
  /// `space` must outlive the object.
  Stitcher(const SignalSpace& space, double weight, std::vector<int> labels,
           const SolverFactory& factory = {}, const Progress& progress = {}, Systems systems = Systems::kept);

  /// What `stitch` of a signal asks for where regions meet; `continued` without it. `published` solves one system of the
  /// whole surface, which is prepared then.
  void set_borders(Borders borders) { borders_ = borders; }

  /// Other regions of the same signal; the systems stay. Throws `InvalidInput` where something else
  /// is unseen.
  void regroup(std::vector<int> labels);

  /// The signal with harmonic values where it is unseen, the rest as it was.
  Signal fill(const Signal& psi, const Progress& progress = {}) const;

  /// `stitch_regions` and `stitch_partials` with the stiffness that is there already. The composite
  /// must have the labels of the stitcher.
  Signal change(const Signal& psi) const;
  Signal change(std::span<const Partial> partials, const Composite& composite) const;
  Signal change(const Signal& psi, const BeyondBorders& beyond) const;

  /// The filled ψ with its gradient changed. An unknown around which others of its region have five
  /// times its S_ii, a texel that hardly meets the surface, changes by no more and no less than
  /// these. But for that the mean of each component's seen part is kept
  /// (where something is unseen, to 1e-4 of the change). Where nothing is to be changed ψ comes
  /// back bit for bit. Where something is unseen, about six solves.
  Filtered solve(const Signal& psi, const Signal& change, const Progress& progress = {}) const;

  /// The gains of these regions.
  RegionLevels levels(const Signal& psi, LightLaw law) const;

  /// All of it: ψ with the gains of its regions, if they are given, filled and solved with the change that its regions ask for,
  /// or where it is a composite of photographs, these (not for level borders, of which these say nothing).
  Filtered stitch(const Signal& psi, std::span<const Partial> partials = {}, const RegionLevels& levels = {},
                  const Progress& progress = {}) const;

  /// All of it, of photographs that are known where regions meet, towards other values than ψ has: near
  /// ψ + offset, with the gradients of ψ. What is unseen is harmonic. Two solves, since steps between
  /// photographs are near to even already: means are those of ψ + offset only nearly.
  Filtered stitch(const Signal& psi, const BeyondBorders& beyond, const Signal& offset,
                  const Progress& progress = {}) const;

  const SparseMatrix& stiffness() const { return stiffness_; }

 private:
  using System = std::shared_ptr<const ScreenedPoisson>;
  System prepared(double weight, const Progress& progress) const;
  System equation(const Progress& progress) const;
  Filtered stitch_as_published(const Signal& psi, const Progress& progress) const;
  bool sees_all() const { return mass_.size() == 0; }

  const SignalSpace& space_;
  const double weight_;
  const SolverFactory factory_;
  SparseMatrix stiffness_;
  std::vector<Vector3> positions_;
  std::vector<int> labels_;
  Borders borders_ = Borders::continued;
  Vector mass_;  ///< lumped, where something is unseen
  System equation_, filler_;  ///< null: are prepared when they are needed; `filler_`: or all is seen
};

/// The largest change, over the channels, of the mean over the part of the surface that is seen; 0
/// where nothing is. Throws `InvalidInput` where sizes differ.
double mean_drift(const SignalSpace& space, const Signal& before, const Signal& after,
                  std::span<const int> labels);

/// Root mean square of the differences across borders, over the channels together, each pair with
/// its weight −S_ij where that is positive, and of those within regions.
struct BorderJump {
  double across = 0;
  double within = 0;
  std::int64_t pairs = 0;  ///< across borders
};
BorderJump border_jump(const SparseMatrix& stiffness, const Signal& psi,
                       std::span<const int> labels);

}  // namespace mq

#pragma once
/// Sharpening without halos: edges become steep, and hardly go beyond what is around them.
///
/// What (β − 1) times a gradient adds is far more than the eye wants where an edge is strong: beside it a bright
/// and a dark fringe appear, and values leave the range that can be stored. Where contrast is low it is just what is
/// wanted. So the change of the gradients is split, by the contrast around each unknown, into that of texture,
/// which is taken as the equation gives it, and that of edges, which may not carry a value beyond those around it
/// by more than a part of their contrast. To amplify detail and not the edges around it is what [farbman2008edge] do
/// with a base that keeps edges; to hold sharpened values to the least and the greatest around them is usual in
/// video. Here neighbours are those of the space, across seams too.

#include <span>
#include <vector>

#include "mq/base/progress.h"
#include "mq/fem/space.h"
#include "mq/filter/screened_poisson.h"
#include "mq/filter/shared_unknowns.h"

namespace mq {

struct HaloOptions {
  /// By what part of the contrast around it an edge may carry a value beyond it. 0: not at all.
  double fraction = 0.2;

  /// Contrast, in units of the values, from which on everything is an edge; up to half of it everything is
  /// texture, between them in part (a cubic).
  double contrast = 0.2;

  /// Contrast up to which nothing is sharpened, as it is rounding, or blocks of a lossy format; from twice it on all is,
  /// between them in part (a cubic). 0: all.
  double threshold = 0;

  /// What is around an unknown: what so many steps to neighbours reach. Across a seam a step goes up to two texels
  /// far, so that beside seams more of the fraction is made use of.
  int reach = 3;
};

/// Whether a modulation makes gradients steeper anywhere, so that there may be halos.
bool sharpens(std::span<const double> beta);

/// What a signal ψ has around each unknown.
///
/// `texture` goes by the contrast r = max − min of the channel where it is largest. The range [low, high] that
/// changes by edges are kept to is the mean of such ranges around, so that it has no step where an edge comes into
/// reach; it holds ψ itself.
class HaloLimit {
 public:
  /// Throws `InvalidInput` where the signal does not fit or is not finite, a fraction or threshold is negative or not
  /// finite, the contrast not positive, or the reach below 1. Costs the matrix for a moment, 2·reach passes over
  /// its couplings, and keeps two floats a value, up to eight at least of more than one channel, and two doubles an
  /// unknown.
  HaloLimit(const SignalSpace& space, const Signal& psi, const HaloOptions& options = {},
            const Progress& progress = {});

  /// The same for one of several processes, by a matrix that couples neighbours, its own rows complete; `psi` has
  /// values of the halo too.
  HaloLimit(const SparseMatrix& A, const Signal& psi, const HaloOptions& options, const SharedUnknowns& shared,
            const Progress& progress = {});

  /// Per unknown the part of a change of gradients that is texture's: 1 up to half of the contrast of
  /// `HaloOptions`, 0 from all of it on.
  std::span<const double> texture() const { return texture_; }

  /// Of a modulation β what is left of it by the threshold: 1 + (β − 1)·heard where β is more than 1.
  std::vector<double> of_detail(std::span<const double> beta) const;

  /// Of a modulation β the part for texture: 1 + (β − 1)·texture where β is more than 1, else β itself, since what
  /// smooths has no halos.
  std::vector<double> of_texture(std::span<const double> beta) const;

  /// Of a value and what edges add to it: their sum where that lies in the range or leaves it by no more than
  /// half of what is allowed, fraction·(high − low); what goes on is bent, with an even slope, and never gets all of
  /// what is allowed. Nothing added gives the value back bit for bit.
  double limited(std::int64_t unknown, int channel, double value, double added) const;

  /// What becomes of a value of which the solution for all of β is larger by `all`, and that for its part of texture by
  /// `texture`.
  double sharpened(std::int64_t unknown, int channel, double value, double all, double texture) const {
    return limited(unknown, channel, value, all - texture) + texture;
  }

 private:
  /// Which unknowns a matrix couples: row i to columns[starts[i]] … columns[starts[i + 1] − 1].
  struct Couplings {
    std::span<const int> starts, columns;
  };
  struct OwnCouplings;
  HaloLimit(const OwnCouplings& own, const Signal& psi, const HaloOptions& options, const Progress& progress);
  HaloLimit(const Couplings& A, const Signal& psi, const HaloOptions& options, const SharedUnknowns& shared,
            const Progress& progress);
  template <int width, class Combine>
  static void for_all_rows(const Couplings& A, int floats, const std::vector<float>& from, std::vector<float>& to,
                           const Combine& combine);
  template <int width>
  static void widen(const Couplings& A, int floats, std::vector<float>& values, std::vector<float>& room);
  template <int width>
  static void average(const Couplings& A, int floats, std::vector<float>& values, std::vector<float>& room);
  void fill_halo(const SharedUnknowns& shared);
  double low(std::int64_t unknown, int channel) const;
  double high(std::int64_t unknown, int channel) const;

  int channels_ = 0;
  int floats_ = 0;  ///< of `ranges_` an unknown
  double fraction_ = 0;
  std::vector<float> ranges_;  ///< per unknown low for each channel, then −high for each
  std::vector<double> texture_;
  std::vector<double> detail_;  ///< the part that the threshold leaves; empty: all
};

/// `equation.solve(psi, beta)`, with halos limited: with φ_t the solution for the part of β that is texture's, and
/// φ that for β, of which the threshold takes what it takes first, it is limited(ψ + φ − φ_t) + φ_t − ψ. Where β is nowhere
/// above 1, or the contrast of ψ nowhere above half of the given one and there is no threshold, it is φ, bit for bit.
/// Where gradients are strong or none it leaves the range of ψ around it by less than the fraction. The mean is not kept.
/// `space` is that of the equation, `limit` that of ψ. Costs two solutions.
Filtered solve_without_halos(const ScreenedPoisson& equation, const SignalSpace& space, const Signal& psi,
                             std::span<const double> beta, const HaloLimit& limit, const Progress& progress = {});

/// The same, and `equation.solve(psi, beta)` where there is no limit, in three steps that do not need the same things, so that
/// each may have the memory of the others.
class SolveInSteps {
 public:
  /// Takes what the change of gradients is from the space. The limit, if there is one, must outlive the object.
  SolveInSteps(const SignalSpace& space, const Signal& psi, std::span<const double> beta, const HaloLimit* limit);

  /// Needs the equation alone; once.
  SolveReport solve(const ScreenedPoisson& equation, const Progress& progress = {});

  /// The filtered signal; once.
  Signal solution(const Signal& psi) &&;

 private:
  const HaloLimit* limit_;
  Signal all_, texture_;  ///< what gradients change by, then what values do; of texture: empty where that is all
};

/// The same, with a limit of its own.
Filtered solve_without_halos(const ScreenedPoisson& equation, const SignalSpace& space, const Signal& psi,
                             std::span<const double> beta, const HaloOptions& options = {},
                             const Progress& progress = {});

}  // namespace mq

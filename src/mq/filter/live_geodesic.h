#pragma once
/// Distances from a source that moves: some at once, better ones with every frame.

#include <memory>
#include <vector>

#include "mq/base/progress.h"
#include "mq/fem/texel_space.h"
#include "mq/fem/vertex_space.h"
#include "mq/filter/geodesic.h"

namespace mq {

struct LiveGeodesicOptions {
  enum class Method {
    published,   ///< thesis 5.9.3: a cycle of multigrid on each of the two equations
    progressive  ///< a front on a coarser level at once, then what `GeodesicDistance` does, part by part
  } method = Method::progressive;

  GeodesicOptions geodesic = {};  ///< of `progressive`
  double published_alpha = 1e-3;  ///< of `published`: t over the area of the surface

  /// Of `progressive`: the front runs on the first level with no more nodes than this: 27,000 take 19 ms.
  int most_front_nodes = 50'000;
};

/// What a step did.
struct LiveGeodesicStep {
  enum class Part {
    rest,        ///< nothing: distances are as good as they become
    front,       ///< the first distances from a source
    misses,      ///< of the heat equation, by how much rows miss
    carry,       ///< these carried along: with it a sweep is done
    boundary,    ///< heat continued from inside to the boundary
    directions,  ///< its gradient brought to length 1
    moments,     ///< and to the right-hand side of the Poisson equation
    cycle,       ///< of multigrid on that
    published    ///< a cycle on both equations
  } part = Part::rest;

  /// Whether `distance` is another since.
  enum class Shown { as_before, anew } shown = Shown::as_before;

  double change = 0;  ///< by a cycle of any distance at most, model units; 0 for other parts
};

/// Distances as of `GeodesicDistance`, for a source that moves. One step is what fits between two frames.
///
/// **progressive.** The first step after a move finds the front that starts from the source
/// (`fast_marching_distances`) on a coarser level of the multigrid hierarchy of S, level by level from the
/// coarsest, each visited in the order that the one before it found; distances go to the unknowns by the
/// hierarchy's interpolation, and around the source they are straight ones. While the source moves on with
/// every frame, that is all. Where it rests, log u begins there and the sweeps of `sweep_heat` follow, half
/// a sweep a step; after the 1st, 2nd, 4th, ... and the last sweep
///
///     S·δ = ∫ ⟨∇w·(1/|∇w| − 1), ∇φ_i⟩ dA,        φ = w + δ,        w = −√t·log u,
///
/// gets a cycle of multigrid in single precision, begun from the δ that the last φ leaves; after the last
/// one cycles go on until they change less than a hundredth of a spacing. So it ends where
/// `GeodesicDistance` ends, but that sweeps begun elsewhere end elsewhere within the same tolerance.
///
/// **published.** From u = φ = 0 at a source that has moved, every step takes one cycle on
///
///     (M + t·S)·u = M·δ_source        and one on        S·φ = −∫ ⟨∇u/|∇u|, ∇φ_i⟩ dA,
///
/// u as it is by then (thesis 5.9.3, equations (5.15) and (5.16)), t = `published_alpha` times the area; φ
/// is moved to 0 at the source. It ends at distances that so long a t has smoothed. Only which unknowns are
/// sources counts.
///
/// The same bits for any number of threads. Milliseconds per step: docs/measurements/geodesic.md.
class LiveGeodesic {
 public:
  /// Assembles and makes the levels. `space` must outlive the object. Throws `InvalidInput` for a time that
  /// is not positive.
  explicit LiveGeodesic(const TexelSpace& space, const LiveGeodesicOptions& options = {},
                        const Progress& progress = {});
  explicit LiveGeodesic(const VertexSpace& space, const LiveGeodesicOptions& options = {},
                        const Progress& progress = {});
  ~LiveGeodesic();
  LiveGeodesic(LiveGeodesic&&) noexcept;

  /// Where distances begin from now on; they stay as they are until the next step. Throws `InvalidInput` as
  /// `GeodesicDistance::from` does, and then nothing has changed.
  void move(const std::vector<GeodesicSource>& sources);

  /// Throws `InvalidInput` where `move` has not been called. Stopped by `progress`, the same step can be
  /// taken again.
  LiveGeodesicStep step(const Progress& progress = {});

  /// Whether further steps do nothing. (`published` never says so: it may go on.)
  bool rests() const;

  /// As of the last step: per unknown, model units, infinite where no path leads; empty before the first.
  const Vector& distance() const;

  /// What implements a method.
  class Way;

 private:
  std::unique_ptr<Way> way_;
};

}  // namespace mq

#pragma once
/// Shock filters on textures: sharpened on the surface, across seams.

#include <memory>

#include "mq/atlas/atlas.h"
#include "mq/fem/texel_space.h"
#include "mq/filter/shock.h"

namespace mq {

/// P = ½ Σ_c |∇φ_c|² of all channels, its mean over each cell between texels (and each strip along a seam), then its mean
/// around each texel; smoothed: thesis 3.3.1 on texels. φ is smoothed before. One value per texel, (unit of φ)²/length².
/// The rest is as for vertices.
Vector shock_potential(const TexelSpace& space, const Signal& phi, const ShockWeights& weights,
                       const SolverFactory& factory = {}, std::vector<SolveReport>* reports = nullptr,
                       const Progress& progress = {});

struct TextureShockOptions {
  ShockWeights weights;
  ShockTime time;
  SolverFactory solver = {};  ///< of systems of texels; empty: `SignalSpace::solver`
};

/// A sharpened texture and how it came about.
struct ShockedTexture {
  Signal signal;
  double rate = 0;  ///< Λ
  double time = 0;
  PathCounts counts;
  double path_seconds = 0;
  std::vector<SolveReport> solves;
};

/// `transport_shock` for a signal of texels, in the texture itself: the potential is one of texels, and paths run over
/// the cells between them and over seams (`AtlasFlow`). No triangle is cut; the result does not depend on how the
/// surface is cut into triangles, and by no more than interpolation on the size of the texture. Paths begin at the
/// centres of texels, and values are those of the texture where they end. Texels whose centre lies outside their chart
/// begin where the straight way over the border leads, on the other side of a seam, so that lookups on both sides agree.
/// Their own value, which need not be the signal's there, fades over a mean texel's side of the way: a value lies between
/// its own and the one found, and moves no further than its path does. Texels in the midst of charts that differ from one
/// around them by more than a twentieth of the standard deviation become the mean over paths from eight places in them, so
/// that outlines show no stairs; a texel's own value fades in the same way there. A time of 0 leaves all values as they are, bit for
/// bit; texels whose path rests at once keep theirs. No value leaves the range of its channel.
///
/// Triangles without chart take no part: paths end there as at a boundary. `signal` is space.size() × channels. Beside
/// the space and its solver about 130 bytes per texel; throws what `shock_potential` and `AtlasFlow` throw.
ShockedTexture texture_shock(const Surface& surface, const Atlas& atlas, const TexelSpace& space,
                             const Signal& signal, const TextureShockOptions& options,
                             const Progress& progress = {});

/// The same for one time after the other: the potential and all that does not depend on the time is
/// made once, and a time costs its paths.
///
///     const TextureShock shock(surface, atlas, space, signal, options);
///     const ShockedTexture mild = shock.at({ShockTime::Unit::relative, 1});
class TextureShock {
 public:
  /// `options.time` is not looked at. Surface, atlas and space must outlive the object. Throws as
  /// above.
  TextureShock(const Surface& surface, const Atlas& atlas, const TexelSpace& space, Signal signal,
               const TextureShockOptions& options, const Progress& progress = {});
  ~TextureShock();

  /// `texture_shock` at this time, to the last bit.
  ShockedTexture at(const ShockTime& time, const Progress& progress = {}) const;

  /// P per texel, down which paths run.
  const Vector& potential() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace mq

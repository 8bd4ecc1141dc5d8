#pragma once
/// Shock filters on textures by paths on triangles no larger than texels, to compare `texture_shock` with.

#include "mq/atlas/atlas.h"
#include "mq/fem/texel_space.h"
#include "mq/fem/vertex_multigrid.h"
#include "mq/filter/shock.h"

namespace mq {

/// A longest edge for textures of so many texels: 0.7, with which the outline of a blurred disc becomes
/// as smooth as texels allow (at 1.4 it has teeth of half a texel more), as long as that is 1.5 million
/// vertices, and otherwise what is, but 1.4 at most.
double usual_longest_edge(int texels);

struct CutTextureShockOptions {
  ShockWeights weights;
  ShockTime time;
  double longest_edge = 1.4;  ///< of the mesh on which paths run, texels
};

/// A sharpened texture and how it came about.
struct CutShockedTexture {
  Signal signal;
  int vertices = 0;  ///< of the mesh on which paths ran
  double rate = 0;   ///< Λ
  double time = 0;
  PathCounts counts;
  double path_seconds = 0;
  std::vector<SolveReport> solves;
};

/// `transport_shock` for a signal of texels. Triangles are cut until no edge is longer than
/// `longest_edge` in their chart (`refine`); the potential is that of the signal's values at the
/// vertices so made. Paths begin at the centres of texels, and values are those of the texture
/// itself where they end: what the filter leaves in place loses nothing to a mesh. Texels whose
/// centre lies outside their chart begin at the nearest point of the surface, which is across a
/// seam where there is one, so that lookups on both sides agree. Their own value, which need not be
/// the signal's there, fades over a mean texel's side of the way: a value lies between its own and
/// the one found, and moves no further than its path does. A time of 0 leaves all values as they
/// are, bit for bit; texels whose path rests at once keep theirs. No value leaves the range of its
/// channel.
///
/// Triangles without chart take no part: paths end there as at a boundary. The solver is for the
/// mesh made, 1.3 vertices per texel, 2 where charts are scraps; systems are well conditioned while
/// weights are small. `signal` is space.size() × channels. 760 bytes per vertex at the peak; throws
/// `OutOfMemory` before it starts, and once more when the triangles are cut, where there is less.
CutShockedTexture cut_texture_shock(const Surface& surface, const Atlas& atlas, const TexelSpace& space,
                                    const Signal& signal, const CutTextureShockOptions& options,
                                    const Progress& progress = {});

}  // namespace mq

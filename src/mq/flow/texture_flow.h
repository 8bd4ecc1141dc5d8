#pragma once
/// Optical flow between two textures of one atlas: in the texture itself, across seams.


#include "mq/flow/surface_optical_flow.h"
#include "mq/flow/texture_levels.h"

namespace mq {

/// The flow of two signals of texels: `mesh_flow` with a vector per texel (`TexelVectorSpace`) in place of one per
/// vertex, on the texture and on smaller and smaller ones of the same atlas; no triangle is cut. Levels, steps and errors
/// are those of `MeshFlow`; lengths may be in texels, and `smallest` is four texels where none is given. Values between
/// the two are found by following the field from the centre of each texel over cells and seams (`AtlasFlow`) and looking
/// the textures up at the ends (`TraceAtlas::sharp_value`), so that what does not move loses nothing: a texel both of
/// whose paths rest keeps its values bit for bit. Texels whose centre lies outside their chart follow the path of the
/// nearest point of the surface, so that lookups agree across seams, and change by as much as the texture changes along
/// it: what they hold beside it, such as the dark ground of an atlas, stays. While textures are aligned such texels are
/// what lookups find where their paths begin. No value leaves the range of the textures.
///
/// Where charts lie upon each other, mirrored halves for example, both move along the field that the one of the earliest
/// turn has (`Texels::chart`).
///
/// Surface, atlas and space must outlive it. Throws what `mesh_flow` throws; `Unsupported` for another basis than the
/// vertices', another solver than the hierarchical, or the thesis' weights, for which there is `CutTextureFlow`.
class TextureFlow {
 public:
  TextureFlow(const Surface& surface, const Atlas& atlas, const TexelSpace& space, const Signal& source,
              const Signal& target, const MeshFlowOptions& options = {}, const Progress& progress = {});

  /// Its `field` has two components per texel in the texel's plane.
  const MeshFlow& flow() const { return flow_; }

  /// Both textures as they meet at time t between 0 and 1, equation (4.26): φ₀ at the ends of paths along −X for t, φ₁
  /// along X for 1 − t. At its own time each comes back bit for bit.
  WarpedPair warp_pair(const Signal& source, const Signal& target, double t, const Progress& progress = {}) const;

  /// X as `AtlasFlow::along` follows it.
  std::vector<std::array<double, 2>> velocities() const { return textures_[0].vectors().velocities(flow_.field); }

  /// X on the triangles of the surface, in space (`TexelVectorSpace::on_triangles`).
  TangentField field() const { return textures_[0].vectors().on_triangles(flow_.field); }

 private:
  Signal looked_up(const Signal& signal, double time, const Progress& progress) const;

  FlowTextures textures_;
  MeshFlow flow_;
};

}  // namespace mq

#pragma once
/// Optical flow between two textures of one atlas, found on triangles cut to the size of texels.

#include "mq/atlas/atlas.h"
#include "mq/fem/tangent_fields.h"
#include "mq/fem/texel_space.h"
#include "mq/filter/refined_texture.h"
#include "mq/flow/surface_optical_flow.h"
#include "mq/trace/trace_mesh.h"

namespace mq {

/// The flow of two signals of texels in the bases that the thesis has (`TextureFlow` is faster and finds more). Triangles are cut until no edge is longer than `longest_edge`
/// in their chart, the textures are looked up at the vertices so made (with edges above two texels:
/// their means around them), and `mesh_flow` aligns these. Values between the two are found by
/// following the field from the centre of each texel and looking the textures themselves up at the
/// ends, so that what does not move loses nothing to the mesh: a texel both of whose paths rest
/// keeps its values bit for bit. Texels whose centre lies outside their chart follow the path of
/// the nearest point of the surface, so that lookups agree across seams, and change by as much as
/// the texture changes along it: what they hold beside it, such as the dark ground of an atlas,
/// stays, so that pictures at near times are near each other. No value leaves the range of the
/// textures.
///
/// Surface, atlas and space must outlive it.
class CutTextureFlow {
 public:
  /// `longest_edge` in texels.
  CutTextureFlow(const Surface& surface, const Atlas& atlas, const TexelSpace& space, const Signal& source,
                 const Signal& target, const MeshFlowOptions& options, double longest_edge,
                 const Progress& progress = {});

  const MeshFlow& flow() const { return flow_; }
  int vertices() const { return refined_.fine().surface.mesh.vertex_count(); }

  /// Both textures as they meet at time t between 0 and 1, equation (4.26): φ₀ at the ends of paths
  /// along −X for t, φ₁ along X for 1 − t. At its own time each comes back bit for bit.
  WarpedPair warp_pair(const Signal& source, const Signal& target, double t,
                       const Progress& progress = {}) const;

  /// X on the triangles of the surface: the mean over their parts by area, in space.
  TangentField field() const;

 private:
  Signal looked_up(const Signal& signal, double time, const Progress& progress) const;

  const Surface& source_;
  RefinedTexture refined_;
  MeshFlow flow_;
  TraceMesh mesh_;
  std::vector<SurfacePoint> starts_;
};

}  // namespace mq

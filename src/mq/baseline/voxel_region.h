#pragma once
/// The region to replace, grown on voxels as the thesis does it (6.3.2, as [wojtan2009deforming] before), to compare
/// `remesh` with. How both surfaces are stitched along it is not here.

#include <span>

#include "mq/base/progress.h"
#include "mq/mesh/mesh.h"

namespace mq {

struct VoxelRegion {
  int seeded = 0;            ///< voxels that hold a seed
  int voxels = 0;            ///< of the region
  double template_area = 0;  ///< of the template inside of it, which goes, square model units
  double target_area = 0;    ///< of the target inside of it, which comes
};

/// Voxels of side `voxel` that hold seeds, vertices of either mesh, are marked. Where a face between a marked voxel and
/// one that is not is not met alike by both meshes, the other voxel is marked too, until all are. A face is met alike
/// where each of its four edges is crossed as many times by one mesh as by the other, and where none is, no mesh meets
/// it. So both end in curves that pass the same edges of voxels in the same number. (The thesis wants the two
/// intersections consistent, and does not say how that is found.)
///
/// Triangles are split into up to 256 to be trimmed, each part to the side of its middle. Points on a plane between
/// voxels belong to the upper one. Time and memory in proportion to the voxels that the meshes meet. Throws
/// `InvalidInput` where `voxel` is not positive, or less than 2⁻²⁰ of the size of both.
VoxelRegion voxel_region(const Mesh& of_template, const Mesh& target, std::span<const int> template_seeds,
                         std::span<const int> target_seeds, double voxel, const Progress& progress = {});

}  // namespace mq

#pragma once
/// Which unknowns of a frame are which of the frame before.

#include <cstdint>
#include <vector>

#include "mq/atlas/atlas.h"
#include "mq/evolving/evolving_mesh.h"
#include "mq/fem/texel_space.h"

namespace mq {

/// Per unknown of a frame where its point of the surface was in the frame before: φ_before there is
/// Σ weight · φ_before[column] over entries[starts[i]] … entries[starts[i + 1] − 1]; none: the
/// point was not there. Weights sum to 1.
struct TimeLinks {
  struct Entry {
    int column;
    double weight;
  };
  std::vector<int> starts = {0};
  std::vector<Entry> entries;

  int rows() const { return int(starts.size()) - 1; }
  bool linked(int row) const { return starts[row + 1] > starts[row]; }

  /// The unknown that is the same texel in both frames, −1: there is none.
  int same(int row) const {
    return starts[row + 1] - starts[row] == 1 ? entries[starts[row]].column : -1;
  }

  /// The unknown that counts most, −1 where there is none.
  int nearest(int row) const;
};

/// Links of `count` unknowns that are the same in both frames.
TimeLinks identical_links(int count);

/// One frame of an evolving mesh with an atlas, as a space of signals.
class AtlasFrame {
 public:
  /// Throws `InvalidInput` where the segment has no texture coordinates, and as `TexelSpace` does.
  AtlasFrame(const EvolvingSegment& segment, const std::vector<Vector3>& positions, int width,
             int height, const Progress& progress = {});

  const TexelSpace& space() const { return *space_; }
  const EvolvingSegment& segment() const { return segment_; }
  const Atlas& atlas() const { return *atlas_; }
  const Surface& surface() const { return *surface_; }

 private:
  EvolvingSegment segment_;
  std::unique_ptr<Surface> surface_;
  std::unique_ptr<Atlas> atlas_;
  std::unique_ptr<TexelSpace> space_;
};

/// The thesis' partial correspondences (6.3, t_i ↦ t_{i+1}) for texels. Where the triangle nearest
/// to a texel lives in both frames with equal texture coordinates, the texel is itself. Where the
/// triangle has other coordinates there, its chart being another, the texel's centre is found by
/// its barycentric coordinates, and its value before by the basis functions at that point; centres
/// outside of all triangles have no such place. Where the triangle is new, there is no link.
TimeLinks texel_links(const AtlasFrame& before, const AtlasFrame& after);

}  // namespace mq

#pragma once
/// Small discs all over a surface, of which charts are made.

#include <vector>

#include "mq/base/progress.h"
#include "mq/mesh/surface.h"

namespace mq {

struct SurfacePatches {
  std::vector<int> patch;    ///< per triangle; -1 where two of its vertices are one
  std::vector<int> sources;  ///< per patch the label that its triangles had before, -1: none
  int count = 0;
};

/// About `count` discs of about equal area, more where topology asks for more, at least one per
/// component: triangles nearest to centres that move to the middle of theirs (Lloyd), where
/// distance counts up to nine times across a bend, so that borders lie along creases.
SurfacePatches make_patches(const Surface& surface, int count, const Progress& progress = {});

/// Discs of the triangles with one label, where labels −1 take the nearest other: all but the
/// largest piece of a label go to their neighbours, and what is no disc is halved until it is one.
/// The first patch of a label is its largest.
SurfacePatches make_discs(const Surface& surface, std::vector<int> labels,
                          const Progress& progress = {});

/// Gives the half of a patch around one of two triangles far apart to a new patch, the last.
void halve_patch(const Surface& surface, SurfacePatches& patches, int patch);

}  // namespace mq

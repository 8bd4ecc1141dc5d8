#pragma once
/// The cells of a texture that charts touch: what stands between them and others.

#include <vector>

#include "mq/mesh/mesh.h"

namespace mq {

/// Cells [begin, end) of a row.
struct CellRun {
  int row, begin, end;
};

/// The cells of a texture that polygons touch, which do not overlap; corners in cells. What is touched in rounding only
/// is touched.
std::vector<CellRun> touched_cells(const std::vector<std::vector<Vector2>>& polygons, int width, int height);

}  // namespace mq

#pragma once
/// A mesh of USD (UsdGeomMesh) as it lies between the prims of its layer, and its surface.

#include <string>
#include <vector>

#include "mq/evolving/evolving_mesh.h"
#include "mq/io/detail/usd_text.h"

namespace mq {

struct UsdMesh {
  std::vector<const UsdPrim*> line;  ///< the prims that it lies in, from the outermost on, and itself
  std::string path = {};             ///< "/root/body"
  const UsdProperty* points = nullptr;
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();  ///< as `place` found it

  const UsdPrim& prim() const { return *line.back(); }
  bool moves() const { return !points->samples.empty(); }

  /// Whether anything of it is seen: neither it nor what it lies in is invisible, and its points are not blocked.
  bool shown(double time) const;

  /// Finds `matrix`, of which `world` is the outermost. Throws as `usd_transform` does.
  void place(const UsdText& text, const Eigen::Matrix4d& world);

  /// The innermost of its line that has the property; null: none has.
  const UsdProperty* inherited(std::string_view name) const;

  /// Where it stands, of the text of a value.
  std::vector<Vector3> positions(const UsdText& text, std::string_view value) const;
};

/// A surface, and what of it was left out or is otherwise than one may think.
struct UsdSurface {
  EvolvingSegment segment;
  std::vector<std::string> notes, remarks;
};

/// Polygons cut into triangles, holes left out, with texture coordinates: those called `uv_set`, or else st, or
/// else the first. `positions` are those of some frame.
/// Throws `Unsupported` where its connectivity changes over time, and `IoError` with the line where it is damaged.
UsdSurface usd_surface(const UsdText& text, const UsdMesh& mesh, const std::vector<Vector3>& positions,
                       std::string_view uv_set);

}  // namespace mq

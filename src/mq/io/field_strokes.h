#pragma once
/// Strokes that say where a vector field goes, from a file.

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "mq/mesh/mesh.h"

namespace mq {

/// A line of points, along which the field goes.
struct FieldStroke {
  std::vector<Vector3> points;  ///< in space, beside the surface
  std::vector<Vector2> uvs;     ///< or in a texture: one of the two
  int texture = 0;              ///< of `uvs`
  double strength = 1;          ///< length of the vectors along it
  std::string place;            ///< in the file, for messages
};

/// Reads JSON,
///
///     {"strokes": [{"points": [[x, y, z], ...], "strength": 1},
///                  {"uv": [[u, v], ...], "texture": 0}]}
///
/// with two points at least in each stroke; strength (above 0, default 1) and texture (from 0, default 0) may be left
/// out. (0, 0) is the texture's lower left. Throws `IoError` with the place, what was found and what was wanted.
std::vector<FieldStroke> read_field_strokes(const std::filesystem::path& path);

/// Writes them so, but for their places. Throws `IoError`.
void write_field_strokes(const std::filesystem::path& path, std::span<const FieldStroke> strokes);

}  // namespace mq

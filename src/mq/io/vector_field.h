#pragma once
/// Vector fields on a mesh, from files and into files.

#include <filesystem>
#include <span>
#include <vector>

#include "mq/image/colour.h"
#include "mq/mesh/mesh.h"

namespace mq {

/// Vectors in space, per triangle of the mesh or per vertex.
struct VectorField {
  enum class At { triangles, vertices } at = At::triangles;
  std::vector<Vector3> vectors;
};

/// Whether the extension, large or small, is one that vector fields come in.
bool names_vector_field(const std::filesystem::path& path);

/// Reads, by extension,
///
/// - .vf: a 32-bit count of triangles, then two doubles each, little-endian: a, b of the vector
///   a·(p₁ − p₀) + b·(p₂ − p₀) along the triangle's edges;
/// - .ply: three properties vx, vy, vz (or field_x, field_y, field_z) of its vertices or its faces.
///
/// Throws `IoError` naming the file, what was found and the remedy: another count than that of the
/// mesh, values that are not finite, no such properties, faces that are not triangles.
VectorField read_vector_field(const std::filesystem::path& path, const Mesh& mesh);

/// Writes values at vertices as .ply with its mesh, doubles throughout, as `quality`, which MeshLab shows as colours;
/// and where there are some, one per vertex, with these colours for all other programs. Throws `IoError`.
void write_vertex_values(const std::filesystem::path& path, const Mesh& mesh, std::span<const double> values,
                         std::span<const Colour> colours = {});

/// Writes a field of triangles as .vf, or as .ply with its mesh, doubles throughout. Throws `IoError`.
void write_vector_field(const std::filesystem::path& path, const Mesh& mesh,
                        const std::vector<Vector3>& field);

}  // namespace mq

#pragma once
/// What must hold of any bytes: they are a mesh with ids in range, or refused by an error of ours;
/// a mesh comes back byte for byte, and with a vertex moved it can be read again.

#include <cstdlib>
#include <string>

#include "mq/base/error.h"
#include "mq/io/document.h"

namespace mq {

inline void expect(bool condition) {
  if (!condition) std::abort();
}

inline void expect_in_range(const MeshFile& file) {
  const Mesh& mesh = file.mesh;
  for (const Triangle& t : mesh.triangles)
    for (const int v : t) expect(v >= 0 && v < mesh.vertex_count());
  expect(!mesh.has_uvs() || mesh.corner_uvs.size() == mesh.triangles.size());
  for (const Triangle& t : mesh.corner_uvs)
    for (const int uv : t) expect(uv >= -1 && uv < int(mesh.uvs.size()));
  expect(mesh.textures.empty() || mesh.textures.size() == mesh.triangles.size());
  for (const int texture : mesh.textures)
    expect(texture >= -1 && (texture < int(file.textures.size()) || file.textures.empty()));
  for (const Vector3& p : mesh.positions) expect(p.allFinite());
  expect(file.colors.values.size() == std::size_t(file.colors.channels) * mesh.positions.size());
}

/// The model of a document whose pictures were not read, and the names of these.
inline Model model_of(const std::shared_ptr<const Document>& document, const MeshFile& file,
                      std::vector<std::string>& pictures) {
  Model model;
  model.mesh = file.mesh;
  model.colors = file.colors;
  model.document = document;
  for (const TextureSlot& slot : file.textures) {
    model.textures.emplace_back();
    pictures.push_back(slot.name);
  }
  return model;
}

/// Reads, checks, writes back with `write(model, names of pictures)`, which returns the files.
template <class Write>
void fuzz_document(const std::shared_ptr<const Document>& document, const Write& write) {
  MeshFile file;
  try {
    file = read_document(*document);
  } catch (const Error&) {
    return;
  }
  expect_in_range(file);
  std::vector<std::string> pictures;
  Model model = model_of(document, file, pictures);
  for (const Vector2& uv : model.mesh.uvs)
    if (!uv.allFinite()) return;  // never equal to itself
  for (const float value : model.colors.values)
    if (!(value == value)) return;
  expect(write(model, pictures)[0].bytes == document->bytes);
  if (model.mesh.positions.empty()) return;
  model.mesh.positions.back() = Vector3(0.5, -1, 1e-3);
  try {
    Document moved = *document;
    moved.parts = write(model, pictures);
    moved.bytes = moved.parts[0].bytes;
    expect_in_range(read_document(moved));
  } catch (const Unsupported&) {  // floats cannot hold what doubles could
  }
}

}  // namespace mq

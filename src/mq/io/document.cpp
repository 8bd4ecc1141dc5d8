#include "mq/io/document.h"

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"
#include "mq/io/detail/gltf.h"
#include "mq/io/detail/obj.h"
#include "mq/io/detail/ply.h"

namespace mq {

std::string portable_name(std::string_view name) {
  std::string result(name);
  std::replace(result.begin(), result.end(), '\\', '/');
  while (result.starts_with("./")) result.erase(0, result.find_first_not_of('/', 2));
  return result;
}

bool stays_below(const std::string& name) {
  const std::filesystem::path path(name);
  return path.is_relative() && std::find(path.begin(), path.end(), "..") == path.end();
}

bool same_connectivity(const Mesh& a, const Mesh& b) {
  return a.vertex_count() == b.vertex_count() && a.triangles == b.triangles &&
         a.uvs.size() == b.uvs.size() && a.corner_uvs == b.corner_uvs;
}

std::optional<std::vector<std::string>> slot_names(const MeshFile& document, const Model& model,
                                                   const std::vector<std::string>& pictures) {
  const std::vector<TextureSlot>& slots = document.textures;
  const bool named = std::any_of(slots.begin(), slots.end(), [](const TextureSlot& slot) {
    return !slot.name.empty() || !slot.picture.empty();
  });
  if (!named && pictures.empty()) return std::vector<std::string>(slots.size());
  // One picture given to a model that names none paints the whole mesh.
  if (!named && pictures.size() == 1 && model.mesh.textures.empty())
    return std::vector<std::string>(std::max<std::size_t>(slots.size(), 1), pictures[0]);
  if (pictures.size() != slots.size()) return {};
  for (int t = 0; t < model.mesh.triangle_count(); ++t)
    if (model.mesh.texture(t) != document.mesh.texture(t)) return {};
  return pictures;
}

unsigned stored_color(float value, unsigned largest) {
  if (!(value > 0)) return 0;
  return unsigned(std::lround(std::min(double(value), 1.0) * largest));
}

int color_channels(const VertexSignal& colors) {
  if (colors.channels == 0) return 0;
  if (colors.channels == 1 || colors.channels == 3) return 3;
  if (colors.channels == 4) return 4;
  throw Unsupported("vertex colours of " + std::to_string(colors.channels) +
                    " channels: mesh files hold 1, 3 or 4; write the others one by one");
}

float color(const VertexSignal& colors, int vertex, int channel) {
  const int stored = colors.channels == 1 ? 0 : channel;
  return colors.values[std::size_t(vertex) * colors.channels + stored];
}

MeshFile read_document(const Document& document) {
  switch (document.format) {
    case Document::Format::obj: return read_obj(document);
    case Document::Format::ply: return read_ply(document);
    case Document::Format::gltf:
    case Document::Format::glb: return read_gltf(document);
  }
  return {};
}

}  // namespace mq

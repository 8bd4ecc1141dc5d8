#include "mq/mesh/check.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>

#include "mq/base/error.h"
#include "mq/base/words.h"

namespace mq {
namespace {

using Ids = std::vector<std::int64_t>;

std::string first_of(const Ids& ids) {
  const auto shown = std::min<std::size_t>(ids.size(), 10);
  return fmt::format("{}{}", fmt::join(ids.begin(), ids.begin() + shown, ", "),
                     ids.size() > shown ? ", ..." : "");
}

void check_indices(const std::vector<Triangle>& corners, std::size_t triangles, int low,
                   std::size_t count, const char* what) {
  if (corners.size() != triangles)
    throw InvalidInput(fmt::format("there are {} triangles, but {} of them have {}", triangles,
                                   corners.size(), what));
  Ids wrong;
  for (std::size_t t = 0; t < corners.size(); ++t)
    for (const int index : corners[t])
      if (index < low || index >= std::int64_t(count)) {
        wrong.push_back(std::int64_t(t));
        break;
      }
  if (!wrong.empty())
    throw InvalidInput(fmt::format(
        "{} (first: {}) with {} that are not there: there are {}. Write the mesh again",
        counted(std::int64_t(wrong.size()), "triangle"), first_of(wrong), what, count));
}

}  // namespace

void check_mesh(const Mesh& mesh) {
  if (mesh.triangles.size() > std::size_t(std::numeric_limits<int>::max()) / 3)
    throw InvalidInput(fmt::format("{} triangles are more than half-edges can be counted for",
                                   mesh.triangles.size()));
  check_indices(mesh.triangles, mesh.triangles.size(), 0, mesh.positions.size(), "vertices");
  if (mesh.has_uvs())
    check_indices(mesh.corner_uvs, mesh.triangles.size(), -1, mesh.uvs.size(),
                  "texture coordinates");
  if (!mesh.textures.empty() && mesh.textures.size() != mesh.triangles.size())
    throw InvalidInput(fmt::format("there are {} triangles, but {} of them have textures",
                                   mesh.triangles.size(), mesh.textures.size()));
}

std::vector<char> referenced_vertices(const Mesh& mesh) {
  std::vector<char> referenced(mesh.positions.size());
  for (const Triangle& triangle : mesh.triangles)
    for (const int v : triangle) referenced[v] = 1;
  Ids not_finite, too_large;
  for (std::size_t v = 0; v < referenced.size(); ++v) {
    if (!referenced[v]) continue;
    if (!mesh.positions[v].allFinite())
      not_finite.push_back(std::int64_t(v));
    else if (mesh.positions[v].cwiseAbs().maxCoeff() > largest_coordinate)
      too_large.push_back(std::int64_t(v));
  }
  if (!not_finite.empty())
    throw InvalidInput(fmt::format(
        "{} with positions that are not finite numbers (first, from 0: {}): repair or delete them",
        counted(std::int64_t(not_finite.size()), "vertex"), first_of(not_finite)));
  if (!too_large.empty())
    throw InvalidInput(fmt::format(
        "{} with coordinates beyond {:.0e} (first, from 0: {}): scale the model down",
        counted(std::int64_t(too_large.size()), "vertex"), largest_coordinate,
        first_of(too_large)));
  return referenced;
}

}  // namespace mq

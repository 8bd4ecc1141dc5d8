#include "mq/model/remeshed_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <memory>
#include <optional>
#include <utility>

#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/base/words.h"
#include "mq/io/materials.h"
#include "mq/io/normals.h"
#include "mq/io/slots.h"
#include "mq/io/vertex_colours.h"
#include "mq/mesh/orient.h"
#include "mq/model/textured_model.h"
#include "mq/remesh/texture.h"

namespace mq {
namespace {

/// What of a target faces the wrong way is turned back.
void turn_back(RemeshInput& target, const Mesh& of_template) {
  Oriented found = oriented_like(target.model.mesh, of_template);
  target.model.mesh = std::move(found.mesh);
  std::ranges::move(found.defects, std::back_inserter(target.model.defects));
  if (target.frames.normals.empty()) return;
  for (const int t : found.turned) {
    Eigen::Vector3f* corners = &target.frames.normals[3 * std::size_t(t)];
    std::swap(corners[1], corners[2]);
    for (int k = 0; k < 3; ++k) corners[k] = -corners[k];
  }
}

bool has_uvs(const RemeshInput& of_template, const RemeshInput& target,
             const RemeshedContents& contents) {
  return contents.textures == RemeshedContents::Textures::carried &&
         (of_template.model.mesh.has_uvs() || target.model.mesh.has_uvs());
}

std::vector<Texture> textures_of_both(const RemeshInput& of_template, const RemeshInput& target) {
  std::vector<Texture> all = of_template.model.textures;
  for (const Texture& texture : target.model.textures) {
    all.push_back(texture);
    const std::filesystem::path name = texture.name;
    for (int copy = 1; std::ranges::count(all, all.back().name, &Texture::name) > 1; ++copy)
      all.back().name =
          fmt::format("{}_target{}{}", name.stem().string(), copy > 1 ? std::to_string(copy) : "",
                      name.extension().string());
  }
  return all;
}

/// Colours of what was kept and of what was added.
VertexSignal carried_colours(const RemeshInput& of_template, const RemeshInput& target,
                             const Remeshed& found, Messages& messages) {
  const bool is_light = of_template.model.colors.is_light;
  const VertexSignal& old = of_template.model.colors;
  const VertexSignal fresh = is_light ? as_light(target.model.colors) : as_displayed(target.model.colors);
  if (old.channels == 0 && fresh.channels == 0) return {};
  if (old.channels != fresh.channels) {
    messages.remark(fmt::format("colours at vertices are left out: {} has {}, {} has {}",
                                of_template.model.path.string(), counted(old.channels, "channel"),
                                target.model.path.string(), counted(fresh.channels, "channel")));
    return {};
  }
  VertexSignal colours{old.channels, {}, std::max(old.depth, fresh.depth), is_light};
  for (const VertexOrigin& origin : found.origins) {
    const RemeshInput& side = origin.of_target ? target : of_template;
    for (int c = 0; c < old.channels; ++c) {
      double sum = 0;
      for (int k = 0; k < 3; ++k) {
        const int v = side.surface.mesh.triangles[std::size_t(origin.triangle)][std::size_t(k)];
        const int source = side.surface.source_from_vertex[std::size_t(v)];
        if (origin.barycentric[k] != 0)
          sum += origin.barycentric[k] *
                 double((origin.of_target ? fresh : old).values[std::size_t(source * old.channels + c)]);
      }
      colours.values.push_back(float(sum));
    }
  }
  return colours;
}

/// The normals of both, as `finish_remeshed` says; null where neither file says any.
std::shared_ptr<const ModelShading> carried_shading(const RemeshInput& of_template,
                                                    const RemeshInput& target,
                                                    const Remeshed& found) {
  const auto has_normals = [](const RemeshInput& side) { return !side.frames.normals.empty(); };
  if (!has_normals(of_template) && !has_normals(target)) return nullptr;
  ModelShading shading;
  shading.is_said = holds_normals(of_template.model) || holds_normals(target.model);
  const auto of_corner = [](const RemeshInput& side, int triangle, int k) {
    return side.frames.normals[3 * std::size_t(triangle) + std::size_t(k)];
  };
  for (int t = 0; t < found.mesh.triangle_count(); ++t) {
    const int old = found.template_triangles[std::size_t(t)],
              fresh = found.target_triangles[std::size_t(t)];
    for (int k = 0; k < 3; ++k) {
      Eigen::Vector3f& normal = shading.corners.normals.emplace_back(Eigen::Vector3f::Zero());
      const VertexOrigin& origin =
          found.origins[std::size_t(found.mesh.triangles[std::size_t(t)][std::size_t(k)])];
      const bool of_target = old < 0 && (fresh >= 0 || origin.of_target != 0);
      const RemeshInput& side = of_target ? target : of_template;
      if (!has_normals(side)) continue;
      if (old >= 0 || fresh >= 0)
        normal = of_corner(side, old >= 0 ? old : fresh, k);
      else
        normal = interpolate(origin.barycentric, [&](int i) {
                   return Vector3(of_corner(side, origin.triangle, i).cast<double>());
                 }).cast<float>();
    }
  }
  return std::make_shared<const ModelShading>(std::move(shading));
}

/// The side that a triangle of the result comes from, and its triangle there. One between both is of the side
/// whose texture it has, if any.
std::pair<bool, int> origin_of(const Remeshed& found, int triangle, std::optional<bool> textured_by_target) {
  const auto t = std::size_t(triangle);
  if (found.template_triangles[t] >= 0) return {false, found.template_triangles[t]};
  if (found.target_triangles[t] >= 0) return {true, found.target_triangles[t]};
  for (const int v : found.mesh.triangles[t]) {
    const VertexOrigin& origin = found.origins[std::size_t(v)];
    if (!textured_by_target || *textured_by_target == (origin.of_target != 0))
      return {origin.of_target != 0, origin.triangle};
  }
  const VertexOrigin& origin = found.origins[std::size_t(found.mesh.triangles[t][0])];
  return {origin.of_target != 0, origin.triangle};
}

/// The materials of both, for the remeshed triangles with these textures (none: empty); null where neither file
/// has any.
std::shared_ptr<const ModelMaterials> carried_materials(const RemeshInput& of_template,
                                                        const RemeshInput& target,
                                                        const Remeshed& found,
                                                        const std::vector<int>& textures) {
  ModelMaterials all = file_materials(of_template.model);
  const ModelMaterials fresh = file_materials(target.model);
  const auto shift = int(all.materials.size());
  all.materials.insert(all.materials.end(), fresh.materials.begin(), fresh.materials.end());
  if (all.materials.empty()) return nullptr;
  const std::vector<int> old = std::move(all.of_triangle);
  all.of_triangle.clear();
  for (int t = 0; t < found.mesh.triangle_count(); ++t) {
    std::optional<bool> by_target;
    if (!textures.empty() && textures[std::size_t(t)] >= 0)
      by_target = textures[std::size_t(t)] >= int(of_template.model.textures.size());
    const auto [of_target, triangle] = origin_of(found, t, by_target);
    const std::vector<int>& side = of_target ? fresh.of_triangle : old;
    const int id = side.empty() ? -1 : side[std::size_t(triangle)];
    all.of_triangle.push_back(id >= 0 && of_target ? shift + id : id);
  }
  return std::make_shared<const ModelMaterials>(std::move(all));
}

VertexSignal colours_of_origin(const Remeshed& found) {
  constexpr std::array kept_colour{0.72F, 0.72F, 0.72F}, added_colour{0.93F, 0.45F, 0.1F};
  VertexSignal colours{3, {}, Depth::u8};
  std::vector<char> kept(found.mesh.positions.size(), 0);
  for (int t = 0; t < found.mesh.triangle_count(); ++t)
    if (found.template_triangles[std::size_t(t)] >= 0)
      for (const int v : found.mesh.triangles[std::size_t(t)]) kept[std::size_t(v)] = 1;
  for (const char k : kept)
    for (const float value : k ? kept_colour : added_colour) colours.values.push_back(value);
  return colours;
}

}  // namespace

Defects RemeshInput::defects() const {
  Defects all = model.defects;
  all.insert(all.end(), surface.defects.begin(), surface.defects.end());
  return all;
}

RemeshInput remesh_input(Model model, Messages& messages, const Mesh* of_template) {
  RemeshInput input{std::move(model), {}, {}};
  input.frames = file_frames(input.model);
  const std::string file = input.model.path.string();
  for (const std::string& note : input.model.notes) messages.remark(note_on(file, note));
  require(input.model.mesh.triangle_count() > 0,
          fmt::format("{}: has {} and no faces, so no surface: check that it is a mesh, not a "
                      "point cloud or curves, and not cut short",
                      file, counted(input.model.mesh.vertex_count(), "vertex")));
  about(input.model, [&] {
    if (of_template != nullptr) turn_back(input, *of_template);
    input.surface = make_surface(input.model.mesh);
  });
  require(
      input.surface.area > 0,
      fmt::format("{}: none of its triangles has an area, so it is no surface: check that it is "
                  "a mesh, and not cut short",
                  file));
  return input;
}

RemeshInput with_slot(const RemeshInput& input, const std::string& slot, const Mesh* of_template) {
  if (input.model.slot == slot && !input.model.textures.empty()) return input;
  const bool has = std::ranges::count(input.model.slots, slot, &MaterialSlot::name) > 0;
  using Pictures = ReadModelOptions::Pictures;
  Model model = read_model(
      input.model.path,
      {.textures = {}, .pictures = has ? Pictures::read : Pictures::skip, .slot = has ? slot : ""});
  if (!has) model.textures.clear();
  model.slot = slot;
  Messages silent;
  return remesh_input(std::move(model), silent, of_template);
}

std::vector<std::string> slots_of_both(const RemeshInput& of_template, const RemeshInput& target) {
  std::vector<std::string> names;
  for (const RemeshInput* side : {&of_template, &target})
    for (const MaterialSlot& slot : side->model.slots)
      if (std::ranges::count(names, slot.name) == 0) names.push_back(slot.name);
  std::ranges::stable_partition(names, [](const std::string& name) { return name == base_slot; });
  return names;
}

std::vector<std::array<Vector3, 3>> rest_corners(const RemeshInput& of_template,
                                                 const Model& rest_shape) {
  const Mesh& now = of_template.model.mesh;
  require(rest_shape.mesh.triangles == now.triangles &&
              rest_shape.mesh.vertex_count() == now.vertex_count(),
          fmt::format("{}: has other triangles than {}, wanted the same mesh as it was when its "
                      "triangles were made",
                      rest_shape.path.string(), of_template.model.path.string()));
  return corner_positions(rest_shape.mesh);
}

Model begin_remeshed(const RemeshInput& of_template, const RemeshInput& target,
                     const RemeshedContents& contents) {
  Model model;
  model.path = of_template.model.path;
  if (!has_uvs(of_template, target, contents)) return model;
  model.textures = textures_of_both(of_template, target);
  for (const RemeshInput* side : {&of_template, &target}) {
    if (side->model.textures.empty()) continue;
    const std::string slot = side->model.slot.empty() ? base_slot : side->model.slot;
    require(
        model.slot.empty() || model.slot == slot,
        fmt::format("{}: its pictures are for {}, and those of {} for {}: one material cannot hold "
                    "both as they are; bake them to one atlas ({}), or leave them out ({})",
                    side->model.path.string(), slot, of_template.model.path.string(), model.slot,
                    option_name("bake"), option_name("no_textures")));
    model.slot = slot;
  }
  return model;
}

void finish_remeshed(const RemeshInput& of_template, const RemeshInput& target, Remeshed found,
                     const RemeshedContents& contents, Messages& messages, Model& model) {
  const bool with_uvs = has_uvs(of_template, target, contents);
  for (const RemeshInput* side : {&of_template, &target})
    if (with_uvs && !side->model.mesh.has_uvs())
      messages.remark(side->model.path.string() +
                      ": has no texture coordinates, nor has what comes from it");
  for (const RemeshInput* side : {&of_template, &target})
    if (with_uvs && !side->model.others.empty())
      messages.remark(side->model.path.string() + ": of its pictures only those for " +
                      side->model.slot + " go with it");
  model.colors = contents.colours == RemeshedContents::Colours::origin
                     ? colours_of_origin(found)
                     : carried_colours(of_template, target, found, messages);
  model.shading = carried_shading(of_template, target, found);
  if (!with_uvs) {
    model.materials = carried_materials(of_template, target, found, {});
    model.mesh = std::move(found.mesh);
    return;
  }
  Mesh old = of_template.surface.mesh, fresh = target.surface.mesh;
  // Texture coordinates without a picture show none of the other's.
  if (of_template.model.textures.empty() != target.model.textures.empty()) {
    Mesh& bare = of_template.model.textures.empty() ? old : fresh;
    bare.textures.assign(bare.triangles.size(), -1);
  }
  model.mesh = textured(found, old, fresh, int(of_template.model.textures.size()));
  model.materials = carried_materials(of_template, target, found, model.mesh.textures);
}

}  // namespace mq

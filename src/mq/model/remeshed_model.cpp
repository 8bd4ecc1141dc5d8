#include "mq/model/remeshed_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/mesh/orient.h"
#include "mq/model/textured_model.h"
#include "mq/remesh/texture.h"

namespace mq {
namespace {

/// What of a target faces the wrong way is turned back.
void turn_back(Model& target, const Mesh& of_template) {
  Oriented found = oriented_like(target.mesh, of_template);
  target.mesh = std::move(found.mesh);
  std::ranges::move(found.defects, std::back_inserter(target.defects));
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
  const VertexSignal &old = of_template.model.colors, &fresh = target.model.colors;
  if (old.channels == 0 && fresh.channels == 0) return {};
  if (old.channels != fresh.channels) {
    messages.remark(fmt::format("colours at vertices are left out: {} has {}, {} has {}",
                                of_template.model.path.string(), counted(old.channels, "channel"),
                                target.model.path.string(), counted(fresh.channels, "channel")));
    return {};
  }
  VertexSignal colours{old.channels, {}, std::max(old.depth, fresh.depth)};
  for (const VertexOrigin& origin : found.origins) {
    const RemeshInput& side = origin.of_target ? target : of_template;
    for (int c = 0; c < old.channels; ++c) {
      double sum = 0;
      for (int k = 0; k < 3; ++k) {
        const int v = side.surface.mesh.triangles[std::size_t(origin.triangle)][std::size_t(k)];
        const int source = side.surface.source_from_vertex[std::size_t(v)];
        if (origin.barycentric[k] != 0)
          sum += origin.barycentric[k] *
                 double(side.model.colors.values[std::size_t(source * old.channels + c)]);
      }
      colours.values.push_back(float(sum));
    }
  }
  return colours;
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
  RemeshInput input{std::move(model), {}};
  const std::string file = input.model.path.string();
  for (const std::string& note : input.model.notes) messages.remark(file + ": " + note);
  require(input.model.mesh.triangle_count() > 0,
          fmt::format("{}: has {} and no faces, so no surface: check that it is a mesh, not a "
                      "point cloud or curves, and not cut short",
                      file, counted(input.model.mesh.vertex_count(), "vertex")));
  about(input.model, [&] {
    if (of_template != nullptr) turn_back(input.model, *of_template);
    input.surface = make_surface(input.model.mesh);
  });
  require(
      input.surface.area > 0,
      fmt::format("{}: none of its triangles has an area, so it is no surface: check that it is "
                  "a mesh, and not cut short",
                  file));
  return input;
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
  if (has_uvs(of_template, target, contents))
    model.textures = textures_of_both(of_template, target);
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
  model.mesh = with_uvs ? textured(found, of_template.surface.mesh, target.surface.mesh,
                                   int(of_template.model.textures.size()))
                        : std::move(found.mesh);
}

}  // namespace mq

#include "mq/model/model_picture.h"

#include "mq/base/error.h"

namespace mq {
namespace {

using Paint = RenderOptions::Paint;
using Lines = RenderOptions::Lines;

Image<float> layout_of(const TexturedModel& model, std::span<const Texture> textures,
                       const UvLayoutOptions& layout, const Progress& progress) {
  require(model.atlas.has_value(),
          model.model.path.string() + ": has no texture coordinates, so no layout; the verb unwrap makes some");
  const bool there = has_pictures(model) && layout.texture < std::ssize(textures);
  return draw_uv_layout(model.surface, *model.atlas,
                        there ? &textures[std::size_t(layout.texture)].pixels : nullptr, layout,
                        progress);
}

/// What sets of so many textures each are called: "after", or several by their first picture's file.
std::vector<std::string> labels_of(std::span<const Texture> textures, std::size_t count) {
  require(textures.empty() || (count > 0 && textures.size() % count == 0),
          "textures to compare with are as many as the model's, or several times as many");
  if (textures.empty()) return {};
  if (textures.size() == count) return {"after"};
  std::vector<std::string> labels;
  for (std::size_t first = 0; first < textures.size(); first += count)
    labels.push_back(textures[first].path.empty() ? "after " + std::to_string(labels.size() + 1)
                                                  : textures[first].path.stem().string());
  return labels;
}

}  // namespace

ModelRenderer::ModelRenderer(const TexturedModel& model)
    : model_(model),
      colours_(surface_colours(model)),
      renderer_(model.surface, model.atlas ? &*model.atlas : nullptr) {}

Paints ModelRenderer::paints(std::span<const Texture> textures) const {
  return {pictures_of(textures), colours_};
}

std::vector<Version> ModelRenderer::versions_of(std::span<const Texture> after) const {
  std::vector<Version> versions = {{"before", paints(model_.model.textures)}};
  const std::size_t count = model_.model.textures.size();
  const std::vector<std::string> labels = labels_of(after, count);
  for (std::size_t k = 0; k < labels.size(); ++k)
    versions.push_back({labels[k], paints(after.subspan(k * count, count))});
  return versions;
}

Image<float> ModelRenderer::overview(const ModelPictureOptions& options,
                                     const Progress& progress) const {
  std::vector<RenderOptions> wanted;
  std::vector<std::string> labels;
  RenderOptions render = options.render;
  const auto add = [&](const std::string& label) {
    wanted.push_back(render);
    labels.push_back(label);
  };
  add(render.paint == Paint::clay ? "shape" : "as it looks");
  if (model_.atlas) {
    render.seams = Lines::show;
    add("seams");
    render.seams = Lines::hide, render.paint = Paint::charts;
    add("charts");
  }
  render.paint = Paint::clay;
  if (labels.size() > 1) add("shape");
  render.wires = Lines::show;
  add("triangles");
  std::vector<Tile> tiles;
  const Paints own = paints(model_.model.textures);
  std::vector<Image<float>> pictures;
  if (options.render.paint == Paint::vertex_numbers || options.render.paint == Paint::texture_numbers)  // with legends
    for (const RenderOptions& one : wanted)
      pictures.push_back(renderer_.draw(own, one, progress.step("draw", 0.8 / double(wanted.size()))));
  else
    pictures = renderer_.draw_together(own, wanted, progress.step("draw", 0.8));
  for (std::size_t k = 0; k < pictures.size(); ++k) tiles.push_back({std::move(pictures[k]), labels[k]});
  if (model_.atlas)
    tiles.push_back(
        {layout_of(model_, model_.model.textures, options.layout, progress.step("layout", 0.2)),
         "layout"});
  return contact_sheet(tiles, options.sheet);
}

Image<float> ModelRenderer::draw(const ModelPictureOptions& options, std::span<const Texture> after,
                                 const Progress& progress) const {
  using Page = ModelPictureOptions::Page;
  if (options.page == Page::overview) return overview(options, progress);
  const bool single = options.page == Page::view;
  const std::vector<Version> versions = versions_of(after);
  if (after.empty())
    return single ? renderer_.draw(versions[0].paints, options.render, progress)
                  : draw_views(renderer_, versions[0].paints, options.views, options.render, options.sheet, progress);
  return draw_versions(renderer_, versions, single ? std::vector<std::string>() : options.views, options.render,
                       options.sheet, progress);
}

Sight ModelRenderer::sight_of_seam(const SeamDifference& seams, double extent,
                                   const View& like) const {
  const Atlas& atlas = *model_.atlas;
  Sight sight =
      sight_of_worst_seam(renderer_, atlas, seams, extent / atlas.texel_spacing(), like.up);
  sight.view.projection = like.projection;
  return sight;
}

Sight ModelRenderer::sight_of_place(const Vector3& point, const Vector3& normal, double extent,
                                    const View& like) const {
  Sight sight = renderer_.sight_of(point, normal, extent, like.up);
  sight.view.projection = like.projection;
  return sight;
}

Image<float> draw_layout(const TexturedModel& model, std::span<const Texture> after,
                         const UvLayoutOptions& layout, const SheetOptions& sheet,
                         const Progress& progress) {
  const std::size_t count = model.model.textures.size();
  const std::vector<std::string> labels = labels_of(after, count);
  const double share = 1 / double(labels.size() + 1);
  Image<float> first = layout_of(model, model.model.textures, layout, progress.step("layout", share));
  if (after.empty()) return first;
  std::vector<Tile> tiles = {{std::move(first), "before"}};
  for (std::size_t k = 0; k < labels.size(); ++k)
    tiles.push_back(
        {layout_of(model, after.subspan(k * count, count), layout, progress.step("layout", share)), labels[k]});
  return contact_sheet(tiles, sheet);
}

}  // namespace mq

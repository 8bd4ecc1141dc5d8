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

}  // namespace

ModelRenderer::ModelRenderer(const TexturedModel& model)
    : model_(model),
      colours_(surface_colours(model)),
      renderer_(model.surface, model.atlas ? &*model.atlas : nullptr) {}

Paints ModelRenderer::paints(std::span<const Texture> textures) const {
  return {pictures_of(textures), colours_};
}

Image<float> ModelRenderer::overview(const ModelPictureOptions& options,
                                     const Progress& progress) const {
  std::vector<Tile> tiles;
  RenderOptions render = options.render;
  const Paints own = paints(model_.model.textures);
  const auto add = [&](const std::string& label) {
    tiles.push_back({renderer_.draw(own, render, progress.step(label, 0.16)), label});
  };
  add(render.paint == Paint::clay ? "shape" : "as it looks");
  if (model_.atlas) {
    render.seams = Lines::show;
    add("seams");
    render.seams = Lines::hide, render.paint = Paint::charts;
    add("charts");
  }
  render.paint = Paint::clay;
  if (tiles.size() > 1) add("shape");
  render.wires = Lines::show;
  add("triangles");
  if (model_.atlas)
    tiles.push_back(
        {layout_of(model_, model_.model.textures, options.layout, progress.step("layout", 0.16)),
         "layout"});
  return contact_sheet(tiles, options.sheet);
}

Image<float> ModelRenderer::draw(const ModelPictureOptions& options, std::span<const Texture> after,
                                 const Progress& progress) const {
  using Page = ModelPictureOptions::Page;
  if (options.page == Page::overview) return overview(options, progress);
  const Paints own = paints(model_.model.textures), others = paints(after);
  const bool single = options.page == Page::view;
  if (after.empty())
    return single
               ? renderer_.draw(own, options.render, progress)
               : draw_views(renderer_, own, options.views, options.render, options.sheet, progress);
  return single ? draw_before_after(renderer_, own, others, options.render, {}, options.sheet,
                                    progress)
                : draw_views_before_after(renderer_, own, others, options.views, options.render, {},
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

Image<float> draw_layout(const TexturedModel& model, std::span<const Texture> after,
                         const UvLayoutOptions& layout, const SheetOptions& sheet,
                         const Progress& progress) {
  Image<float> first = layout_of(model, model.model.textures, layout, progress.step("layout", 0.5));
  if (after.empty()) return first;
  return contact_sheet({{std::move(first), "before"},
                        {layout_of(model, after, layout, progress.step("layout", 0.5)), "after"}},
                       sheet);
}

}  // namespace mq

#pragma once
/// Several pictures of one surface on a page.

#include <string>
#include <vector>

#include "mq/draw/contact_sheet.h"
#include "mq/draw/render.h"
#include "mq/draw/seam_difference.h"

namespace mq {

/// One picture per view name (`parse_view`), each of `options`' size, labelled by it. Projection,
/// upright axis and field of view are those of `options.view`.
Image<float> draw_views(const Renderer& renderer, const Paints& paints,
                        const std::vector<std::string>& views, const RenderOptions& options = {},
                        const SheetOptions& sheet = {}, const Progress& progress = {});

/// What two pictures of a comparison are called.
struct Labels {
  std::string before = "before";
  std::string after = "after";
};

/// The same view of the same surface with two sets of textures, side by side.
Image<float> draw_before_after(const Renderer& renderer, const Paints& before, const Paints& after,
                               const RenderOptions& options = {}, const Labels& labels = {},
                               const SheetOptions& sheet = {}, const Progress& progress = {});

/// `draw_before_after` of one picture per view name, two columns unless the sheet says otherwise.
Image<float> draw_views_before_after(const Renderer& renderer, const Paints& before,
                                     const Paints& after, const std::vector<std::string>& views,
                                     const RenderOptions& options = {}, const Labels& labels = {},
                                     const SheetOptions& sheet = {},
                                     const Progress& progress = {});

/// A view of the place where seams show most: of the edges of `seams` the one with most weight in
/// the picture around it that is also seen well. `texels` mean texel spacings are across. Throws
/// `InvalidInput` when there is no seam.
Sight sight_of_worst_seam(const Renderer& renderer, const Atlas& atlas, const SeamDifference& seams,
                          double texels, View::Up up = View::Up::y);

}  // namespace mq

#pragma once
/// Several pictures of one surface on a page.

#include <span>
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

/// What the same surface looks like at one time or by one way, and what that is called.
struct Version {
  std::string label;
  Paints paints;
};

/// The same view of the same surface for each version, side by side unless the sheet says otherwise; with `views` so for
/// each of these, as `draw_views` has them.
Image<float> draw_versions(const Renderer& renderer, std::span<const Version> versions,
                           const std::vector<std::string>& views = {}, const RenderOptions& options = {},
                           const SheetOptions& sheet = {}, const Progress& progress = {});

/// A view of the place where seams show most: of the edges of `seams` the one with most weight in
/// the picture around it that is also seen well. `texels` mean texel spacings are across. Throws
/// `InvalidInput` when there is no seam.
Sight sight_of_worst_seam(const Renderer& renderer, const Atlas& atlas, const SeamDifference& seams,
                          double texels, View::Up up = View::Up::y);

}  // namespace mq

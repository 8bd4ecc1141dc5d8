#pragma once
/// Pictures of a model as it is, and of other textures beside its own.

#include <span>
#include <string>
#include <vector>

#include "mq/draw/sheets.h"
#include "mq/draw/uv_layout.h"
#include "mq/model/model_paints.h"

namespace mq {

struct ModelPictureOptions {
  /// What is on it; where textures are compared all but the overview are drawn before and after.
  enum class Page {
    view,     ///< the model from `render.view`
    views,    ///< one picture for each of `views`
    overview  ///< texture, seams, charts, shape, triangles and layout, as far as it has them
  } page = Page::view;
  std::vector<std::string> views = {};  ///< as `parse_view` reads them
  RenderOptions render = {};
  UvLayoutOptions layout = {};  ///< of the overview
  SheetOptions sheet = {};
};

/// Draws a model, which must outlive it.
class ModelRenderer {
 public:
  explicit ModelRenderer(const TexturedModel& model);

  /// `after`: textures to compare with, of the same sizes, set by set; none: nothing is compared. Throws what
  /// `Renderer::draw` and `draw_uv_layout` throw.
  Image<float> draw(const ModelPictureOptions& options, std::span<const Texture> after = {},
                    const Progress& progress = {}) const;

  /// A view of the place where seams differ most, `extent` model units across, upright and
  /// projected as `like` is. Throws `InvalidInput` where there is no seam.
  Sight sight_of_seam(const SeamDifference& seams, double extent, const View& like) const;

  /// The same of a place of the surface, as `Renderer::sight_of` has it.
  Sight sight_of_place(const Vector3& point, const Vector3& normal, double extent, const View& like) const;

 private:
  Paints paints(std::span<const Texture> textures) const;
  std::vector<Version> versions_of(std::span<const Texture> after) const;
  Image<float> overview(const ModelPictureOptions& options, const Progress& progress) const;

  const TexturedModel& model_;
  std::vector<float> colours_;
  Renderer renderer_;
};

/// A texture of the model with its charts; with `after` the same with those beside it. Where the
/// model has no such picture only charts are drawn. Throws `InvalidInput` for a model without
/// texture coordinates, and what `draw_uv_layout` throws.
Image<float> draw_layout(const TexturedModel& model, std::span<const Texture> after,
                         const UvLayoutOptions& layout, const SheetOptions& sheet = {},
                         const Progress& progress = {});

}  // namespace mq

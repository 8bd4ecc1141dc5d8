#pragma once
/// The model and its textures as the graphics card has them, and the two pictures made of them: the
/// surface as a camera sees it, and a texture with the charts on it.

#include <map>
#include <memory>
#include <vector>

#include "gl.h"
#include "look.h"
#include "scene.h"
#include "texture_set.h"
#include "turntable.h"

namespace mq::view {

/// Which part of a texture is shown: pixel (0, 0) of the pane is at (column, row).
struct AtlasView {
  int texture = 0;
  double column = 0, row = 0;  ///< texels, centres at whole numbers
  double zoom = 1;             ///< pixels per texel
};

class ModelPictures {
 public:
  explicit ModelPictures(const app::Scene& scene);

  /// What `Look::Paint::lifespans` shows, one per triangle; empty: clay.
  void set_triangle_colours(std::vector<Colour> colours) { triangle_colours_ = std::move(colours); }

  /// The legend of what is shown, as `legend` draws it; its scale where there are numbers.
  FalseColour scale_of(const Look& look, const TextureSet* textures) const;

  struct Shown {
    const Look& look;
    FalseColour scale;         ///< of numbers
    const TextureSet* before;  ///< null: there are no pictures
    const TextureSet* after;   ///< null: the same as before
  };
  void draw_surface(const Turntable& camera, const Shown& shown, const Canvas& canvas);
  void draw_atlas(const AtlasView& view, const Shown& shown, const Canvas& canvas);

  const Vector3& middle() const { return middle_; }
  double radius() const { return radius_; }

 private:
  struct Group {
    int texture, first, count;  ///< vertices
  };

  void fill_triangles();
  void fill_lines();
  void paint_with(Look::Paint paint, const FalseColour& scale);
  void show_scale(const FalseColour& scale);
  void draw_backdrop(int width, int height);

  const app::Scene& scene_;
  Vector3 middle_;
  double radius_ = 1;
  std::vector<int> order_;  ///< triangles, by texture
  std::vector<Group> groups_;
  std::vector<Colour> triangle_colours_;
  std::vector<float> stretch_, density_;  ///< per triangle
  std::optional<std::pair<Look::Paint, std::array<double, 2>>> painted_;

  Shader surface_, atlas_picture_, atlas_tint_, plain_;
  VertexArray triangles_, nothing_;
  Buffer corners_, colours_;
  Lines seams_, ends_;
  std::map<int, std::unique_ptr<Lines>> atlas_seams_, atlas_wires_;
  Picture colours_of_scale_, backdrop_, none_;
  std::vector<double> shown_scale_;
};

}  // namespace mq::view

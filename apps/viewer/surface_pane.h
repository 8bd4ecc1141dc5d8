#pragma once
/// The model and its textures as the graphics card has them, and the two pictures made of them: the
/// surface as a camera sees it, and a texture with the charts on it.

#include <map>
#include <memory>
#include <vector>

#include "gl.h"
#include "look.h"
#include "options/model_options.h"
#include "texture_set.h"
#include "turntable.h"

namespace mq::view {

/// Which part of a texture is shown: pixel (0, 0) of the pane is at (column, row).
struct AtlasView {
  int texture = 0;
  double column = 0, row = 0;  ///< texels, centres at whole numbers
  double zoom = 1;             ///< pixels per texel
};

/// What the graphics card is given of a model, and what is asked of it in every frame; made on any
/// thread.
struct DrawnModel {
  explicit DrawnModel(const TexturedModel& scene, const Progress& progress = {});

  struct Corner {
    Eigen::Vector3f position, normal;
    Eigen::Vector2f texel;
  };
  /// Triangles of one texture.
  struct Group {
    int texture, first, count;  ///< corners
  };
  using Ends = std::vector<Eigen::Vector3f>;  ///< of lines, pairs

  Vector3 middle = Vector3::Zero();
  double radius = 1;
  std::vector<int> order;  ///< triangles, by texture
  std::vector<Group> groups;
  std::vector<Corner> corners;          ///< three for each triangle, in this order
  std::vector<float> stretch, density;  ///< per triangle
  float stretch_high = 1, density_high = 0;  ///< 99 of 100 are below
  Ends seams, ends;
  std::map<int, Ends> atlas_seams, atlas_wires;  ///< by texture

  /// What `Look::Paint::lifespans` shows, one per triangle; empty: clay.
  std::vector<Colour> triangle_colours;

 private:
  void find_metrics(const TexturedModel& scene);
  void find_corners(const TexturedModel& scene);
  void find_lines(const TexturedModel& scene);
};

class ModelPictures {
 public:
  /// The scene must outlive the object.
  ModelPictures(const TexturedModel& scene, DrawnModel model);

  /// The legend of what is shown, as `legend` draws it; its scale where there are numbers.
  FalseColour scale_of(const Look& look, const TextureSet* textures) const;

  struct Shown {
    const Look& look;
    FalseColour scale;         ///< of numbers
    const TextureSet* before;  ///< null: there are no pictures
    const TextureSet* after;   ///< null: the same as before
    std::shared_ptr<const VertexSignal> colours;  ///< at vertices; null: those of the model
  };
  void draw_surface(const Turntable& camera, const Shown& shown, const Canvas& canvas);
  void draw_atlas(const AtlasView& view, const Shown& shown, const Canvas& canvas);

  const Vector3& middle() const { return model_.middle; }
  double radius() const { return model_.radius; }

 private:
  void paint_with(const Shown& shown);
  std::vector<std::uint8_t> colours_of(Look::Paint paint, const FalseColour& scale,
                                       const VertexSignal& at_vertices) const;
  void show_scale(const FalseColour& scale);
  void draw_backdrop(int width, int height);

  const TexturedModel& scene_;
  DrawnModel model_;
  struct Painted {
    Look::Paint paint;
    std::array<double, 2> range;
    std::shared_ptr<const VertexSignal> colours;
    bool operator==(const Painted&) const = default;
  };
  std::optional<Painted> painted_;

  VertexArray triangles_, nothing_;
  Buffer corners_, colours_, colours_before_;
  Lines seams_, ends_;
  std::map<int, std::unique_ptr<Lines>> atlas_seams_, atlas_wires_;
  Picture colours_of_scale_, backdrop_, none_;
  std::vector<double> shown_scale_;
};

}  // namespace mq::view

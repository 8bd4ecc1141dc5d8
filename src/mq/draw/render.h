#pragma once
/// Pictures of a surface: what it is painted with, its charts and seams, numbers on it.
///
///     Renderer renderer(surface, &atlas);
///     Image<float> front = renderer.draw({.textures = {&picture}}, {.view = parse_view("front")});

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "mq/atlas/atlas.h"
#include "mq/base/progress.h"
#include "mq/draw/camera.h"
#include "mq/draw/false_colour.h"
#include "mq/draw/samples.h"

namespace mq {

/// What is shown on the surface; borrowed, not copied.
struct Paints {
  std::vector<const Image<float>*> textures = {};  ///< one per texture of the atlas, of its size
  std::span<const float> vertex_values = {};       ///< per vertex of the surface: 1 number, or 3
                                                   ///< values of a colour
};

/// A line in space, besides the model.
struct SpaceLine {
  Vector3 from, to;
  Colour colour = {0, 0, 0};
};

struct RenderOptions {
  View view = {};
  int width = 1024, height = 1024;  ///< pixels, 1 to 16384
  enum class Paint {
    clay,            ///< one colour
    texture,         ///< bilinear between texels, as the texel spaces see them
    charts,          ///< a colour for each chart
    vertex_colours,  ///< three values per vertex
    vertex_numbers,  ///< one value per vertex in false colours
    texture_numbers  ///< one channel of the textures in false colours
  } paint = Paint::texture;
  enum class Light {
    studio,  ///< soft: mostly from the viewer, some from above left
    none     ///< values as they are
  } light = Light::studio;
  enum class Lines { hide, show };
  Lines seams = Lines::hide;  ///< seams in orange, the ends of the surface in blue
  Lines wires = Lines::hide;  ///< all edges of triangles
  double line_width = 2;      ///< pixels, of seams; wires have a third
  FalseColour scale = {};     ///< of numbers
  int channel = 0;            ///< of the textures, for numbers
  enum class Legend { hide, show } legend = Legend::show;  ///< where numbers are shown
  std::string legend_title = {};
  Backdrop backdrop = {};
  int samples = 3;  ///< per pixel and direction, 1 to 16
  std::vector<SpaceLine> lines = {};  ///< drawn too, hidden by what is in front; the view holds them
};

/// How well a place of the surface is seen.
struct Sight {
  View view;
  bool clear = false;  ///< nothing is in front of the place
  double open = 0;     ///< the share of the picture that the surface around the place fills, 0 to 1
};

class Scene;

/// A view of `point`, `extent` model units across: of directions up to 60 degrees from `normal`
/// the one in which it is clear and the surface around fills most of the picture, straight ones
/// preferred; along −`normal` where it is clear in none. `scene` has the surface's rays.
Sight sight_of(const Surface& surface, const Scene& scene, const Vector3& point, const Vector3& normal,
               double extent, View::Up up = View::Up::y);

class Renderer {
 public:
  /// Builds what all pictures share. Surface and atlas must outlive it; without an atlas there are
  /// no textures, charts and seams.
  explicit Renderer(const Surface& surface, const Atlas* atlas = nullptr);
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /// One picture: red, green, blue as displayed, and alpha with a transparent backdrop. Triangles
  /// without a chart are shown as clay where a texture is asked for; the back of triangles is
  /// darker. Equal bits for any number of threads. Throws `InvalidInput` for an empty mesh, options
  /// out of range, or paints that do not fit the surface or the atlas.
  Image<float> draw(const Paints& paints, const RenderOptions& options = {},
                    const Progress& progress = {}) const;

  /// Pictures of one view, size and number of samples that differ in paint, light, lines and backdrop, each to
  /// the last bit what `draw` gives: rays are shot once for all of them. Throws what `draw` throws, and
  /// `InvalidInput` where views differ, or where one of several has a legend or lines in space.
  std::vector<Image<float>> draw_together(const Paints& paints, std::span<const RenderOptions> wanted,
                                          const Progress& progress = {}) const;

  /// As the function of this name, of this surface.
  Sight sight_of(const Vector3& point, const Vector3& normal, double extent,
                 View::Up up = View::Up::y) const;

  const Surface& surface() const;

 private:
  struct Shared;
  std::unique_ptr<Shared> shared_;
};

/// The colour of chart `id`: neighbours in number are far apart in hue.
Colour chart_colour(int id);

}  // namespace mq

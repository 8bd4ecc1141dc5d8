#pragma once
/// What the options of `marquetry render` ask for.

#include <string>
#include <vector>

#include "mq/draw/sheets.h"
#include "mq/draw/uv_layout.h"
#include "shell/run.h"
#include "options/model_options.h"

namespace mq::app {

/// Whether `parse_view` knows it.
bool is_view(const std::string& text);

/// --view with one view: from where pictures are that a verb draws beside its work.
void add_view_option(OptionTable& table, const std::string& group);

/// Camera, picture, numbers and layout: everything but the model and the output.
void add_render_options(OptionTable& table);

/// Borrows the options and the scene.
struct RenderRequest {
  const OptionValues& options;
  const TexturedModel& scene;
  std::vector<Texture> after = {};         ///< of --compare
  std::vector<float> vertex_colours = {};  ///< per vertex of the surface; empty: it has none
  RenderOptions render = {};
  SheetOptions sheet = {};

  bool compares() const { return !after.empty(); }
  std::vector<std::string> views() const { return options.texts("view"); }
  Paints paints() const;
  Paints paints_after() const;
};

/// Reads the pictures of --compare. Throws `InvalidInput` where the model lacks what is asked for.
RenderRequest make_render_request(const OptionValues& options, const TexturedModel& scene);

UvLayoutOptions layout_options(const RenderRequest& request);

/// Whether every texture of the model has its picture.
bool has_pictures(const TexturedModel& scene);

std::vector<const Image<float>*> pictures_of(const std::vector<Texture>& textures);

/// What an option says that holds so many numbers.
std::vector<double> numbers_of(const OptionValues& options, const std::string& name,
                               std::size_t count);

}  // namespace mq::app

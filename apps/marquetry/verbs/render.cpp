// marquetry render MESH [TEXTURE...] -o OUT.png: pictures of a model, of its charts and seams, and
// of two versions of its textures side by side.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "verbs/shared/input_pictures.h"
#include "mq/base/error.h"
#include "mq/base/length.h"
#include "mq/draw/pinhole.h"
#include "mq/io/cameras.h"
#include "mq/io/image_file.h"
#include "verbs/shared/render_request.h"
#include "shell/verb.h"

namespace mq::app {
namespace {

using Paint = RenderOptions::Paint;
using Lines = RenderOptions::Lines;

/// Model units across the picture that --extent asks for.
double extent_of(const OptionValues& options, const TexturedModel& scene) {
  const Length length = parse_length(options.text("extent"));
  require(length.value > 0, "--extent: found '" + options.text("extent") + "', wanted more than 0");
  const SurfaceScale scale{scene.surface.area, scene.atlas ? scene.atlas->texel_spacing() : 0};
  require(length.unit != Length::Unit::texels || scale.texel_spacing > 0,
          scene.model.path.string() +
              ": no triangle has an area both on the surface and in a texture, so --extent cannot "
              "be in texels; give it in model units, such as 0.1, or as 1%");
  return std::sqrt(weight_from_length(length, scale));
}

/// Moves the camera to the place --at names. The worst seam is that of the textures drawn first.
void look_at_place(Run& run, const Renderer& renderer, RenderRequest& request) {
  if (!request.options.has("at")) return;
  const TexturedModel& scene = request.scene;
  const std::string at = request.options.text("at");
  require(at != "seam" || has_pictures(scene),
          scene.model.path.string() + ": has no textures whose seams could differ");
  require(at != "seam" || scene.atlas->seam_count > 0,
          scene.model.path.string() + ": has no seam to look at; give --at three coordinates");
  const double extent = extent_of(request.options, scene);
  View& view = request.render.view;
  if (at != "seam") {
    const auto place = numbers_of(request.options, "at", 3);
    view.target = Vector3(place[0], place[1], place[2]);
    view.extent = extent;
    return;
  }
  const SeamDifference seams =
      seam_difference(scene.surface, *scene.atlas, pictures_of(scene.model.textures));
  require(!seams.edges.empty(), scene.model.path.string() + ": has no seam whose two sides could differ; give --at three "
                                      "coordinates");
  const Sight sight = sight_of_worst_seam(renderer, *scene.atlas, seams,
                                          extent / scene.atlas->texel_spacing(), view.up);
  if (!sight.clear)
    run.terminal().remark("the place where seams differ most is hidden; seen from straight above");
  const auto projection = view.projection;
  view = sight.view;
  view.projection = projection;
  const Vector3& p = *view.target;
  run.result["seam"] = {
      {"rms", seams.rms}, {"largest", seams.worst.difference}, {"at", {p.x(), p.y(), p.z()}}};
}

Json seams_json(const TexturedModel& scene, const std::vector<Texture>& textures) {
  const SeamDifference seams = seam_difference(scene.surface, *scene.atlas, pictures_of(textures));
  return {{"rms", seams.rms}, {"p99", seams.difference_p99}, {"largest", seams.worst.difference}};
}

Image<float> layout_of(const RenderRequest& request, const std::vector<Texture>& textures,
                       const Progress& progress) {
  const TexturedModel& scene = request.scene;
  const std::string file = scene.model.path.string();
  require(scene.atlas.has_value(), file + ": has no texture coordinates, so no layout");
  const UvLayoutOptions layout = layout_options(request);
  const bool there = has_pictures(scene) && layout.texture < int(textures.size());
  return draw_uv_layout(scene.surface, *scene.atlas,
                        there ? &textures[layout.texture].pixels : nullptr, layout, progress);
}

Image<float> draw_layouts(const RenderRequest& request, const Progress& progress) {
  const Image<float> first =
      layout_of(request, request.scene.model.textures, progress.step("layout", 0.5));
  if (!request.compares()) return first;
  return contact_sheet({{first, "before"},
                        {layout_of(request, request.after, progress.step("layout", 0.5)), "after"}},
                       request.sheet);
}

/// Texture, seams, charts, shape and layout on one page.
Image<float> draw_overview(const Renderer& renderer, const RenderRequest& request,
                           const Progress& progress) {
  std::vector<Tile> tiles;
  RenderOptions render = request.render;
  const auto add = [&](const std::string& label) {
    tiles.push_back({renderer.draw(request.paints(), render, progress.step(label, 0.16)), label});
  };
  add(render.paint == Paint::clay ? "shape" : "as it looks");
  if (request.scene.atlas) {
    render.seams = Lines::show;
    add("seams");
    render.seams = Lines::hide, render.paint = Paint::charts;
    add("charts");
  }
  render.paint = Paint::clay;
  if (tiles.size() > 1) add("shape");
  render.wires = Lines::show;
  add("triangles");
  if (request.scene.atlas) {
    const Image<float> layout =
        layout_of(request, request.scene.model.textures, progress.step("layout", 0.16));
    tiles.push_back({layout, "layout"});
  }
  return contact_sheet(tiles, request.sheet);
}

/// Every view asked for, before and after where two sets of textures are given.
Image<float> draw_pictures(const Renderer& renderer, const RenderRequest& request,
                           const Progress& progress) {
  const std::vector<std::string> views = request.views();
  const bool single = views.size() == 1 || request.options.has("at");
  if (single && !request.compares())
    return renderer.draw(request.paints(), request.render, progress);
  if (single)
    return draw_before_after(renderer, request.paints(), request.paints_after(), request.render, {},
                             request.sheet, progress);
  if (!request.compares())
    return draw_views(renderer, request.paints(), views, request.render, request.sheet, progress);
  std::vector<Tile> tiles;
  for (const std::string& name : views) {
    RenderOptions render = request.render;
    render.view.azimuth = parse_view(name).azimuth,
    render.view.elevation = parse_view(name).elevation;
    const double share = 0.5 / double(views.size());
    tiles.push_back(
        {renderer.draw(request.paints(), render, progress.step(name, share)), name + ", before"});
    tiles.push_back({renderer.draw(request.paints_after(), render, progress.step(name, share)),
                     name + ", after"});
  }
  SheetOptions pairs = request.sheet;
  if (pairs.columns == 0) pairs.columns = 2;
  return contact_sheet(tiles, pairs);
}

Exit render(Run& run) {
  const OptionValues& options = run.options();
  const TexturedModel scene = read_textured_model(run, MissingPictures::assume, 0.4);
  const std::string output = options.text("output");
  std::vector<std::filesystem::path> files = {output};
  if (options.has("cameras")) {
    require(!options.flag("layout") && !options.flag("overview") && !options.has("compare") &&
                options.texts("view").size() == 1,
            "--cameras: a page has no camera: draw one view of one model");
    files.emplace_back(options.text("cameras"));
  }
  run.will_write(files);
  check_pictures(options, scene,
                 {"compare", InputPictures::Count::one_set, InputPictures::Size::of_the_texture});
  if (run.dry_run()) return Exit::done;

  RenderRequest request = make_render_request(options, scene);
  Image<float> picture;
  PinholeCamera camera;
  about(scene.model, [&] {
    const Step step(run, "draw", 0.5);
    if (options.flag("layout")) {
      picture = draw_layouts(request, step);
      return;
    }
    const Renderer renderer(scene.surface, scene.atlas ? &*scene.atlas : nullptr);
    look_at_place(run, renderer, request);
    picture = options.flag("overview") ? draw_overview(renderer, request, step)
                                       : draw_pictures(renderer, request, step);
    if (options.has("cameras"))
      camera = pinhole_of(Camera(scene.surface.mesh, request.render.view, picture.width(),
                                 picture.height()));
  });
  if (request.compares())
    run.result["seams"] = {{"before", seams_json(scene, scene.model.textures)},
                           {"after", seams_json(scene, request.after)}};
  run.result["width"] = picture.width();
  run.result["height"] = picture.height();
  run.result["output"] = output;
  for (const std::string& note : write_image(output, picture)) run.terminal().remark(note);
  run.terminal().remark("wrote " + output);
  if (!options.has("cameras")) return Exit::done;
  write_cameras(options.text("cameras"), {{std::filesystem::path(output).filename(), camera}});
  run.terminal().remark("wrote " + options.text("cameras"));
  return Exit::done;
}

}  // namespace

Verb render_verb() {
  OptionTable table("render",
                    "Draw a model, its charts and seams, or two versions of its textures.");
  add_model_options(table);
  table.add({.name = "output",
             .letter = 'o',
             .type = Option::Type::path,
             .required = true,
             .help = "the picture: PNG, JPEG, TIFF, EXR, BMP or TGA"});
  add_render_options(table);
  table.add({.name = "cameras",
             .type = Option::Type::path,
             .group = "Picture",
             .help = "also write the picture's camera, for stitch --views"});
  add_frames_option(table);
  return {table, render};
}

}  // namespace mq::app

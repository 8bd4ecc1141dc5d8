#include "verbs/shared/render_request.h"

#include <fmt/format.h>

#include <algorithm>

#include "shell/arguments.h"
#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/io/file_names.h"
#include "mq/io/image_file.h"

namespace mq::app {
namespace {

using Paint = RenderOptions::Paint;
using Lines = RenderOptions::Lines;

bool is_place(const std::string& text) {
  return text == "seam" || text == "difference" || parse_numbers(text, 3);
}

/// What --paint says, or the best there is.
Paint paint_of(const OptionValues& options, const TexturedModel& scene) {
  const std::string name = options.text("paint"), file = scene.model.path.string();
  const bool colours = scene.model.colors.channels > 0;
  if (name == "clay") return Paint::clay;
  if (name == "auto") return best_paint(scene);
  if (name == "vertices") {
    require(colours, file + ": has no colours at its vertices; choose another --paint");
    return Paint::vertex_colours;
  }
  require(scene.atlas.has_value(), file + ": has no texture coordinates; try --paint clay");
  if (name == "charts") return Paint::charts;
  require(has_pictures(scene), file + ": a texture has no picture: name one after the mesh");
  return name == "numbers" ? Paint::texture_numbers : Paint::texture;
}

FalseColour scale_for(const OptionValues& options, const TexturedModel& scene) {
  const bool diverging = options.text("map") == "diverging";
  const auto map = diverging ? FalseColour::Map::diverging : FalseColour::Map::sequential;
  FalseColour scale;
  if (options.has("range")) {
    const auto range = numbers_of(options, "range", 2);
    require(range[0] < range[1],
            fmt::format("--range: found {:g},{:g}; the first number must be below the second", range[0],
                        range[1]));
    scale = {map, range[0], range[1]};
  } else {
    scale = scale_of_textures(scene.model.textures, int(options.integer("channel")), map);
  }
  scale.isolines = int(options.integer("isolines"));
  return scale;
}

RenderOptions render_options(const OptionValues& options, const TexturedModel& scene) {
  RenderOptions render;
  render.view = parse_view(options.texts("view").front());
  render.view.up = asked_up(options);
  if (options.text("projection") == "orthographic")
    render.view.projection = View::Projection::orthographic;
  const auto size = *parse_size(options.text("size"));
  render.width = size[0], render.height = size[1];
  render.paint = paint_of(options, scene);
  if (options.flag("unlit")) render.light = RenderOptions::Light::none;
  if (options.flag("seams")) render.seams = Lines::show;
  if (options.flag("wires")) render.wires = Lines::show;
  render.line_width = options.number("line-width");
  render.backdrop = *parse_backdrop(options.text("background"));
  render.samples = int(options.integer("samples"));
  render.channel = int(options.integer("channel"));
  if (render.paint == Paint::texture_numbers) render.scale = scale_for(options, scene);
  return render;
}

UvLayoutOptions layout_options(const OptionValues& options, const TexturedModel& scene) {
  UvLayoutOptions layout;
  const auto size = *parse_size(options.text("size"));
  layout.side = std::max(size[0], size[1]);
  layout.texture = int(options.integer("layout-texture"));
  layout.zoom = options.number("zoom");
  const auto center = numbers_of(options, "center", 2);
  layout.center = {center[0], center[1]};
  if (options.flag("wires")) layout.wires = Lines::show;
  if (options.text("paint") == "texture") layout.fill = UvLayoutOptions::Fill::texture;
  if (options.text("paint") == "charts" || !has_pictures(scene))
    layout.fill = UvLayoutOptions::Fill::charts;
  return layout;
}

void add_camera_options(OptionTable& table) {
  using Type = Option::Type;
  const std::string group = "Camera";
  table.add(
      {.name = "view",
       .letter = 'v',
       .type = Type::text,
       .count = Option::Count::many,
       .default_value = "corner",
       .accepts = is_view,
       .wanted = "front, back, left, right, top, bottom, corner or AZIMUTH,ELEVATION",
       .metavar = "VIEW",
       .group = group,
       .help = "from where: front, back, left, right, top, bottom, corner or AZIMUTH,ELEVATION",
       .details = "Degrees: the azimuth from the front towards the model's +x, the elevation "
                  "above the horizon. Several views make a page."});
  table.add({.name = "through",
             .type = Type::path,
             .metavar = "CAMERAS",
             .group = group,
             .help = "from where a photograph was taken: a file or folder of cameras, as for the verb cameras",
             .details = "In the photograph's proportions where --size is one number, without its lens' distortion."});
  table.add({.name = "photograph",
             .type = Type::text,
             .metavar = "NAME",
             .group = group,
             .help = "which of them; else the first"});
  add_up_option(table, group);
  table.add({.name = "projection",
             .type = Type::choice,
             .default_value = "perspective",
             .choices = {"perspective", "orthographic"},
             .group = group,
             .help = "how depth shows"});
  table.add({.name = "at",
             .type = Type::text,
             .accepts = is_place,
             .wanted = "seam, difference, or three coordinates such as 0.1,2,3",
             .metavar = "seam|difference|X,Y,Z",
             .group = group,
             .help = "look closely at a point, where the texture differs most at a seam, or where it differs most "
                     "from the first of --compare"});
  table.add(
      {.name = "extent",
       .type = Type::length,
       .default_value = "64tx",
       .group = group,
       .help = "what --at shows across: 0.02 in model units, 1% of sqrt(area), 64tx in texels"});
}

void add_paint_options(OptionTable& table) {
  using Type = Option::Type;
  const std::string group = "Picture";
  table.add(
      {.name = "paint",
       .letter = 'p',
       .type = Type::choice,
       .default_value = "auto",
       .choices = {"auto", "texture", "vertices", "charts", "clay", "numbers"},
       .group = group,
       .help = "what is shown on the surface",
       .details =
           "vertices: colours at vertices. numbers: one channel of the textures in false "
           "colours, with a legend. auto: the texture, else colours at vertices, else clay."});
  table.add({.name = "seams",
             .group = group,
             .help = "draw seams in orange, ends of the surface in blue"});
  table.add({.name = "wires", .group = group, .help = "draw the edges of triangles"});
  table.add({.name = "unlit", .group = group, .help = "values as they are, without light"});
  table.add({.name = "compare",
             .letter = 'c',
             .type = Type::path,
             .count = Option::Count::many,
             .group = group,
             .help = "other pictures for the textures, shown beside them; those of several versions set by set"});
  table.add({.name = "overview", .group = group, .help = "a page of all there is to see"});
  table.add({.name = "size",
             .letter = 's',
             .type = Type::text,
             .default_value = as_typed(RenderOptions{}.width),
             .accepts = [](const std::string& text) { return parse_size(text).has_value(); },
             .wanted = "pixels, such as 1024 or 1920x1080, 1 to 16384 a side",
             .metavar = "N|WxH",
             .group = group,
             .help = "pixels of each picture"});
  table.add({.name = "background",
             .type = Type::text,
             .default_value = "gradient",
             .accepts = [](const std::string& text) { return parse_backdrop(text).has_value(); },
             .wanted = "gradient, transparent, white, black or #rrggbb",
             .metavar = "COLOUR",
             .group = group,
             .help = "gradient, transparent, white, black or #rrggbb"});
  table.add({.name = "samples",
             .type = Type::integer,
             .default_value = as_typed(RenderOptions{}.samples),
             .least = 1,
             .most = 16,
             .group = group,
             .help = "per pixel and direction: more is smoother and slower"});
  table.add({.name = "line-width",
             .type = Type::number,
             .default_value = as_typed(RenderOptions{}.line_width),
             .unit = "pixels",
             .least = 0.1,
             .most = 100,
             .group = group,
             .help = "of seams"});
  table.add({.name = "columns",
             .type = Type::integer,
             .default_value = as_typed(SheetOptions{}.columns),
             .least = 0,
             .most = 1000,
             .group = group,
             .help = "of a page; 0: nearly square"});
  table.add({.name = "title", .type = Type::text, .group = group, .help = "above a page"});
}

void add_number_and_layout_options(OptionTable& table) {
  using Type = Option::Type;
  const std::string numbers_group = "Numbers", layout = "Layout";
  table.add({.name = "channel",
             .type = Type::integer,
             .default_value = as_typed(RenderOptions{}.channel),
             .least = 0,
             .most = 1023,
             .group = numbers_group,
             .help = "which channel of the textures"});
  table.add({.name = "range",
             .type = Type::text,
             .accepts = [](const std::string& text) { return parse_numbers(text, 2).has_value(); },
             .wanted = "two numbers such as -1,1",
             .metavar = "LOW,HIGH",
             .group = numbers_group,
             .help = "values of the first and last colour; by default all there are"});
  table.add({.name = "map",
             .type = Type::choice,
             .default_value = "sequential",
             .choices = {"sequential", "diverging"},
             .group = numbers_group,
             .help = "colours for magnitudes, or for values on both sides of 0"});
  table.add({.name = "isolines",
             .type = Type::integer,
             .default_value = as_typed(FalseColour{}.isolines),
             .least = 0,
             .most = 1000,
             .group = numbers_group,
             .help = "lines of equal value"});
  table.add(
      {.name = "layout", .group = layout, .help = "draw the texture with its charts instead"});
  table.add({.name = "layout-texture",
             .type = Type::integer,
             .default_value = as_typed(UvLayoutOptions{}.texture),
             .least = 0,
             .most = 100000,
             .group = layout,
             .help = "which of several textures"});
  table.add({.name = "zoom",
             .type = Type::number,
             .default_value = as_typed(UvLayoutOptions{}.zoom),
             .least = 1,
             .most = 100000,
             .group = layout,
             .help = "magnify the layout around --center"});
  table.add({.name = "center",
             .type = Type::text,
             .default_value = as_typed(UvLayoutOptions{}.center.x()) + "," +
                              as_typed(UvLayoutOptions{}.center.y()),
             .accepts = [](const std::string& text) { return parse_numbers(text, 2).has_value(); },
             .wanted = "a texture coordinate such as 0.25,0.75",
             .metavar = "U,V",
             .group = layout,
             .help = "the texture coordinate in the middle"});
}

}  // namespace

void require_picture_name(const OptionValues& options, const std::string& name) {
  if (!options.has(name)) return;
  require(names_picture(options.text(name)),
          fmt::format("--{}: found {}, whose extension names no picture; wanted .png, .jpg, .webp, .tif, .exr, .bmp or "
                      ".tga",
                      name, options.text(name)));
}

void add_up_option(OptionTable& table, const std::string& group) {
  table.add({.name = "up",
             .type = Option::Type::choice,
             .default_value = "y",
             .choices = up_names(),
             .group = group,
             .help = "the model's upright axis"});
}

View::Up asked_up(const OptionValues& options) {
  return View::Up(std::ranges::find(up_names(), options.text("up")) - up_names().begin());
}

bool is_view(const std::string& text) {
  try {
    parse_view(text);
    return true;
  } catch (const InvalidInput&) {
    return false;
  }
}

void add_view_option(OptionTable& table, const std::string& group) {
  table.add({.name = "view",
             .type = Option::Type::text,
             .default_value = "corner",
             .accepts = is_view,
             .wanted = "front, back, left, right, top, bottom, corner or AZIMUTH,ELEVATION",
             .group = group,
             .help = "from where pictures are drawn: front, back, left, right, top, bottom, "
                     "corner, or AZIMUTH,ELEVATION in degrees"});
}

void add_render_options(OptionTable& table) {
  add_camera_options(table);
  add_paint_options(table);
  add_number_and_layout_options(table);
}

std::vector<double> numbers_of(const OptionValues& options, const std::string& name,
                               std::size_t count) {
  return *parse_numbers(options.text(name), count);
}

ModelPictureOptions asked_picture(const OptionValues& options, const TexturedModel& scene) {
  using Page = ModelPictureOptions::Page;
  ModelPictureOptions picture{.views = options.texts("view"),
                              .render = render_options(options, scene),
                              .layout = layout_options(options, scene)};
  const bool single = picture.views.size() == 1 || options.has("at");
  picture.page = options.flag("overview") ? Page::overview : single ? Page::view : Page::views;
  picture.sheet.columns = int(options.integer("columns"));
  if (options.has("title")) picture.sheet.title = options.text("title");
  return picture;
}

std::vector<Texture> read_compared(const OptionValues& options, const TexturedModel& scene) {
  std::vector<Texture> after;
  for (const std::string& path : options.texts("compare")) after.push_back(read_texture(path));
  if (after.empty()) return after;
  require(has_pictures(scene), scene.model.path.string() + ": has no textures to compare with");
  const std::size_t count = scene.model.textures.size();
  require(after.size() % count == 0,
          fmt::format("--compare: found {}, wanted one for each texture of {}, which has {}, or several such sets",
                      counted(std::ssize(after), "picture"), scene.model.path.string(),
                      counted(std::ssize(scene.model.textures), "texture")));
  for (std::size_t k = 0; k < after.size(); ++k) {
    const Image<float>&a = scene.model.textures[k % count].pixels, &b = after[k].pixels;
    require(a.width() == b.width() && a.height() == b.height(),
            fmt::format("{}: {} x {} pixels, but {} has {} x {}: only equal sizes can be compared",
                        after[k].path.string(), b.width(), b.height(), scene.model.textures[k % count].name,
                        a.width(), a.height()));
  }
  return after;
}

}  // namespace mq::app

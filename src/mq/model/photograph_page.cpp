#include "mq/model/photograph_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "mq/model/model_picture.h"

namespace mq {
namespace {

constexpr int side = 360, columns = 4;

/// By none, one, two, three, and more photographs.
constexpr std::array<Colour, 5> colours_of_counts = {
    {{0, 0, 0}, {0.84F, 0.19F, 0.15F}, {0.99F, 0.68F, 0.38F}, {0.65F, 0.85F, 0.42F}, {0.1F, 0.6F, 0.31F}}};

ModelPictureOptions page_of(const char* title, View::Up up) {
  ModelPictureOptions page{.page = ModelPictureOptions::Page::views, .views = {"front", "right", "back", "left"}};
  page.render.view.up = up;
  page.render.width = page.render.height = side;
  page.sheet.columns = columns;
  page.render.light = RenderOptions::Light::none;
  page.sheet.title = title;
  return page;
}

Signal colours_of_seen(std::span<const int> shown_by) {
  Signal colours(std::ssize(shown_by), 3);
  for (std::size_t i = 0; i < shown_by.size(); ++i) {
    const Colour& colour = colours_of_counts[std::min(std::size_t(shown_by[i]), colours_of_counts.size() - 1)];
    for (int c = 0; c < 3; ++c) colours(Eigen::Index(i), c) = colour[std::size_t(c)];
  }
  return colours;
}

Tile swatch(const Colour& colour, std::string label) {
  constexpr int width = 330, height = 24;
  Tile tile{Image<float>(width, height, 3), std::move(label)};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) tile.image(x, y, c) = colour[std::size_t(c)];
  return tile;
}

Image<float> legend(const char* title, const std::vector<Tile>& swatches) {
  SheetOptions sheet;
  sheet.columns = columns, sheet.title = title;
  return contact_sheet(swatches, sheet);
}

/// One below the other, on the background of sheets.
Image<float> stacked(std::span<const Image<float>> parts) {
  const Colour background = SheetOptions{}.background;
  int width = 0, height = 0;
  for (const Image<float>& part : parts) width = std::max(width, part.width()), height += part.height();
  Image<float> page(width, height, 3);
  int top = 0;
  for (const Image<float>& part : parts) {
    for (int y = 0; y < part.height(); ++y)
      for (int x = 0; x < width; ++x)
        for (int c = 0; c < 3; ++c)
          page(x, top + y, c) = x < part.width() ? part(x, y, c) : background[std::size_t(c)];
    top += part.height();
  }
  return page;
}

/// Red, green and blue of a photograph's number.
Colour colour_of_number(int number) {
  const Signal row = colours_of_labels(std::vector<int>{number});
  return {float(row(0, 0)), float(row(0, 1)), float(row(0, 2))};
}

}  // namespace

Image<float> draw_photographs(const TexturedModel& model, const TextureSignal& target, const PhotographTexture& found,
                              std::span<const std::string> names, View::Up up) {
  std::vector<Image<float>> parts;
  TexturedModel painted = model;
  target.replace(colours_of_labels(found.labels), Depth::u8, painted.model);
  parts.push_back(ModelRenderer(painted).draw(page_of("photographs chosen, and the texture", up), model.model.textures));
  std::vector<Tile> swatches;
  for (std::size_t v = 0; v < names.size(); ++v)
    swatches.push_back(swatch(colour_of_number(int(v)),
                              fmt::format("{}: {} ({:.1f} %)", v, names[v],
                                          100.0 * double(found.views[v].texels) / double(found.labels.size()))));
  swatches.push_back(swatch({0, 0, 0}, "none: filled in"));
  parts.push_back(legend("", swatches));
  target.replace(colours_of_seen(found.shown_by), Depth::u8, painted.model);
  parts.push_back(ModelRenderer(painted).draw(page_of("how many photographs show a place", up)));
  swatches.clear();
  const char* const counts[] = {"none", "one", "two", "three", "more"};
  for (std::size_t k = 0; k < colours_of_counts.size(); ++k) swatches.push_back(swatch(colours_of_counts[k], counts[k]));
  parts.push_back(legend("", swatches));
  return stacked(parts);
}

}  // namespace mq

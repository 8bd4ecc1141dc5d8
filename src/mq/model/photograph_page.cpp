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

/// None, one, two and more of them left out.
constexpr std::array<Colour, 4> colours_of_rejected = {
    {{0.25F, 0.25F, 0.28F}, {0.99F, 0.85F, 0.35F}, {0.96F, 0.5F, 0.2F}, {0.84F, 0.1F, 0.15F}}};

ModelPictureOptions page_of(const char* title, View::Up up) {
  ModelPictureOptions page{.page = ModelPictureOptions::Page::views, .views = {"front", "right", "back", "left"}};
  page.render.view.up = up;
  page.render.width = page.render.height = side;
  page.sheet.columns = columns;
  page.render.light = RenderOptions::Light::none;
  page.sheet.title = title;
  return page;
}

/// Of each count its colour, of those that are more than there are colours the last.
Signal colours_of(std::span<const int> counts, std::span<const Colour> colours_of_each) {
  Signal colours(std::ssize(counts), 3);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const Colour& colour = colours_of_each[std::min(std::size_t(counts[i]), colours_of_each.size() - 1)];
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
  const auto add_counts = [&](const char* title, std::span<const int> counts, std::span<const Colour> colours,
                              std::span<const char* const> words) {
    target.replace(colours_of(counts, colours), Depth::u8, painted.model);
    parts.push_back(ModelRenderer(painted).draw(page_of(title, up)));
    swatches.clear();
    for (std::size_t k = 0; k < colours.size(); ++k) swatches.push_back(swatch(colours[k], words[k]));
    parts.push_back(legend("", swatches));
  };
  constexpr std::array shown = {"none", "one", "two", "three", "more"};
  constexpr std::array rejected = {"none", "one left out", "two left out", "more left out"};
  add_counts("how many photographs show a place", found.shown_by, colours_of_counts, shown);
  add_counts("how many disagree with the others there", found.rejected_by, colours_of_rejected, rejected);
  return stacked(parts);
}

}  // namespace mq

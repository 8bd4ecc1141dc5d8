#include "mq/draw/contact_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"
#include "mq/draw/detail/text.h"

namespace mq {
namespace {

/// The columns that make the page most nearly square.
int square_columns(int count, int width, int height) {
  int best = 1;
  double least = 1e300;
  for (int columns = 1; columns <= count; ++columns) {
    const int rows = (count + columns - 1) / columns;
    const double off = std::abs(std::log(double(columns) * width / (double(rows) * height))) +
                       0.3 * (rows * columns - count);
    if (off < least + 1e-9) least = off, best = columns;  // of equals the wider
  }
  return best;
}

std::string shortened(const std::string& text, int width, int scale) {
  if (text_width(text, scale) <= width) return text;
  std::string cut = text;
  while (!cut.empty() && text_width(cut + "...", scale) > width) {
    while (!cut.empty() && (static_cast<unsigned char>(cut.back()) & 0xC0) == 0x80) cut.pop_back();
    if (!cut.empty()) cut.pop_back();
  }
  return cut + "...";
}

/// In lines that are no wider, broken at spaces.
std::vector<std::string> broken(const std::string& text, int width, int scale) {
  std::vector<std::string> lines;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find(' ', at), text.size());
    const std::string word = text.substr(at, end - at);
    if (!lines.empty() && text_width(lines.back() + ' ' + word, scale) <= width)
      lines.back() += ' ' + word;
    else
      lines.push_back(word);
    at = end + 1;
  }
  for (std::string& line : lines) line = shortened(line, width, scale);
  return lines;
}

void paste(const Image<float>& tile, int x, int y, Image<float>& page) {
  for (int row = 0; row < tile.height(); ++row)
    for (int column = 0; column < tile.width(); ++column)
      std::ranges::copy(tile.pixel(column, row), page.pixel(x + column, y + row).begin());
}

}  // namespace

Image<float> contact_sheet(const std::vector<Tile>& tiles, const SheetOptions& options) {
  require(!tiles.empty(), "a contact sheet needs at least one picture");
  require(options.gap >= 0 && options.text_scale >= 1 && options.columns >= 0,
          "the gap and columns of a contact sheet are not negative, its text scale is at least 1");
  int width = 0, height = 0;
  bool labelled = false;
  for (const Tile& tile : tiles) {
    if (tile.image.empty())
      throw InvalidInput(fmt::format("the picture \"{}\" has no pixels", tile.label));
    width = std::max(width, tile.image.width());
    height = std::max(height, tile.image.height());
    labelled = labelled || !tile.label.empty();
  }
  const int count = int(tiles.size()), gap = options.gap, scale = options.text_scale;
  const int label = labelled ? text_height(scale) + 4 * scale : 0;
  const int columns = options.columns > 0 ? options.columns : square_columns(count, width, height);
  const int rows = (count + columns - 1) / columns;
  const int across = columns * (width + gap), line = text_height(2 * scale);
  const std::vector<std::string> title = broken(options.title, across - gap, 2 * scale);
  const int head = title.empty() ? 0 : int(title.size()) * line + gap;

  Image<float> page(gap + across, gap + head + rows * (height + label + gap), 3);
  for (int y = 0; y < page.height(); ++y)
    for (int x = 0; x < page.width(); ++x)
      std::ranges::copy(options.background, page.pixel(x, y).begin());
  TextStyle style;
  style.scale = 2 * scale;
  for (int i = 0; i < int(title.size()); ++i)
    draw_text(page, gap, gap + i * line, title[std::size_t(i)], style);
  style.scale = scale;
  style.anchor = TextStyle::Anchor::centre;
  for (int i = 0; i < count; ++i) {
    const Image<float> tile = as_rgb(tiles[i].image, options.background);
    const int x = gap + i % columns * (width + gap);
    const int y = gap + head + i / columns * (height + label + gap);
    paste(tile, x + (width - tile.width()) / 2, y + (height - tile.height()) / 2, page);
    draw_text(page, x + width / 2, y + height + 4 * scale, shortened(tiles[i].label, width, scale),
              style);
  }
  return page;
}

}  // namespace mq

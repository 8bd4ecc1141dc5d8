#include "mq/fem/detail/part_window.h"

#include <algorithm>

#include "mq/atlas/texel_grid.h"

namespace mq {
namespace {

constexpr int around = 2;  ///< cells on each side of a place's own that are added with it
constexpr int coarse_side = 8;

int modulo_of(int at, int count) { return (at % count + count) % count; }

void extend(PartWindows::Window& window, int x0, int y0, int x1, int y1) {
  if (window.x0 == window.x1) {
    window = {x0, y0, x1, y1};
    return;
  }
  window = {std::min(window.x0, x0), std::min(window.y0, y0), std::max(window.x1, x1), std::max(window.y1, y1)};
}

}  // namespace

PartWindows::PartWindows(const Atlas& atlas, const BlockOwners& owners, int part, int near)
    : atlas_(atlas), owners_(owners), part_(part), near_(near), windows_(atlas.textures.size()) {
  for (int b = 0; b < owners.blocks.count(); ++b) {
    if (owners.part[std::size_t(b)] != part) continue;
    const TexelBlocks::Extent at = owners.blocks.extent(b);
    extend(windows_[std::size_t(at.texture)], at.x0 - near, at.y0 - near, at.x1 + near, at.y1 + near);
  }
}

bool PartWindows::empty() const {
  return std::ranges::all_of(windows_, [](const Window& w) { return w.x0 == w.x1; });
}

std::array<int, 2> PartWindows::wrapped(const TexturePlace& place) const {
  const TextureSize& size = atlas_.textures[std::size_t(place.texture)];
  if (size.wrap == Wrap::repeat) return {modulo_of(place.column, size.width), modulo_of(place.row, size.height)};
  return {std::clamp(place.column, -1, size.width - 1), std::clamp(place.row, -1, size.height - 1)};
}

std::int64_t PartWindows::key(int texture, int x, int y) const {
  return (std::int64_t(texture) << 40) + (std::int64_t(y + 1) << 20) + (x + 1);
}

/// Whether a texel of the part is within `near` of the cell; blocks are wider than that.
bool PartWindows::owns_near(int texture, int x, int y) const {
  const TextureSize& size = atlas_.textures[std::size_t(texture)];
  for (const int v : {y - near_, y + 1 + near_})
    for (const int u : {x - near_, x + 1 + near_}) {
      const bool repeats = size.wrap == Wrap::repeat;
      const Texels::Place texel{texture, repeats ? modulo_of(u, size.width) : std::clamp(u, 0, size.width - 1),
                                repeats ? modulo_of(v, size.height) : std::clamp(v, 0, size.height - 1)};
      if (owners_(texel) == part_) return true;
    }
  return false;
}

bool PartWindows::is_near(const TexturePlace& place) const {
  const auto [x, y] = wrapped(place);
  if (owns_near(place.texture, x, y)) return true;
  if (added_.empty()) return false;
  for (int v = -around; v <= around; ++v)
    for (int u = -around; u <= around; ++u) {
      const auto [beside, below] = wrapped({place.texture, x + u, y + v});
      if (added_.contains(key(place.texture, beside, below))) return true;
    }
  return false;
}

void PartWindows::add(const TexturePlace& place) {
  const auto [x, y] = wrapped(place);
  if (!added_.insert(key(place.texture, x, y)).second) return;
  extend(windows_[std::size_t(place.texture)], x - around, y - around, x + 2 + around, y + 2 + around);
}

template <class Visit>
void PartWindows::for_each_needed(const Visit& visit) const {
  for (int b = 0; b < owners_.blocks.count(); ++b) {
    if (owners_.part[std::size_t(b)] != part_) continue;
    const TexelBlocks::Extent at = owners_.blocks.extent(b);
    visit(at.texture, at.x0 - near_, at.y0 - near_, at.x1 + near_, at.y1 + near_);
  }
  for (const std::int64_t cell : added_) {
    const int k = int(cell >> 40), y = int(cell >> 20 & 0xfffff) - 1, x = int(cell & 0xfffff) - 1;
    visit(k, x - around, y - around, x + 1 + around, y + 1 + around);
  }
}

void PartWindows::close() {
  coarse_.resize(windows_.size());
  for (std::size_t k = 0; k < windows_.size(); ++k) {
    Window& w = windows_[k];
    const TextureSize& size = atlas_.textures[k];
    if (w.x0 == w.x1) continue;
    // A cell more, which is not needed, where the texture goes on.
    w = {std::max(w.x0 - 1, 0), std::max(w.y0 - 1, 0), std::min(w.x1 + 1, size.width), std::min(w.y1 + 1, size.height)};
    if (size.wrap == Wrap::repeat) w = {0, 0, size.width, size.height};
    coarse_[k].assign(std::size_t((w.x1 - w.x0) / coarse_side + 2) * std::size_t((w.y1 - w.y0) / coarse_side + 2), 0);
  }
  // Marks squares that hold a needed texel, from a few texels of each block's rim and each place that was added.
  const auto mark = [&](int k, int x0, int y0, int x1, int y1) {
    const Window& w = windows_[std::size_t(k)];
    const int columns = (w.x1 - w.x0) / coarse_side + 2, rows = (w.y1 - w.y0) / coarse_side + 2;
    for (int r = std::max(0, (y0 - w.y0) / coarse_side); r <= std::min(rows - 1, (y1 - w.y0) / coarse_side); ++r)
      for (int c = std::max(0, (x0 - w.x0) / coarse_side); c <= std::min(columns - 1, (x1 - w.x0) / coarse_side); ++c)
        coarse_[std::size_t(k)][std::size_t(r * columns + c)] = 1;
  };
  for_each_needed(mark);
}

bool PartWindows::meets(int texture, const std::array<TexelPoint, 3>& corners) const {
  const Window& w = windows_[std::size_t(texture)];
  if (w.x0 == w.x1) return false;
  const TextureSize& size = atlas_.textures[std::size_t(texture)];
  if (size.wrap == Wrap::repeat) return true;
  const auto [left, right] = std::minmax({corners[0].x, corners[1].x, corners[2].x});
  const auto [top, bottom] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
  // What lies beyond the texture is in its outermost cells.
  const auto texel = [](std::int64_t at, int count) { return std::clamp(floor_texel(at), -1, count); };
  const int x0 = texel(left, size.width) - 1, x1 = texel(right, size.width) + 2;
  const int y0 = texel(top, size.height) - 1, y1 = texel(bottom, size.height) + 2;
  if (x1 < w.x0 || y1 < w.y0 || x0 >= w.x1 || y0 >= w.y1) return false;
  const int columns = (w.x1 - w.x0) / coarse_side + 2, rows = (w.y1 - w.y0) / coarse_side + 2;
  for (int r = std::max(0, (y0 - w.y0) / coarse_side); r <= std::min(rows - 1, (y1 - w.y0) / coarse_side); ++r)
    for (int c = std::max(0, (x0 - w.x0) / coarse_side); c <= std::min(columns - 1, (x1 - w.x0) / coarse_side); ++c)
      if (coarse_[std::size_t(texture)][std::size_t(r * columns + c)]) return true;
  return false;
}

std::vector<char> PartWindows::cells(const Atlas& part) const {
  const TexelGrid grid(part.textures);
  std::vector<char> wanted(std::size_t(grid.cell_count()), 0);
  const auto mark = [&](int k, int x0, int y0, int x1, int y1) {
    const Window& w = windows_[std::size_t(k)];
    if (part.textures[std::size_t(k)].wrap == Wrap::repeat) {
      for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) wanted[std::size_t(grid.cell(k, x, y))] = 1;
      return;
    }
    const TextureSize& whole = atlas_.textures[std::size_t(k)];
    // Outermost cells of the window only where the texture ends.
    const int from_x = w.x0 == 0 ? -1 : 0, from_y = w.y0 == 0 ? -1 : 0;
    const int to_x = w.x1 - w.x0 - (w.x1 == whole.width ? 0 : 1), to_y = w.y1 - w.y0 - (w.y1 == whole.height ? 0 : 1);
    for (int y = std::max(y0 - w.y0, from_y); y < std::min(y1 - w.y0, to_y); ++y)
      for (int x = std::max(x0 - w.x0, from_x); x < std::min(x1 - w.x0, to_x); ++x)
        wanted[std::size_t(grid.cell(k, x, y))] = 1;
  };
  for_each_needed(mark);
  return wanted;
}

}  // namespace mq

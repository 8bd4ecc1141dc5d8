// InjectiveParts (charts, or parts of them) that share texels are found by letting each mark the
// texels it reads. The largest stay; for the others the pictures are made taller, and they are
// moved there.

#include "mq/atlas/separate_overlaps.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "mq/atlas/detail/injective_parts.h"
#include "mq/atlas/texel_grid.h"
#include "mq/base/error.h"
#include "mq/image/resample.h"

namespace mq {
namespace {

/// How far a part is moved, texels.
struct Move {
  int x = 0, y = 0;
};

/// One part: its triangles, and the texels that they read, before any wrapping.
struct Part {
  int texture = 0;
  std::vector<int> triangles;
  double texel_area = 0, surface_area = 0;
  int x0 = std::numeric_limits<int>::max(), y0 = x0;
  int x1 = std::numeric_limits<int>::min(), y1 = x1;  ///< one past the last

  int width() const { return x1 - x0; }
  int height() const { return y1 - y0; }
};

std::vector<Part> parts_of(const Surface& surface, const Atlas& atlas, const Footprints& footprints,
                           const InjectiveParts& injective) {
  std::vector<Part> parts(std::size_t(injective.count()));
  const Mesh& mesh = surface.mesh;
  for (int t = 0; t < int(injective.part.size()); ++t) {
    const int label = injective.part[std::size_t(t)];
    if (label < 0) continue;
    Part& part = parts[std::size_t(label)];
    part.texture = mesh.texture(t);
    part.triangles.push_back(t);
    const auto& p = atlas.corners[std::size_t(t)];
    const double one = double(TexelPoint::one);
    part.texel_area += std::abs(double(orientation(p[0], p[1], p[2])) / one / one) / 2;
    part.surface_area += (mesh.position(t, 1) - mesh.position(t, 0))
                             .cross(mesh.position(t, 2) - mesh.position(t, 0))
                             .norm() /
                         2;
    for (const TexelSpan& span : footprints.of(t)) {
      if (span.first == span.end) continue;
      part.x0 = std::min(part.x0, span.first), part.x1 = std::max(part.x1, span.end);
      part.y0 = std::min(part.y0, span.row), part.y1 = std::max(part.y1, span.row + 1);
    }
  }
  return parts;
}

bool leaves(const Part& part, const TextureSize& picture) {
  return part.x0 < 0 || part.y0 < 0 || part.x1 > picture.width || part.y1 > picture.height;
}

/// Which tile of a texture a column or row lies in. Where the texture does not repeat, what is more
/// than one texel outside counts as another tile: there, too, a texel stands for many places.
int tile_of(int i, int n, Wrap wrap) {
  if (wrap == Wrap::repeat) return i >= 0 ? i / n : -((n - 1 - i) / n);
  return i < -1 ? -1 : i > n ? 1 : 0;
}

/// visit(column tile, row tile, first texel of the grid, count) for runs of texels that a part
/// reads.
template <class Visit>
void for_each_run(const Part& part, const Footprints& footprints, const TexelGrid& grid,
                  const Visit& visit) {
  const TextureSize& size = grid.texture(part.texture);
  for (const int t : part.triangles)
    for (const TexelSpan& span : footprints.of(t)) {
      if (span.first == span.end) continue;
      const int row_tile = tile_of(span.row, size.height, size.wrap);
      if (span.first >= 0 && span.end <= size.width) {
        visit(0, row_tile, grid.texel(part.texture, span.first, span.row), span.end - span.first);
        continue;
      }
      for (int column = span.first; column < span.end; ++column)
        visit(tile_of(column, size.width, size.wrap), row_tile,
              grid.texel(part.texture, column, span.row), 1);
    }
}

/// Which parts lie in each texture: one is looked at after another, so that its texels alone are marked.
std::vector<std::vector<int>> by_texture(const std::vector<Part>& parts, int textures) {
  std::vector<std::vector<int>> numbers(static_cast<std::size_t>(textures));
  for (int p = 0; p < int(parts.size()); ++p) numbers[std::size_t(parts[std::size_t(p)].texture)].push_back(p);
  return numbers;
}

std::size_t texels_of(const TextureSize& size) { return std::size_t(size.width) * std::size_t(size.height); }

/// The parts that share texels with others, or with themselves in another tile.
std::vector<char> sharing(const std::vector<Part>& parts, const Footprints& footprints,
                          const TexelGrid& grid, const Progress& progress) {
  std::vector<char> shares(parts.size(), 0);
  std::vector<int> part_of(parts.size());                        // of reader
  std::iota(part_of.begin(), part_of.end(), 0);
  std::map<std::array<int, 3>, int> elsewhere;  // readers in other tiles
  std::vector<int> reader;                      // per texel of a texture: part and tile
  const auto read = [&](int p, int self, int texel) {
    int& other = reader[std::size_t(texel)];
    if (other >= 0 && other != self)
      shares[std::size_t(p)] = shares[std::size_t(part_of[std::size_t(other)])] = 1;
    other = self;
  };
  const auto of_texture = by_texture(parts, grid.texture_count());
  for (std::size_t k = 0; k < of_texture.size(); ++k) {
    if (of_texture[k].empty()) continue;
    reader.assign(texels_of(grid.texture(int(k))), -1);
    const int start = grid.first_texel(int(k));
    for (const int p : of_texture[k]) {
      progress.check();
      for_each_run(parts[std::size_t(p)], footprints, grid, [&](int column_tile, int row_tile, int first, int count) {
        int self = p;
        if (column_tile != 0 || row_tile != 0) {
          const auto [at, is_new] = elsewhere.try_emplace({p, column_tile, row_tile}, int(part_of.size()));
          if (is_new) part_of.push_back(p);
          self = at->second;
        }
        for (int texel = first; texel < first + count; ++texel) read(p, self, texel - start);
      });
    }
  }
  return shares;
}

/// The parts that cannot stay.
std::vector<int> to_move(const std::vector<Part>& parts, const std::vector<char>& shares,
                         const Footprints& footprints, const TexelGrid& grid) {
  std::vector<int> order, moved;
  for (int p = 0; p < int(parts.size()); ++p) {
    const Part& part = parts[std::size_t(p)];
    if (leaves(part, grid.texture(part.texture)))
      moved.push_back(p);
    else if (shares[std::size_t(p)])
      order.push_back(p);
  }
  std::ranges::stable_sort(order, std::greater(),
                           [&](int p) { return parts[std::size_t(p)].texel_area; });
  std::ranges::stable_sort(order, {}, [&](int p) { return parts[std::size_t(p)].texture; });
  std::vector<char> taken;  // per texel of a texture
  int texture = -1, start = 0;
  for (const int p : order) {
    if (parts[std::size_t(p)].texture != texture) {
      texture = parts[std::size_t(p)].texture;
      taken.assign(texels_of(grid.texture(texture)), 0);
      start = grid.first_texel(texture);
    }
    const auto for_each_texel = [&](const auto& visit) {
      for_each_run(parts[std::size_t(p)], footprints, grid, [&](int, int, int first, int count) {
        for (int texel = first - start; texel < first - start + count; ++texel) visit(taken[std::size_t(texel)]);
      });
    };
    bool is_free = true;
    for_each_texel([&](char one) { is_free = is_free && one == 0; });
    if (is_free)
      for_each_texel([](char& one) { one = 1; });
    else
      moved.push_back(p);
  }
  return moved;
}

/// No more cells than `TexelGrid` can number.
void require_room(std::int64_t texels) {
  if (texels < std::numeric_limits<int>::max() / 2) return;
  throw Unsupported(fmt::format(
      "the charts lie over one another, or over the borders of a texture that repeats, so often "
      "that "
      "{:.2g} texels would be needed to tell the places of the surface apart: unwrap it without "
      "overlaps, or work at vertices",
      double(texels)));
}

/// Puts parts side by side on shelves below the pictures, the tallest first; returns by how much
/// each part moves.
std::vector<Move> pack(const std::vector<Part>& parts, const std::vector<int>& moved,
                       SeparatedAtlas& apart) {
  constexpr int margin = 1;  // texels around each
  std::vector<Move> moves(parts.size());
  std::int64_t texels = 0;
  for (int k = 0; k < int(apart.pictures.size()); ++k) {
    TextureSize& size = apart.atlas.textures[std::size_t(k)];
    std::vector<int> order;
    for (const int p : moved)
      if (parts[std::size_t(p)].texture == k) order.push_back(p);
    std::ranges::stable_sort(order, std::greater(),
                             [&](int p) { return parts[std::size_t(p)].height(); });
    for (const int p : order)
      size.width = std::max(size.width, parts[std::size_t(p)].width() + 2 * margin);
    std::int64_t bottom = size.height;
    int x = size.width;  // where the next comes on its shelf; this one is full
    for (const int p : order) {
      const Part& part = parts[std::size_t(p)];
      const int width = part.width() + 2 * margin, height = part.height() + 2 * margin;
      if (x + width > size.width) {
        require_room((bottom + height) * size.width);
        apart.shelves.push_back({k, int(bottom), height, {}});
        bottom += height;
        x = 0;
      }
      SeparatedAtlas::Shelf& shelf = apart.shelves.back();
      Move& move = moves[std::size_t(p)];
      move = {x + margin - part.x0, shelf.y + margin - part.y0};
      shelf.patches.push_back({x, width, move.x, move.y});
      x += width;
    }
    size.height = int(bottom);
    if (!order.empty()) size.wrap = Wrap::clamp;
    texels += std::int64_t(size.width + 1) * (size.height + 1);
    require_room(texels);
  }
  return moves;
}

/// Makes charts of the parts, and seams of the edges between parts of one chart.
void cut_charts(const Surface& surface, const std::vector<Part>& parts,
                const InjectiveParts& injective, Atlas& atlas) {
  for (HalfEdge h = 0; h < HalfEdge(atlas.edges.size()); ++h) {
    if (atlas.chart[std::size_t(h / 3)] < 0 || atlas.edges[std::size_t(h)] != EdgeKind::inside)
      continue;
    const HalfEdge twin = surface.twins[std::size_t(h)];
    if (injective.part[std::size_t(h / 3)] == injective.part[std::size_t(twin / 3)]) continue;
    atlas.edges[std::size_t(h)] = EdgeKind::seam;
    if (h < twin) ++atlas.seam_count;
  }
  std::vector<Chart> charts;
  for (int s = 0; s < injective.count(); ++s) {
    const Part& part = parts[std::size_t(s)];
    Chart chart = atlas.charts[std::size_t(injective.chart[std::size_t(s)])];
    if (chart.triangles != int(part.triangles.size())) {
      chart.triangles = int(part.triangles.size());
      chart.texel_area = part.texel_area;
      chart.surface_area = part.surface_area;
    }
    charts.push_back(chart);
  }
  atlas.charts = std::move(charts);
  atlas.chart = injective.part;
}

void move_corners(const std::vector<Part>& parts, const std::vector<Move>& moves, Atlas& atlas) {
  for (std::size_t p = 0; p < parts.size(); ++p)
    for (const int t : parts[p].triangles)
      for (TexelPoint& corner : atlas.corners[std::size_t(t)]) {
        corner.x += moves[p].x * TexelPoint::one;
        corner.y += moves[p].y * TexelPoint::one;
      }
}

}  // namespace

SeparatedAtlas::Home SeparatedAtlas::home(int texture, int x, int y) const {
  const TextureSize& picture = pictures[std::size_t(texture)];
  const auto above = std::ranges::upper_bound(
      shelves, std::pair(texture, y), {}, [](const Shelf& s) { return std::pair(s.texture, s.y); });
  if (above != shelves.begin()) {
    const Shelf& shelf = *(above - 1);
    const auto right = std::ranges::upper_bound(shelf.patches, x, {}, &Patch::x);
    if (shelf.texture == texture && right != shelf.patches.begin())
      x -= (right - 1)->by_x, y -= (right - 1)->by_y;
  }
  const bool inside =
      picture.wrap == Wrap::repeat || (x >= 0 && x < picture.width && y >= 0 && y < picture.height);
  return {wrapped(x, picture.width, picture.wrap), wrapped(y, picture.height, picture.wrap),
          inside};
}

std::optional<SeparatedAtlas> separate_overlaps(const Surface& surface, const Atlas& atlas,
                                                const Progress& progress) {
  require_room(std::int64_t(std::min(atlas.texel_area, 1e18)));
  const Footprints footprints(atlas, progress.step("footprints", 0.3));
  const InjectiveParts injective =
      find_injective_parts(surface, atlas, footprints, progress.step("sheets", 0.4));
  const std::vector<Part> parts = parts_of(surface, atlas, footprints, injective);
  const TexelGrid grid(atlas.textures);
  const std::vector<char> shares = sharing(parts, footprints, grid, progress);
  if (std::ranges::find(shares, 1) == shares.end()) return std::nullopt;
  progress.at(0.9);

  SeparatedAtlas apart{.atlas = atlas, .shelves = {}, .pictures = atlas.textures};
  const std::vector<int> moved = to_move(parts, shares, footprints, grid);
  const std::vector<Move> moves = pack(parts, moved, apart);
  cut_charts(surface, parts, injective, apart.atlas);
  move_corners(parts, moves, apart.atlas);
  progress.at(1);
  return apart;
}

}  // namespace mq

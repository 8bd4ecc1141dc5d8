// Where one of two coupled texels is `Texels::interior` they are neighbours in the grid and need
// not be written down; of the others, near seams and borders, the pairs are kept.
#include "mq/fem/surface_ball.h"

#include <algorithm>

namespace mq {

SurfaceBall::SurfaceBall(const TexelSpace& space) : space_(space) {
  const Texels& texels = space.texels();
  for (const Texels::Place& at : texels.places) {
    if (std::size_t(at.texture) >= widths_.size()) {
      widths_.resize(std::size_t(at.texture) + 1, 0);
      heights_.resize(std::size_t(at.texture) + 1, 0);
    }
    widths_[std::size_t(at.texture)] = std::max(widths_[std::size_t(at.texture)], at.x + 1);
    heights_[std::size_t(at.texture)] = std::max(heights_[std::size_t(at.texture)], at.y + 1);
  }
  int rows = 0;
  for (const int height : heights_) {
    first_row_.push_back(rows);
    rows += height;
  }
  rows_.assign(std::size_t(rows) + 1, 0);
  for (const Texels::Place& at : texels.places)
    ++rows_[std::size_t(first_row_[std::size_t(at.texture)] + at.y) + 1];
  for (std::size_t r = 1; r < rows_.size(); ++r) rows_[r] += rows_[r - 1];
  seen_.assign(std::size_t(texels.size()), 0);

  std::vector<std::array<int, 2>> pairs;
  for (const auto& [i, j] : space.edges())
    if (!has_grid_neighbours(i) && !has_grid_neighbours(j)) {
      pairs.push_back({i, j});
      pairs.push_back({j, i});
    }
  std::ranges::sort(pairs);
  for (const auto& [i, j] : pairs) {
    if (seam_texels_.empty() || seam_texels_.back() != i) {
      seam_texels_.push_back(i);
      seam_first_.push_back(int(seam_neighbours_.size()));
    }
    seam_neighbours_.push_back(j);
  }
  seam_first_.push_back(int(seam_neighbours_.size()));
}

/// At the border of a texture that repeats its neighbours are on the other side.
bool SurfaceBall::has_grid_neighbours(int texel) const {
  const Texels& texels = space_.texels();
  const Texels::Place& at = texels.places[std::size_t(texel)];
  return texels.interior[std::size_t(texel)] != 0 && at.x > 0 && at.y > 0 &&
         at.x + 1 < widths_[std::size_t(at.texture)] &&
         at.y + 1 < heights_[std::size_t(at.texture)];
}

/// The first texel of a row from column x on.
int SurfaceBall::at(int row, int x) const {
  const auto& places = space_.texels().places;
  const auto begin = places.begin() + rows_[std::size_t(row)],
             end = places.begin() + rows_[std::size_t(row) + 1];
  return int(std::ranges::lower_bound(begin, end, x, {}, &Texels::Place::x) - places.begin());
}

template <class Visit>
void SurfaceBall::visit_neighbours(int texel, const Visit& visit) const {
  const Texels& texels = space_.texels();
  const Texels::Place& place = texels.places[std::size_t(texel)];
  const bool inner = has_grid_neighbours(texel);
  const int top = first_row_[std::size_t(place.texture)],
            height = heights_[std::size_t(place.texture)];
  for (int y = std::max(0, place.y - 1); y <= std::min(height - 1, place.y + 1); ++y)
    for (int k = at(top + y, place.x - 1);
         k < rows_[std::size_t(top + y) + 1] && texels.places[std::size_t(k)].x <= place.x + 1; ++k)
      if (inner || has_grid_neighbours(k)) visit(k);
  const auto found = std::ranges::lower_bound(seam_texels_, texel);
  if (found == seam_texels_.end() || *found != texel) return;
  const auto i = std::size_t(found - seam_texels_.begin());
  for (int n = seam_first_[i]; n < seam_first_[i + 1]; ++n) visit(seam_neighbours_[std::size_t(n)]);
}

namespace {

/// Those nearer than `radius`, over neighbours; `begin` visits the first of them.
template <class Position, class Begin, class Neighbours>
std::vector<int> reached(std::vector<int>& seen, int call, const Position& position,
                         const Vector3& centre, double radius, const Begin& begin,
                         const Neighbours& visit_neighbours) {
  std::vector<int> found;
  const auto visit = [&](int k) {
    if (seen[std::size_t(k)] == call) return;
    seen[std::size_t(k)] = call;
    if ((position(k) - centre).squaredNorm() < radius * radius) found.push_back(k);
  };
  begin(visit);
  for (std::size_t i = 0; i < found.size(); ++i) visit_neighbours(found[i], visit);
  std::ranges::sort(found);
  return found;
}

}  // namespace

std::vector<int> SurfaceBall::reach(int triangle, const Vector3& barycentric, const Vector3& centre,
                                    double radius) {
  return reached(
      seen_, ++call_, [&](int k) { return space_.texels().position(k); }, centre, radius,
      [&](const auto& visit) {
        for (const auto& [texel, weight] : space_.basis_at(triangle, barycentric)) visit(texel);
      },
      [&](int k, const auto& visit) { visit_neighbours(k, visit); });
}

std::vector<int> VertexBall::reach(int triangle, const Vector3& centre, double radius) {
  return reached(
      seen_, ++call_, [&](int v) { return positions_[std::size_t(v)]; }, centre, radius,
      [&](const auto& visit) {
        if (space_.shapes()[std::size_t(triangle)].empty()) return;
        for (const int v : space_.triangles()[std::size_t(triangle)]) visit(v);
      },
      [&](int v, const auto& visit) {
        for (int i = space_.row_starts()[std::size_t(v)];
             i < space_.row_starts()[std::size_t(v) + 1]; ++i)
          visit(space_.columns()[std::size_t(i)]);
      });
}

}  // namespace mq

// Where one of two coupled texels is `Texels::interior` they are neighbours in the grid and need
// not be written down; of the others, near seams and borders, the pairs are kept.
//
// What is found is found in spans, texels side by side in a row of a picture: a span takes what is beside its ends,
// what is above and below it, and what seams join to some of it.
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
  on_grid_.resize(std::size_t(texels.size()));
  for (int k = 0; k < texels.size(); ++k) on_grid_[std::size_t(k)] = has_grid_neighbours(k);
  seen_ = found_ = RowSet(texels.size());

  std::vector<std::array<int, 2>> pairs;
  for (const auto& [i, j] : space.edges())
    if (!on_grid_[std::size_t(i)] && !on_grid_[std::size_t(j)]) {
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

/// Whether a texel and the next one are neighbours as the grid has them.
bool SurfaceBall::are_neighbours_in_row(int left) const {
  if (left < 0 || std::size_t(left) + 1 >= on_grid_.size()) return false;
  if (!on_grid_[std::size_t(left)] && !on_grid_[std::size_t(left) + 1]) return false;
  const Texels::Place &a = space_.texels().places[std::size_t(left)], &b = space_.texels().places[std::size_t(left) + 1];
  return a.texture == b.texture && a.y == b.y && a.x + 1 == b.x;
}

/// Whether it is in the ball and was not asked for before.
bool SurfaceBall::takes(int texel, const Ball& ball) {
  return seen_.add(texel) && (space_.texels().position(texel) - ball.centre).squaredNorm() < ball.squared_radius;
}

/// A texel and those of its row that are reached over one another.
void SurfaceBall::take(int texel, const Ball& ball) {
  if (!takes(texel, ball)) return;
  int first = texel, last = texel;
  while (are_neighbours_in_row(first - 1) && takes(first - 1, ball)) --first;
  while (are_neighbours_in_row(last) && takes(last + 1, ball)) ++last;
  ahead_.push_back({first, last - first + 1});
}

/// What neighbours of a span there are in the row above or below it.
void SurfaceBall::take_in_row(const Span& span, int row, const Ball& ball) {
  const auto& places = space_.texels().places;
  const int left = places[std::size_t(span.first)].x, right = left + span.count - 1;
  const int end = rows_[std::size_t(row) + 1];
  for (int k = at(row, left - 1); k < end && places[std::size_t(k)].x <= right + 1; ++k) {
    if (seen_.has(k)) continue;
    const int x = places[std::size_t(k)].x;
    bool coupled = on_grid_[std::size_t(k)] != 0;
    for (int other = std::max(left, x - 1); !coupled && other <= std::min(right, x + 1); ++other)
      coupled = on_grid_[std::size_t(span.first + other - left)] != 0;
    if (coupled) take(k, ball);
  }
}

void SurfaceBall::take_beside(const Span& span, const Ball& ball) {
  const Texels::Place& place = space_.texels().places[std::size_t(span.first)];
  const int row = first_row_[std::size_t(place.texture)] + place.y;
  if (place.y > 0) take_in_row(span, row - 1, ball);
  if (place.y + 1 < heights_[std::size_t(place.texture)]) take_in_row(span, row + 1, ball);
  for (auto at = std::ranges::lower_bound(seam_texels_, span.first);
       at != seam_texels_.end() && *at < span.first + span.count; ++at) {
    const auto i = std::size_t(at - seam_texels_.begin());
    for (int n = seam_first_[i]; n < seam_first_[i + 1]; ++n) take(seam_neighbours_[std::size_t(n)], ball);
  }
}

std::vector<int> SurfaceBall::reach(int triangle, const Vector3& barycentric, const Vector3& centre,
                                    double radius) {
  const Ball ball{centre, radius * radius};
  for (const auto& [texel, weight] : space_.basis_at(triangle, barycentric)) take(texel, ball);
  while (!ahead_.empty()) {
    const Span span = ahead_.back();
    ahead_.pop_back();
    found_.add(span);
    take_beside(span, ball);
  }
  std::vector<int> texels = found_.rows();
  found_.clear();
  seen_.clear();
  return texels;
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

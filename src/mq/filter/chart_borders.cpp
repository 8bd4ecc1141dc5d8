#include "mq/filter/chart_borders.h"

#include <algorithm>

#include "mq/image/spread.h"

namespace mq {

std::vector<char> border_texels(const TexelSpace& space, std::span<const Coverage> coverage) {
  std::vector<char> border;
  for (const Texels::Place& at : space.texels().places)
    border.push_back(coverage[std::size_t(at.texture)].count(at.x, at.y) == 0);
  return border;
}

Filtered continue_at_borders(const TexelSpace& space, const Signal& psi,
                             const std::vector<char>& border, const SolverFactory& factory,
                             const Progress& progress) {
  Filtered found = smooth_at_seams(space, psi, border, Smooth::values, factory, progress);
  const Eigen::RowVectorXd low = psi.colwise().minCoeff(), high = psi.colwise().maxCoeff();
  for (Eigen::Index i = 0; i < psi.rows(); ++i)
    if (border[std::size_t(i)])
      found.signal.row(i) = found.signal.row(i).cwiseMax(low).cwiseMin(high);
  return found;
}

namespace {

/// 1: a triangle covers the texel's centre.
Image<char> covered_texels(const Coverage& coverage) {
  Image<char> covered(coverage.count.width(), coverage.count.height(), 1);
  for (int y = 0; y < covered.height(); ++y)
    for (int x = 0; x < covered.width(); ++x) covered(x, y) = coverage.count(x, y) > 0;
  return covered;
}

}  // namespace

std::int64_t spread_past_borders(const TexelSpace& space, int texture, const Coverage& coverage,
                                 double distance, Image<float>& picture) {
  std::vector<Texels::Place> unknowns;
  for (const Texels::Place& at : space.texels().places)
    if (at.texture == texture && coverage.count(at.x, at.y) == 0) unknowns.push_back(at);
  return spread_past_borders(unknowns, coverage, distance, picture);
}

std::int64_t spread_past_borders(std::span<const Texels::Place> borders, const Coverage& coverage, double distance,
                                 Image<float>& picture) {
  const Image<char> covered = covered_texels(coverage);
  Image<char> used = covered;
  for (const Texels::Place& at : borders) used(at.x, at.y) = 1;
  spread(covered, used, distance, picture);
  return std::ranges::count(used.values(), 0);
}

void spread_past_borders_of(const std::vector<char>& some, const TexelSpace& space, int texture,
                            const Coverage& coverage, Image<float>& picture) {
  const Image<char> covered = covered_texels(coverage);
  const int width = covered.width();
  enum Use : char { none, kept, given };
  Image<char> use(width, covered.height(), 1);
  for (std::size_t i = 0; i < use.values().size(); ++i) use.values()[i] = covered.values()[i] > 0 ? kept : none;
  const std::vector<Texels::Place>& places = space.texels().places;
  for (std::size_t k = 0; k < places.size(); ++k)
    if (places[k].texture == texture) use(places[k].x, places[k].y) = some[k] != 0 ? given : kept;
  const Image<int> nearest = nearest_known(covered);
  for (int y = 0; y < use.height(); ++y)
    for (int x = 0; x < width; ++x) {
      const int from = nearest(x, y);
      if (use(x, y) != none || from < 0 || use(from % width, from / width) != given) continue;
      std::ranges::copy(picture.pixel(from % width, from / width), picture.pixel(x, y).begin());
    }
}

}  // namespace mq

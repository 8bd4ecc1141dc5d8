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

std::int64_t spread_past_borders(const TexelSpace& space, int texture, const Coverage& coverage,
                                 double distance, Image<float>& picture) {
  const int width = picture.width(), height = picture.height();
  Image<char> covered(width, height, 1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) covered(x, y) = coverage.count(x, y) > 0;
  Image<char> used = covered;
  for (const Texels::Place& at : space.texels().places)
    if (at.texture == texture) used(at.x, at.y) = 1;
  spread(covered, used, distance, picture);
  return std::ranges::count(used.values(), 0);
}

}  // namespace mq

#include "mq/model/photograph_costs.h"

#include <algorithm>

namespace mq {

PhotographCosts photograph_costs(std::span<const Photograph> photographs, double texels,
                                 const PhotographTextureOptions& options) {
  constexpr double one_read = 0.06, aligned = 1.7, all_see_each_other = 14, million = 1e6;
  double pixels = 0;
  for (const Photograph& photograph : photographs)
    pixels += double(photograph.camera.width) * photograph.camera.height / million;
  const auto count = double(photographs.size());
  const double size = texels / million;
  PhotographCosts costs{.places = 0.35 * size,
                        .look = one_read * pixels + 0.02 * count,
                        .choose = (1 + 0.1 * count) * size,
                        .take = one_read * pixels + 0.03 * count + 0.2 * size};
  if (options.align) {
    costs.read_to_align = one_read * pixels + 0.03 * count;
    costs.align = aligned * count * std::min(1.0, count / all_see_each_other);
  }
  return costs;
}

}  // namespace mq

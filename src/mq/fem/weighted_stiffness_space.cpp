// Everything is asked of the space behind, with conductivities multiplied.

#include "mq/fem/weighted_stiffness_space.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"

namespace mq {

WeightedStiffnessSpace::WeightedStiffnessSpace(const SignalSpace& space,
                                               std::vector<float> conductivity)
    : space_(space) {
  set_conductivity(std::move(conductivity));
}

void WeightedStiffnessSpace::set_conductivity(std::vector<float> conductivity) {
  conductivity_ = std::move(conductivity);
  require(std::ssize(conductivity_) == space_.element_count(),
          fmt::format("{} conductivities were given for {} elements", conductivity_.size(),
                      space_.element_count()));
  const auto bad =
      std::ranges::find_if_not(conductivity_, [](float c) { return c >= 0 && std::isfinite(c); });
  if (bad != conductivity_.end())
    throw InvalidInput(
        fmt::format("a conductivity is {}; it must be finite and not negative", *bad));
}

SparseMatrix WeightedStiffnessSpace::system(double a, double b, const Progress& progress) const {
  return b == 0 ? space_.system(a, b, progress)
                : space_.weighted_system(a, b, conductivity_, progress);
}

Signal WeightedStiffnessSpace::stiffness_times(const Signal& psi,
                                               std::span<const double> beta) const {
  require(beta.empty(), "a modulation per unknown is not offered together with conductivities");
  return space_.weighted_stiffness_times(psi, conductivity_);
}

std::vector<float> WeightedStiffnessSpace::gradient_norms(const Signal& psi) const {
  return space_.gradient_norms(psi);
}

Signal WeightedStiffnessSpace::weighted_stiffness_times(const Signal& psi,
                                                        std::span<const float> conductivity) const {
  return space_.weighted_stiffness_times(psi, times(conductivity));
}

SparseMatrix WeightedStiffnessSpace::weighted_system(double a, double b,
                                                     std::span<const float> conductivity,
                                                     const Progress& progress) const {
  return space_.weighted_system(a, b, times(conductivity), progress);
}

void WeightedStiffnessSpace::for_each_mixed_element(
    std::span<const int>, const std::function<void(const Element&)>&) const {
  throw Unsupported("elements of a space with conductivities are not offered one by one");
}

Signal WeightedStiffnessSpace::edge_divergence(const std::vector<std::array<int, 2>>&, const Signal&) const {
  throw Unsupported("fields by edges are not offered on a space with conductivities");
}

std::vector<float> WeightedStiffnessSpace::times(std::span<const float> conductivity) const {
  require(conductivity.size() == conductivity_.size(), "one conductivity per element is needed");
  std::vector<float> product = conductivity_;
  for (std::size_t e = 0; e < product.size(); ++e) product[e] *= conductivity[e];
  return product;
}

}  // namespace mq

#include "mq/draw/detail/usual_residual.h"

#include <algorithm>

namespace mq {
namespace {

/// The size up to which residuals have half of all detail; 0 where none has any. Halves what is left, not to sort it all.
double median_at_detail(std::vector<Residual>& residuals) {
  const auto detail_of = [](auto from, auto to) {
    double sum = 0;
    for (; from != to; ++from) sum += from->detail;
    return sum;
  };
  auto first = residuals.begin(), last = residuals.end();
  double wanted = detail_of(first, last) / 2;
  if (!(wanted > 0)) return 0;
  while (last - first > 1) {
    const auto middle = first + (last - first) / 2;
    std::ranges::nth_element(first, middle, last, {}, &Residual::size);
    const double smaller = detail_of(first, middle);
    if (smaller >= wanted)
      last = middle;
    else
      wanted -= smaller, first = middle;
  }
  return first->size;
}

}  // namespace

double usual_residual(std::vector<Residual>& residuals, Usual usual) {
  if (residuals.empty()) return 0;
  const auto middle = residuals.begin() + std::ssize(residuals) / 2;
  std::ranges::nth_element(residuals, middle, {}, &Residual::size);
  const double median = middle->size;
  return usual == Usual::everywhere ? median : std::max(median, 2 * median_at_detail(residuals));
}

}  // namespace mq

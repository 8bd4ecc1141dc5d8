#include "shell/percentiles.h"

#include <fmt/format.h>

#include <algorithm>

namespace mq::app {
namespace {

/// `sorted` by value.
double percentile(const std::vector<Weighted>& sorted, double fraction) {
  double total = 0;
  for (const Weighted& w : sorted) total += w.weight;
  double sum = 0;
  for (const Weighted& w : sorted)
    if ((sum += w.weight) >= fraction * total) return w.value;
  return sorted.empty() ? 0 : sorted.back().value;
}

}  // namespace

Json percentiles_json(std::vector<Weighted> values) {
  std::ranges::sort(values, {}, &Weighted::value);
  return {{"p50", percentile(values, 0.5)},
          {"p90", percentile(values, 0.9)},
          {"p99", percentile(values, 0.99)},
          {"max", percentile(values, 1)}};
}

std::string percentiles_text(const Json& values) {
  return fmt::format("half below {:.4g}, 90 % {:.4g}, 99 % {:.4g}, worst {:.4g}",
                     values["p50"].get<double>(), values["p90"].get<double>(),
                     values["p99"].get<double>(), values["max"].get<double>());
}

}  // namespace mq::app

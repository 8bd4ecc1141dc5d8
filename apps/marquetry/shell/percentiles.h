#pragma once
/// Distributions in a report: values that each stand for some area.

#include <string>
#include <vector>

#include "shell/run.h"

namespace mq::app {

struct Weighted {
  double value;
  double weight;
};

/// "p50", "p90", "p99" and "max": the least values that at least that part of the weight does not
/// exceed.
Json percentiles_json(std::vector<Weighted> values);

/// These in words.
std::string percentiles_text(const Json& percentiles);

}  // namespace mq::app

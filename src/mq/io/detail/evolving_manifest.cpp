#include "mq/io/detail/evolving_manifest.h"

#include <cmath>

#include "mq/io/detail/json_text.h"

namespace mq {

using OrderedJson = nlohmann::ordered_json;

OrderedJson manifest_line(std::string_view text) {
  if (too_deep_json(text)) return OrderedJson(OrderedJson::value_t::discarded);
  return OrderedJson::parse(text, nullptr, false);
}

std::int64_t manifest_number(const OrderedJson& line, const char* name, std::int64_t most) {
  const auto found = line.find(name);
  if (found == line.end() || !found->is_number_integer()) return -1;
  const auto value = found->get<std::int64_t>();
  return value > most ? -1 : value;
}

bool is_step(double step) {
  if (!(std::isnormal(step) && step > 0)) return false;
  int exponent = 0;
  const double scaled = std::ldexp(std::frexp(step, &exponent), 8);
  return scaled == std::floor(scaled);
}

}  // namespace mq

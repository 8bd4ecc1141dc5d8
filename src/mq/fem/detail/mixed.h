#pragma once
/// Whether the unknowns of an element have different labels.

#include <span>

namespace mq {

template <class Numbers>
bool mixed(const Numbers& unknowns, std::span<const int> labels) {
  for (const int i : unknowns)
    if (labels[std::size_t(i)] != labels[std::size_t(unknowns[0])]) return true;
  return false;
}

}  // namespace mq

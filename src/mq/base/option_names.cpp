#include "mq/base/option_names.h"

#include <utility>

namespace mq {
namespace {

std::function<std::string(std::string_view)>& names_of_program() {
  static std::function<std::string(std::string_view)> names;
  return names;
}

}  // namespace

std::string option_name(std::string_view field) {
  const auto& names = names_of_program();
  return names ? names(field) : std::string(field);
}

void set_option_names(std::function<std::string(std::string_view)> names) {
  names_of_program() = std::move(names);
}

}  // namespace mq

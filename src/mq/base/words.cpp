#include "mq/base/words.h"

#include <fmt/format.h>

namespace mq {
namespace {

bool is_vowel(char c) { return std::string("aeiou").find(c) != std::string::npos; }

}  // namespace

std::string plural(const std::string& noun) {
  const std::size_t size = noun.size();
  if (noun.ends_with("vertex") || noun.ends_with("index") || noun.ends_with("matrix"))
    return noun.substr(0, size - 2) + "ices";
  if (size > 1 && noun.back() == 'y' && !is_vowel(noun[size - 2]))
    return noun.substr(0, size - 1) + "ies";
  for (const char* ending : {"s", "x", "ch", "sh"})
    if (noun.ends_with(ending)) return noun + "es";
  return noun + "s";
}

std::string counted(std::int64_t count, const std::string& noun) {
  return fmt::format("{} {}", count, count == 1 ? noun : plural(noun));
}

std::string ids_text(const Defect& defect, int most) {
  if (defect.ids.empty()) return "";
  const auto shown = std::min<std::ptrdiff_t>(most, std::ssize(defect.ids));
  return fmt::format("{} {}{}", defect.count == 1 ? "id" : "ids",
                     fmt::join(defect.ids.begin(), defect.ids.begin() + shown, ", "),
                     defect.count > shown ? ", ..." : "");
}

std::string sentence(const Defect& defect) {
  const std::string ids = ids_text(defect);
  return fmt::format("{} ({} of them{}{})", defect.message, defect.count, ids.empty() ? "" : ": ",
                     ids);
}

}  // namespace mq

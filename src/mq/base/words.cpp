#include "mq/base/words.h"

#include <fmt/format.h>

#include <algorithm>

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

std::string places_text(std::span<const Defect::Place> places, std::int64_t count,
                        std::span<const std::string> textures, int most) {
  if (places.empty()) return "";
  const bool several =
      textures.size() > 1 || (textures.empty() && std::ranges::any_of(places, &Defect::Place::texture));
  const auto where = [&](const Defect::Place& place) {
    const std::string at = fmt::format("at column {}, row {}", place.column, place.row);
    if (!several) return at;
    return at + " of " + (std::size_t(place.texture) < textures.size() ? textures[std::size_t(place.texture)]
                                                                      : fmt::format("texture {}", place.texture));
  };
  if (count == 1) return "in 1 place, " + where(places.front());
  std::string text = fmt::format("in {} places; the largest: ", count);
  const std::size_t shown = std::min(places.size(), std::size_t(most));
  for (std::size_t i = 0; i < shown; ++i)
    text += fmt::format("{}{} {}", i > 0 ? "; " : "", places[i].texels, where(places[i]));
  return text;
}

std::string short_sentence(const Defect& defect) {
  if (defect.brief.empty()) return sentence(defect);
  return counted(defect.count, defect.element) + " " + defect.brief;
}

std::string sentence(const Defect& defect) {
  const std::string where = places_text(defect.places, defect.place_count);
  if (!where.empty()) return fmt::format("{} ({} of them, {})", defect.message, defect.count, where);
  const std::string ids = ids_text(defect);
  return fmt::format("{} ({} of them{}{})", defect.message, defect.count, ids.empty() ? "" : ": ",
                     ids);
}

}  // namespace mq

#pragma once
/// Defects in a user's model are data: what, how bad, how many, and where.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace mq {

/// One kind of defect found in a model.
struct Defect {
  enum class Severity {
    note,     ///< coped with, nothing lost; said for completeness
    warning,  ///< coped with as documented; the user may want to look
    refused   ///< cannot be processed; the message says what to do
  };
  std::string kind;               ///< a stable name for scripts: "flipped_triangles"
  Severity severity = Severity::warning;
  std::string element;            ///< what `ids` count: "triangle", "vertex", "edge", "texel", "chart"
  std::int64_t count = 0;         ///< of all affected elements
  std::vector<std::int64_t> ids;  ///< the first of them, at most `max_ids`
  std::string message;            ///< what was found, what is done about it, what the user can do

  /// What follows "3 triangles" where one line must do: what they are, and what is done about them; empty:
  /// nothing shorter than the message.
  std::string brief = {};

  /// Texels that hang together.
  struct Place {
    int texture = 0;          ///< counted from 0
    int column = 0, row = 0;  ///< of a texel amid them, counted from 0 at the left top
    std::int64_t texels = 0;  ///< how many they are
  };
  std::vector<Place> places = {};  ///< of texels, where they are: the largest, at most `max_places`
  std::int64_t place_count = 0;    ///< of all such places

  static constexpr int max_ids = 100, max_places = 20;
};

using Defects = std::vector<Defect>;

/// Appends the defect with all its elements, of which the first are listed; nothing if there are none.
/// `brief`: as `Defect::brief`.
inline void add_defect(Defects& defects, const std::string& kind, Defect::Severity severity,
                       const std::string& element, const std::vector<std::int64_t>& all,
                       const std::string& message, const std::string& brief = {}) {
  if (all.empty()) return;
  Defect defect{kind, severity, element, std::int64_t(all.size()), {}, message, brief};
  const auto listed = std::min<std::ptrdiff_t>(std::ssize(all), Defect::max_ids);
  defect.ids.assign(all.begin(), all.begin() + listed);
  defects.push_back(std::move(defect));
}

/// Whether any of them refuses the model.
inline bool refused(const Defects& defects) {
  for (const Defect& d : defects)
    if (d.severity == Defect::Severity::refused) return true;
  return false;
}

}  // namespace mq

#pragma once
/// Lines of the manifest of an evolving mesh's store (docs/evolving_format.md).

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string_view>

namespace mq {

inline constexpr const char* store_format = "marquetry evolving mesh";
inline constexpr int store_version = 2;  ///< as it is written; 1 is read too

/// Discarded where the text is no JSON.
nlohmann::ordered_json manifest_line(std::string_view text);

/// A whole number of a line, from 0 to `most`; −1 where the line has none.
std::int64_t manifest_number(const nlohmann::ordered_json& line, const char* name,
                             std::int64_t most = std::int64_t(1) << 52);

/// Whether it is positive, finite and of at most eight significant bits: so are its multiples up to 2⁴⁵ exact.
bool is_step(double step);

}  // namespace mq

#pragma once
/// Where tests find things on this machine.

#include <filesystem>

namespace mq::places {

std::filesystem::path source();   ///< the repository
std::filesystem::path data();     ///< real models beside it, which may not be there
std::filesystem::path program();  ///< the built `marquetry`

}  // namespace mq::places

#include "mq/io/temporary_folder.h"

#include <fmt/format.h>
#include <stdlib.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <system_error>

#include "mq/base/error.h"

namespace mq {

namespace fs = std::filesystem;

fs::path temporary_place() {
  const char* named = std::getenv("TMPDIR");
  return named != nullptr && *named != '\0' ? named : "/tmp";
}

TemporaryFolder::TemporaryFolder(const std::string& begin, const std::string& purpose) {
  std::string name = (temporary_place() / (begin + "XXXXXX")).string();
  if (::mkdtemp(name.data()) == nullptr)
    throw IoError(fmt::format("{}: no folder for {} can be made here ({}); TMPDIR names another",
                              temporary_place().string(), purpose, std::strerror(errno)));
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

}  // namespace mq

#include "mq/io/path_status.h"

#include <fmt/format.h>

#include "mq/base/error.h"

namespace mq {
namespace {

std::filesystem::file_status status_of(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::none)
    throw IoError(fmt::format("{}: {}; choose {}", path.string(), error.message(),
                              error == std::errc::permission_denied ? "a file or folder you may use" : "another name"));
  return status;
}

}  // namespace

bool is_there(const std::filesystem::path& path) { return std::filesystem::exists(status_of(path)); }

bool is_folder(const std::filesystem::path& path) { return std::filesystem::is_directory(status_of(path)); }

std::filesystem::path full_name(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::path absolute = std::filesystem::absolute(path, error);
  if (error) return path.lexically_normal();  // the current folder has been removed
  const std::filesystem::path real = std::filesystem::weakly_canonical(absolute, error);
  return error ? absolute.lexically_normal() : real;
}

}  // namespace mq

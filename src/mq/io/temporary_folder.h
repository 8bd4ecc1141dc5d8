#pragma once
/// Folders for what is not to stay.

#include <filesystem>
#include <string>

namespace mq {

/// Where temporary files go: what TMPDIR names, /tmp where that is empty or not set.
std::filesystem::path temporary_place();

/// A folder of its own in `temporary_place()`, removed with what is in it.
class TemporaryFolder {
 public:
  /// Its name begins with `begin`; `purpose` is what it is for, in the message of the `IoError` that is thrown
  /// where it cannot be made.
  TemporaryFolder(const std::string& begin, const std::string& purpose);
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::filesystem::path& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

}  // namespace mq

#include "mq/io/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <set>

#include "mq/base/error.h"
#include "mq/io/detail/held.h"

namespace mq {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const char* remedy) {
  const char* reason = std::strerror(errno);
  throw IoError(fmt::format("cannot write {}: {}; {}", path.string(), reason, remedy));
}

/// ".NAME.PID-N.EXT" beside `path`: hidden, and no other writer's, in this process or another.
/// A long name is cut so that the temporary one still fits a file system's 255 bytes.
std::filesystem::path temporary_beside(const std::filesystem::path& path) {
  static std::atomic<unsigned> next{0};
  const std::string stem = path.stem().string().substr(0, 160);
  return path.parent_path() / fmt::format(".{}.{}-{}{}", stem, ::getpid(), next++,
                                          path.extension().string());
}

/// The temporary files there are. A process has one of these, as it has one set of open files.
struct Unfinished {
  std::mutex mutex;
  std::set<std::filesystem::path> files;
  std::multiset<std::filesystem::path> on_demand;  ///< folders to be made
  std::set<std::filesystem::path> made;            ///< folders, for files not yet in their place
  WrittenFiles written;
};

Unfinished& unfinished() {
  static Unfinished all;
  return all;
}

/// The same for all spellings of a folder's name.
std::filesystem::path folder_name(const std::filesystem::path& folder) {
  std::filesystem::path name = std::filesystem::absolute(folder).lexically_normal();
  return name.has_filename() ? name : name.parent_path();
}

/// Makes a folder that is not there, and those around it where it was asked for; says which, the outer ones first.
std::vector<std::filesystem::path> made_on_demand(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  std::vector<fs::path> missing;
  if (folder.empty()) return missing;
  const fs::path name = folder_name(folder);
  std::error_code failure;
  for (fs::path part = name; !part.empty() && !fs::exists(part, failure); part = part.parent_path())
    missing.insert(missing.begin(), part);
  if (missing.empty() || (missing.size() > 1 && !unfinished().on_demand.contains(name))) return {};
  fs::create_directories(name, failure);
  if (failure)
    throw IoError(fmt::format("{}: the folder cannot be made: {}; choose one you may write to", folder.string(),
                              failure.message()));
  unfinished().made.insert(missing.begin(), missing.end());
  return missing;
}

/// Removes folders that were made on demand and are empty.
void remove_made(const std::vector<std::filesystem::path>& folders) {
  std::error_code failure;  // of those that are not empty
  for (auto folder = folders.rbegin(); folder != folders.rend(); ++folder) {
    std::filesystem::remove(*folder, failure);
    unfinished().made.erase(*folder);
  }
}

}  // namespace

void make_on_demand(const std::filesystem::path& folder) {
  const std::lock_guard lock(unfinished().mutex);
  unfinished().on_demand.insert(folder_name(folder));
}

void make_no_more(const std::filesystem::path& folder) {
  const std::lock_guard lock(unfinished().mutex);
  auto& all = unfinished().on_demand;
  if (const auto one = all.find(folder_name(folder)); one != all.end()) all.erase(one);
}

AtomicFile::AtomicFile(std::filesystem::path path) : path_(std::move(path)) {
  require_file(path_);
  std::error_code ignored;
  if (path_.filename().empty() || std::filesystem::is_directory(path_, ignored))
    throw IoError(fmt::format("cannot write {}: it is a directory; give a file name in it",
                              path_.string()));
  // A link stays a link: the file it points to is replaced.
  if (std::filesystem::is_symlink(path_, ignored)) {
    const auto target = std::filesystem::weakly_canonical(path_, ignored);
    if (!ignored) path_ = target;
  }
  if (std::filesystem::exists(path_, ignored) && !std::filesystem::is_regular_file(path_, ignored))
    throw IoError(fmt::format("cannot write {}: it is not an ordinary file; give another name",
                              path_.string()));
  const std::lock_guard lock(unfinished().mutex);
  made_ = made_on_demand(path_.parent_path());
  for (;;) {
    temporary_ = temporary_beside(path_);
    const int file = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file >= 0) {
      ::close(file);
      unfinished().files.insert(temporary_);
      return;
    }
    if (errno == EEXIST) continue;
    const int reason = errno;
    remove_made(made_);
    errno = reason;
    fail(path_, errno == ENOENT ? "make the folder around its folder first" : "choose a folder you may write to");
  }
}

AtomicFile::~AtomicFile() {
  if (!pending_) return;
  const std::lock_guard lock(unfinished().mutex);
  unfinished().files.erase(temporary_);
  ::unlink(temporary_.c_str());
  remove_made(made_);
}

void AtomicFile::commit() {
  const std::lock_guard lock(unfinished().mutex);
  struct stat old;
  if (::stat(path_.c_str(), &old) == 0) ::chmod(temporary_.c_str(), old.st_mode & 07777);
  if (::rename(temporary_.c_str(), path_.c_str()) != 0) fail(path_, "choose another place");
  unfinished().files.erase(temporary_);
  for (const auto& folder : made_) unfinished().made.erase(folder);
  ++unfinished().written.count;
  unfinished().written.last = path_;
  pending_ = false;
}

std::unique_lock<std::mutex> remove_unfinished_files() {
  std::unique_lock lock(unfinished().mutex);
  for (const auto& file : unfinished().files) ::unlink(file.c_str());
  unfinished().files.clear();
  remove_made({unfinished().made.begin(), unfinished().made.end()});  // outer ones sort first
  return lock;
}

WrittenFiles written_files() {
  const std::lock_guard lock(unfinished().mutex);
  return unfinished().written;
}

void write_file(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  if (hold_bytes(path, bytes)) return;
  AtomicFile file(path);
  const int out = ::open(file.temporary().c_str(), O_WRONLY | O_TRUNC | O_CLOEXEC);
  if (out < 0) fail(path, "choose a folder you may write to");
  while (!bytes.empty()) {
    const ssize_t written = ::write(out, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      const int reason = errno;
      ::close(out);
      errno = reason;
      fail(path, "make room or choose another place");
    }
    bytes = bytes.subspan(std::size_t(written));
  }
  if (::close(out) != 0) fail(path, "make room or choose another place");
  file.commit();
}

}  // namespace mq

#pragma once
/// Files that appear whole or not at all: written under a temporary name beside their place, then
/// renamed. A reader never sees half a file, and a failure leaves the old file as it was.
///
///     AtomicFile file(path);
///     { std::ofstream out(file.temporary(), std::ios::binary); out << ...; }
///     file.commit();

#include <cstddef>
#include <filesystem>
#include <mutex>
#include <span>
#include <vector>

namespace mq {

/// A folder that is not there is made when the first file is written to it, if the one around it is there, and removed
/// with that file where it is not committed: so it is never left empty. From here to `make_no_more` those around this
/// one are made, too. Asked for twice it is to be let go twice.
void make_on_demand(const std::filesystem::path& folder);
void make_no_more(const std::filesystem::path& folder);

class AtomicFile {
 public:
  /// Chooses a temporary name in the folder of `path` that ends in `path`'s extension (libraries
  /// that go by the extension find theirs) and makes an empty file of it. Throws `IoError` when
  /// `path` names a directory, or neither its folder nor the one around that is there (but see
  /// `make_on_demand`), or it cannot be written to.
  explicit AtomicFile(std::filesystem::path path);
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Removes the temporary file unless `commit` has put it in its place.
  ~AtomicFile();

  /// The file to write to.
  const std::filesystem::path& temporary() const { return temporary_; }

  /// Where it will be: `path`, or the file that this links to.
  const std::filesystem::path& path() const { return path_; }

  /// Renames the temporary file to `path`, replacing what was there with its permissions kept.
  /// Throws `IoError`.
  void commit();

 private:
  std::filesystem::path path_;
  std::filesystem::path temporary_;
  std::vector<std::filesystem::path> made_;  ///< folders, the outer ones first
  bool pending_ = true;
};

/// Removes the temporary files of all writers in this process, and the folders made for them, for a
/// program that is about to end without coming back to them. None is made and none put in its place
/// while the result is held.
[[nodiscard]] std::unique_lock<std::mutex> remove_unfinished_files();

/// What this process has put in its place so far.
struct WrittenFiles {
  int count = 0;
  std::filesystem::path last;
};
WrittenFiles written_files();

/// Writes `bytes` to `path` in this way. Throws `IoError` naming `path` and the system's reason
/// (disk full, not writable, ...).
void write_file(const std::filesystem::path& path, std::span<const std::byte> bytes);

}  // namespace mq

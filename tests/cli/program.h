#pragma once
/// Runs the real program in a folder of its own and keeps what it says.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace mq::test {

/// A folder that is empty at first and gone afterwards.
class Folder {
 public:
  Folder();
  ~Folder();
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }

  /// Names of everything inside, sorted, relative to it.
  std::vector<std::string> names() const;

 private:
  std::filesystem::path path_;
};

struct Result {
  int status = -1;     ///< exit status; 128 + the signal's number when one ended it
  std::string output;  ///< standard output
  std::string error;   ///< standard error

  nlohmann::json json() const { return nlohmann::json::parse(output); }
};

struct RunOptions {
  std::map<std::string, std::string> environment = {};  ///< added to the test's own
  /// SIGINT is sent once standard error holds the first of these texts, again at the second, ...
  std::vector<std::string> interrupt_at = {};
  long largest_file = 0;     ///< bytes a file may grow to; 0: no limit (a full disk, in small)
  std::string program = {};  ///< beside marquetry, in its place
  std::string standard_input = {};   ///< a file for standard input; by default the test's own
  std::string standard_output = {};  ///< a file for standard output, such as /dev/full
  /// Whom folders that are closed to all keep out: root may go everywhere, and becomes nobody.
  enum class User { own, ordinary } user = User::own;
};

/// marquetry WORDS..., started in `folder`.
Result marquetry(const Folder& folder, const std::vector<std::string>& words,
                 const RunOptions& options = {});

std::string file_bytes(const std::filesystem::path& path);
void write_bytes(const std::filesystem::path& path, const std::string& bytes);

}  // namespace mq::test

#pragma once
/// What several runs with one start write, so that none of them replaces what another made.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace mq::app {

/// While one exists, every `Run` enters what it will write. At most one exists at a time.
class OutputLedger {
 public:
  /// `list` is the file that says what is run; nothing may replace it.
  explicit OutputLedger(const std::filesystem::path& list);
  ~OutputLedger();
  OutputLedger(const OutputLedger&) = delete;
  OutputLedger& operator=(const OutputLedger&) = delete;

  /// What is entered from now on is of this run, such as "job 2".
  void begin(const std::string& run) { run_ = run; }

  /// Whether an earlier run wrote, or would write, this file.
  bool has(const std::filesystem::path& path) const;

  /// Throws `IoError` where one of them is of another run, unless `Replacing::allowed`, or the list.
  enum class Replacing { refused, allowed };
  void enter(const std::vector<std::filesystem::path>& paths, Replacing replacing);

  /// That which exists; null: none.
  static OutputLedger* current();

 private:
  std::filesystem::path list_;
  std::string run_;
  std::map<std::filesystem::path, std::string> runs_;  ///< by full name
};

}  // namespace mq::app

#pragma once
/// Standard input and standard output in the place of files, for pipes:
///
///     cat photo.png | marquetry filter - --beta 3 -o - > sharp.png
///     curl ... | marquetry filter ply:- -o glb:- | viewer -
///     marquetry batch <(jq ... jobs.json)
///
/// What comes is kept in a temporary file with the extension that its first bytes ask for, or that stands
/// before the hyphen; what goes is written to one first, so that nothing goes where the work fails.

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mq/base/options.h"
#include "mq/io/temporary_folder.h"
#include "shell/run.h"
#include "shell/terminal.h"

namespace mq::app {

class StandardStreams {
 public:
  /// The terminal says "standard input" and "standard output" for the files.
  explicit StandardStreams(Terminal& terminal) : terminal_(terminal) {}
  StandardStreams(const StandardStreams&) = delete;
  StandardStreams& operator=(const StandardStreams&) = delete;

  /// Puts names of files for "-", "FORMAT:-" and pipes among the options that are paths; may be called
  /// again when more is given. What a model that comes so names is looked for in the current folder.
  /// Standard output takes the format of the first input where that is a picture and no other is named.
  /// Throws `InvalidInput` where two options name one stream, where it is a terminal, and where what comes
  /// is in no format that is known; `Cancelled` while it waits.
  void stand_in(OptionValues& options);

  /// Whether results go to standard output, so that nothing else may.
  bool writes() const { return !output_.empty(); }

  /// Sends what was written. Throws `IoError` where nobody takes it.
  void send() const;

  /// A report with what was given, such as "-", for the names of the files.
  Json as_given(Json report) const;

 private:
  const std::filesystem::path& folder();
  std::string read_input(const std::string& given, const std::string& format, const std::string& option);
  void show_current_folder();
  std::string choose_output(const std::string& format, const OptionValues& options);
  void call(const std::string& file, const std::string& given, const std::string& words);

  Terminal& terminal_;
  std::optional<TemporaryFolder> folder_;
  std::filesystem::path output_;
  std::string standard_input_;  ///< the file with what came by it
  bool shows_current_folder_ = false;
  std::vector<std::pair<std::string, std::string>> given_;  ///< texts of reports, and what stands for them
};

/// Throws `InvalidInput` where an option names one, for runs that have none.
void refuse_standard_streams(const OptionValues& options);

}  // namespace mq::app

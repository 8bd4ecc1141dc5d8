#pragma once
/// Sessions without a person: a text file with one command a line, done by the same viewer.
/// docs/view.md lists the commands.

#include <filesystem>
#include <string>
#include <vector>

#include "shell/run.h"
#include "viewer.h"

namespace mq::view {

struct ScriptLine {
  int number = 0;  ///< from 1
  std::vector<std::string> words;
};

class Script {
 public:
  /// Reads a file. Throws `IoError` where it cannot be read, `InvalidInput` naming file and line
  /// where a command is not known or has not as many words as it wants.
  explicit Script(const std::filesystem::path& file);

  /// Does all of it. Throws what a line throws, with file and line before it.
  void play(Viewer& viewer, Session& session) const;

 private:
  std::filesystem::path file_;
  std::vector<ScriptLine> lines_;
};

}  // namespace mq::view

#pragma once
/// A person's choice of files, by the dialog of the desktop: zenity's or kdialog's, whichever there
/// is.

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

#include "file_kind.h"

namespace mq::view {

/// The dialog runs beside the window, which stays alive. One at a time.
class FileChooser {
 public:
  FileChooser() = default;
  ~FileChooser() { close(); }
  FileChooser(const FileChooser&) = delete;
  FileChooser& operator=(const FileChooser&) = delete;

  /// Whether there is a program for it.
  static bool there();

  /// Shows the dialog. Throws `IoError` where it cannot be started.
  void ask(FileKind kind);
  bool open() const { return child_ > 0; }
  /// Once a person has chosen, or chosen nothing: the files. Nothing before.
  std::optional<std::vector<std::string>> chosen();
  /// Ends the dialog.
  void close();

 private:
  pid_t child_ = 0;
  int pipe_ = -1;
  std::string said_;
};

}  // namespace mq::view

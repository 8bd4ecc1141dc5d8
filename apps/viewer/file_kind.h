#pragma once
/// Kinds of files that a person is asked for: what a dialog is called, and what it lists.

#include <filesystem>
#include <string>
#include <vector>

namespace mq::view {

enum class FileKind { models, pictures, cameras };

struct FileKindWords {
  const char* title;    ///< of a dialog
  const char* button;   ///< that takes what is named in it
  const char* files;    ///< what is listed
  bool several;         ///< may be chosen at once
};

const FileKindWords& words_of(FileKind kind);

/// Whether a file, or a folder that stands for files, is of the kind. Folders are cameras where some lie in them.
bool is_of(FileKind kind, const std::filesystem::path& path);

/// "*.obj", "*.ply": for dialogs that ask for patterns.
const std::vector<std::string>& patterns_of(FileKind kind);

}  // namespace mq::view

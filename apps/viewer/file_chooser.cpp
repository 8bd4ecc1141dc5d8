#include "file_chooser.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "mq/base/error.h"

extern char** environ;

namespace mq::view {
namespace {

/// Where a program of this name is, by PATH; empty: nowhere.
std::string found(const std::string& name) {
  const char* const path = std::getenv("PATH");
  std::string folders = path == nullptr ? "" : path;
  for (std::size_t begin = 0; begin <= folders.size();) {
    const std::size_t end = std::min(folders.find(':', begin), folders.size());
    const auto file = std::filesystem::path(folders.substr(begin, end - begin)) / name;
    if (access(file.c_str(), X_OK) == 0) return file.string();
    begin = end + 1;
  }
  return {};
}

/// The program there is for dialogs; empty: none.
std::string program() {
  const std::string zenity = found("zenity");
  return zenity.empty() ? found("kdialog") : zenity;
}

/// The dialog's words, which answers with one file a line.
std::vector<std::string> words(FileKind kind) {
  const FileKindWords& of_kind = words_of(kind);
  const std::string patterns = fmt::format("{}", fmt::join(patterns_of(kind), " "));
  std::vector<std::string> command = {program()};
  if (command.front().ends_with("zenity")) {
    command.insert(command.end(), {"--file-selection", "--separator=\n", std::string("--title=") + of_kind.title,
                                   fmt::format("--file-filter={} | {}", of_kind.files, patterns),
                                   "--file-filter=all files | *"});
    if (of_kind.several) command.emplace_back("--multiple");
  } else {
    command.insert(command.end(), {"--title", of_kind.title});
    if (of_kind.several) command.insert(command.end(), {"--multiple", "--separate-output"});
    command.insert(command.end(), {"--getopenfilename", ".", fmt::format("{} ({})", of_kind.files, patterns)});
  }
  return command;
}

}  // namespace

bool FileChooser::there() { return !program().empty(); }

void FileChooser::ask(FileKind kind) {
  close();
  require(there(), "there is neither zenity nor kdialog: name the file instead");
  std::vector<std::string> command = words(kind);
  int ends[2] = {-1, -1};
  if (pipe2(ends, O_CLOEXEC) != 0) throw IoError(std::string("a dialog cannot be shown: ") + std::strerror(errno));
  std::vector<char*> argv;
  for (std::string& word : command) argv.push_back(word.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  const int failure = posix_spawn(&child_, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  ::close(ends[1]);
  pipe_ = ends[0];
  said_.clear();
  if (failure == 0) return;
  child_ = 0;
  close();
  throw IoError(fmt::format("{}: cannot be started: {}", command[0], std::strerror(failure)));
}

std::optional<std::vector<std::string>> FileChooser::chosen() {
  if (!open()) return std::nullopt;
  for (;;) {
    pollfd waiting{pipe_, POLLIN, 0};
    if (poll(&waiting, 1, 0) <= 0) return std::nullopt;
    char some[4096];
    const ssize_t count = read(pipe_, some, sizeof some);
    if (count <= 0) break;
    said_.append(some, std::size_t(count));
  }
  waitpid(child_, nullptr, 0);
  child_ = 0;
  close();
  std::vector<std::string> files;
  for (std::size_t begin = 0; begin < said_.size();) {
    const std::size_t end = std::min(said_.find('\n', begin), said_.size());
    if (end > begin) files.push_back(said_.substr(begin, end - begin));
    begin = end + 1;
  }
  return files;
}

void FileChooser::close() {
  if (child_ > 0) {
    kill(child_, SIGTERM);
    waitpid(child_, nullptr, 0);
    child_ = 0;
  }
  if (pipe_ >= 0) ::close(pipe_);
  pipe_ = -1;
}

}  // namespace mq::view

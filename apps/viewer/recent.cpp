#include "recent.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <span>

#include "mq/io/atomic_file.h"

namespace mq::view {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most = 8;

fs::path folder() {
  const auto of = [](const char* variable) {
    const char* const value = std::getenv(variable);
    return std::string(value == nullptr ? "" : value);
  };
  if (const std::string state = of("XDG_STATE_HOME"); !state.empty()) return fs::path(state) / "marquetry";
  const std::string home = of("HOME");
  return home.empty() ? fs::path() : fs::path(home) / ".local/state/marquetry";
}

}  // namespace

std::vector<std::string> recent_files() {
  std::vector<std::string> files;
  std::ifstream stream(folder() / "recent");
  for (std::string line; std::getline(stream, line) && files.size() < most;) {
    std::error_code ignored;
    if (!line.empty() && fs::exists(line, ignored)) files.push_back(line);
  }
  return files;
}

void remember(const std::string& file) {
  if (folder().empty() || file.find('\n') != std::string::npos) return;
  const std::string first = fs::absolute(file).lexically_normal().string();
  std::vector<std::string> files = recent_files();
  std::erase(files, first);
  files.insert(files.begin(), first);
  if (files.size() > most) files.resize(most);
  std::string text;
  for (const std::string& one : files) text += one + "\n";
  std::error_code ignored;  // writing says what is wrong
  fs::create_directories(folder(), ignored);
  write_file(folder() / "recent", std::as_bytes(std::span(text.data(), text.size())));
}

}  // namespace mq::view

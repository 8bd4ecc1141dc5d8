#include "cli/program.h"

#include <fcntl.h>
#include <grp.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "places.h"

namespace mq::test {
namespace fs = std::filesystem;

Folder::Folder() {
  std::string name = (fs::temp_directory_path() / "marquetry-test-XXXXXX").string();
  if (!mkdtemp(name.data())) throw std::runtime_error("no temporary folder can be made");
  path_ = name;
}

Folder::~Folder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

std::vector<std::string> Folder::names() const {
  std::vector<std::string> all;
  for (const auto& entry : fs::recursive_directory_iterator(path_))
    all.push_back(fs::relative(entry.path(), path_).string());
  std::ranges::sort(all);
  return all;
}

namespace {

/// In the child: never returns.
[[noreturn]] void become_program(const fs::path& folder, std::vector<std::string> words,
                                 const RunOptions& options, const fs::path& output,
                                 const fs::path& error) {
  const int out = open(output.c_str(), O_WRONLY | O_CREAT, 0600);
  const int err = open(error.c_str(), O_WRONLY | O_CREAT, 0600);
  if (out < 0 || err < 0 || chdir(folder.c_str()) != 0) _exit(126);
  if (!options.standard_input.empty()) dup2(open(options.standard_input.c_str(), O_RDONLY), STDIN_FILENO);
  dup2(out, STDOUT_FILENO);
  dup2(err, STDERR_FILENO);
  for (const auto& [name, value] : options.environment) setenv(name.c_str(), value.c_str(), 1);
  if (options.largest_file > 0) {
    const rlimit limit{rlim_t(options.largest_file), rlim_t(options.largest_file)};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  constexpr uid_t nobody = 65534;
  if (options.user == RunOptions::User::ordinary && geteuid() == 0 &&
      (setgroups(0, nullptr) != 0 || setgid(nobody) != 0 || setuid(nobody) != 0))
    _exit(125);
  words.insert(words.begin(), "marquetry");
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const fs::path program = places::program();
  execv((options.program.empty() ? program : program.parent_path() / options.program).c_str(),
        argv.data());
  _exit(127);
}

/// Interrupts the child once `text` is on its standard error, within two minutes.
void interrupt(pid_t child, const fs::path& error, const std::string& text) {
  using namespace std::chrono_literals;
  for (int i = 0; i < 2400 && file_bytes(error).find(text) == std::string::npos; ++i)
    std::this_thread::sleep_for(50ms);
  kill(child, SIGINT);
}

int wait_for(pid_t child) {
  int status = 0;
  if (waitpid(child, &status, 0) < 0) throw std::runtime_error("the program was lost");
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

Result marquetry(const Folder& folder, const std::vector<std::string>& words,
                 const RunOptions& options) {
  const Folder said;
  const fs::path output =
      options.standard_output.empty() ? said / "output" : fs::path(options.standard_output);
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("the program cannot be started");
  if (child == 0) become_program(folder.path(), words, options, output, said / "error");
  Result result;
  for (const std::string& text : options.interrupt_at) interrupt(child, said / "error", text);
  result.status = wait_for(child);
  if (options.standard_output.empty()) result.output = file_bytes(output);
  result.error = file_bytes(said / "error");
  return result;
}

std::string file_bytes(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream bytes;
  bytes << file.rdbuf();
  return bytes.str();
}

void write_bytes(const fs::path& path, const std::string& bytes) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << bytes;
}

}  // namespace mq::test

// An allocator cannot be changed in a process that runs, so the program starts itself anew, with the module before the C
// library (LD_PRELOAD).
#include "shell/scratch.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <linux/magic.h>
#include <sys/statfs.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>

#include "mq/base/error.h"
#include "mq/io/path_status.h"

namespace mq::app {
namespace {

constexpr const char* module_name = "libmarquetry_scratch.so";
constexpr const char* module_words = "MARQUETRY_SCRATCH";
/// Programs, libraries and small blocks take about 60 MB.
constexpr std::int64_t least_memory = 100'000'000;
/// Below this hardly more stays in memory than what is not in the file.
constexpr std::int64_t little_memory = 200'000'000;
constexpr const char* wanted_memory = "100MB or more, as 8GB, 500MB or 50%";

/// What the last of --name VALUE and --name=VALUE gives.
std::optional<std::string> value_given(const std::vector<std::string>& words, const std::string& name) {
  std::optional<std::string> value;
  for (std::size_t k = 0; k < words.size() && words[k] != "--"; ++k) {
    if (words[k] == name && k + 1 < words.size()) value = words[k + 1];
    if (words[k].starts_with(name + "=")) value = words[k].substr(name.size() + 1);
  }
  return value;
}

bool runs_with_scratch() {
  using Limit = std::uint64_t (*)();
  const auto limit = reinterpret_cast<Limit>(::dlsym(RTLD_DEFAULT, "marquetry_scratch_limit"));
  return limit != nullptr && limit() > 0;
}

std::filesystem::path scratch_folder(const std::vector<std::string>& words) {
  if (const auto given = value_given(words, "--scratch")) return *given;
  const char* usual = std::getenv("TMPDIR");
  return usual != nullptr && *usual != '\0' ? usual : "/var/tmp";
}

/// Of a disk, and there.
void check_folder(const std::filesystem::path& folder) {
  struct statfs system {};
  if (::statfs(folder.c_str(), &system) != 0)
    throw InvalidInput(fmt::format("--scratch: {}: {}; choose a folder you may write to", folder.string(), std::strerror(errno)));
  if (!is_folder(folder))
    throw InvalidInput(fmt::format("--scratch: {} is a file; name a folder on a disk", folder.string()));
  if (::faccessat(AT_FDCWD, folder.c_str(), W_OK | X_OK, AT_EACCESS) != 0)
    throw InvalidInput(fmt::format("--scratch: {}: {}; choose a folder you may write to", folder.string(), std::strerror(errno)));
  if (system.f_type == TMPFS_MAGIC || system.f_type == RAMFS_MAGIC)
    throw InvalidInput(fmt::format("--scratch: {} lies in memory itself (tmpfs); name a folder on a disk", folder.string()));
}

/// The command as the system has it, the program's name first.
std::vector<std::string> typed_words() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::vector<std::string> words;
  for (std::string word; std::getline(file, word, '\0');) words.push_back(word);
  return words;
}

}  // namespace

void add_scratch_options(OptionTable& table) {
  const std::string group = "Running";
  table.add({.name = "memory",
             .type = Option::Type::text,
             .accepts = [](const std::string& words) { return parse_memory(words).has_value(); },
             .wanted = wanted_memory,
             .metavar = "SIZE",
             .group = group,
             .help = "how much memory to use, 8GB or 50%; the rest lies in a file on the disk",
             .details = "The result is the same to the last bit. The file has no name and is gone when the program ends. What "
                        "cannot lie there, libraries and small blocks, takes 100 MB and more.",
             .scope = Option::Scope::run});
  table.add({.name = "scratch",
             .type = Option::Type::path,
             .metavar = "FOLDER",
             .group = group,
             .help = "the folder of that file, on a fast disk; $TMPDIR or /var/tmp where none is given",
             .scope = Option::Scope::run});
}

std::optional<std::int64_t> parse_memory(const std::string& words) {
  const double all = double(::sysconf(_SC_PHYS_PAGES)) * double(::sysconf(_SC_PAGESIZE));
  const std::map<std::string, double> units = {{"MB", 1e6},           {"GB", 1e9},  {"TB", 1e12}, {"MiB", 1048576.0},
                                               {"GiB", 1073741824.0}, {"%", 0.01 * all}};
  double number = 0;
  const char* const end = words.data() + words.size();
  const auto [rest, error] = std::from_chars(words.data(), end, number);
  const auto unit = units.find(std::string(rest, end));
  if (error != std::errc{} || unit == units.end()) return std::nullopt;
  const double bytes = number * unit->second;
  if (!(bytes >= double(least_memory) && bytes <= 1e15)) return std::nullopt;
  return std::int64_t(bytes);
}

void start_with_scratch(const std::vector<std::string>& words) {
  const auto asked = value_given(words, "--memory");
  if (!asked && value_given(words, "--scratch"))
    throw InvalidInput("--scratch is where the file of --memory lies: give that too, such as --memory 8GB");
  if (!asked || runs_with_scratch()) return;
  const std::optional<std::int64_t> bytes = parse_memory(*asked);
  if (!bytes) throw InvalidInput(fmt::format("--memory: found '{}', wanted {}", *asked, wanted_memory));
  const std::filesystem::path folder = scratch_folder(words);
  check_folder(folder);
  if (std::getenv(module_words) != nullptr)
    throw InvalidInput(fmt::format("--scratch: {} cannot have the file that --memory wants: its file system cannot reserve "
                                   "disk, it is full, or addresses are limited (ulimit -v); name another folder",
                                   folder.string()));
  if (::dlopen(module_name, RTLD_LAZY | RTLD_LOCAL) == nullptr)
    throw Unsupported(fmt::format("--memory wants {}: {}; put that of the same build beside the program, or into "
                                  "lib/marquetry beside its bin",
                                  module_name, ::dlerror()));
  ::setenv(module_words, fmt::format("{} {}", *bytes, folder.string()).c_str(), 1);
  ::setenv("LD_PRELOAD", module_name, 1);
  std::vector<std::string> typed = typed_words();
  std::vector<char*> arguments;
  for (std::string& word : typed) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  ::execv("/proc/self/exe", arguments.data());
  throw Unsupported(fmt::format("--memory: the program cannot start itself anew: {}", std::strerror(errno)));
}

void warn_of_little_memory(const OptionValues& options, Messages& messages) {
  if (!options.given("memory") || parse_memory(options.text("memory")).value_or(little_memory) >= little_memory) return;
  messages.warning(fmt::format("--memory: {} is little: libraries and small blocks take 100 MB and more of it, so that what "
                               "is worked on may be read from the disk again and again: give it more if that takes long",
                               options.text("memory")));
}

std::string out_of_memory() {
  return runs_with_scratch() ? "the disk that memory lies on is full: name a folder on a larger one by --scratch, or use "
                               "smaller textures"
                             : "not enough memory: use smaller textures, a machine with more, or --memory 50%, so that the "
                               "rest lies on the disk";
}

}  // namespace mq::app

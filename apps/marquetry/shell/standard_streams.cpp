// Files stand in for the streams: what reads pictures and models wants to look back and forth.
#include "shell/standard_streams.h"

#include <fmt/format.h>
#include <poll.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <optional>
#include <utility>

#include "mq/base/error.h"
#include "mq/io/file_names.h"
#include "shell/interrupt.h"

namespace mq::app {
namespace {

namespace fs = std::filesystem;

const std::string output_stem = "standard_output", folder_begin = "marquetry-pipe-";

/// "" of "-", "ply" of "ply:-"; nothing where a file is named.
std::optional<std::string> stream_format(const std::string& name) {
  if (name == "-") return "";
  if (!name.ends_with(":-")) return {};
  const std::string format = name.substr(0, name.size() - 2);
  const bool is_word = !format.empty() && std::ranges::all_of(format, [](unsigned char c) { return std::isalnum(c); });
  return is_word ? std::optional(format) : std::nullopt;
}

/// Whether what it names is read first of all, and could come by a pipe.
bool takes_standard_input(const Option& option) {
  return option.place == Option::Place::positional || option.name == "config" || option.name == "mask";
}

/// All that comes, into a file. Waits no longer than Ctrl-C.
void copy_standard_input(const fs::path& path) {
  std::ofstream file(path, std::ios::binary);
  std::array<char, 1 << 16> part{};
  for (;;) {
    if (Interrupt::requested()) throw Cancelled();
    pollfd ready{STDIN_FILENO, POLLIN, 0};
    if (::poll(&ready, 1, 100) == 0) continue;
    const ssize_t got = ::read(STDIN_FILENO, part.data(), part.size());
    if (got == 0) break;
    if (got < 0 && errno != EINTR)
      throw IoError(fmt::format("standard input cannot be read: {}", std::strerror(errno)));
    if (got > 0) file.write(part.data(), got);
  }
  file.close();
  if (!file)
    throw IoError(fmt::format("{}: standard input cannot be kept there (is the disk full? TMPDIR names another folder)",
                              path.parent_path().string()));
}

std::string first_bytes(const fs::path& path) {
  std::string bytes(256, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(bytes.data(), std::streamsize(bytes.size()));
  bytes.resize(std::size_t(file.gcount()));
  return bytes;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  if (from.empty()) return text;
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

}  // namespace

bool names_standard_output(const fs::path& path) {
  return path.stem() == output_stem && path.parent_path().filename().string().starts_with(folder_begin);
}

void refuse_standard_streams(const OptionValues& options) {
  for (const Option& option : options.table().options())
    if (option.type == Option::Type::path && options.given(option.name))
      for (const std::string& name : options.texts(option.name))
        require(!stream_format(name),
                fmt::format("{}: '{}' is standard input or output, which are not for this; name a file",
                            display_name(option), name));
}

StandardStreams::~StandardStreams() {
  std::error_code ignored;
  if (!folder_.empty()) fs::remove_all(folder_, ignored);
}

fs::path StandardStreams::folder() {
  if (!folder_.empty()) return folder_;
  std::error_code failure;
  std::string name = (fs::temp_directory_path(failure) / (folder_begin + "XXXXXX")).string();
  if (failure || ::mkdtemp(name.data()) == nullptr)
    throw IoError("no temporary folder can be made for standard input or output: TMPDIR names where");
  return folder_ = name;
}

std::string StandardStreams::read_input(const std::string& format, const std::string& option) {
  require(input_.empty(), option + ": standard input is taken already, by another option or name");
  require(::isatty(STDIN_FILENO) == 0, option + ": standard input is a terminal; pipe a file into it");
  const fs::path bare = folder() / "standard_input";
  copy_standard_input(bare);
  const std::string extension = format.empty() ? extension_by_content(first_bytes(bare)) : "." + format;
  require(fs::file_size(bare) > 0, option + ": nothing came by standard input");
  require(!extension.empty(),
          option + ": what comes by standard input is in no format that shows in its first bytes; name it, such "
                   "as obj:-");
  input_ = bare.string() + extension;
  fs::rename(bare, input_);
  terminal_.rename(input_.string(), "standard input");
  return input_.string();
}

std::string StandardStreams::choose_output(const std::string& format, const OptionValues& options) {
  require(!options.flag("json"), "--json: standard output takes the result; --report FILE writes the same");
  require(::isatty(STDOUT_FILENO) == 0, "--output: standard output is a terminal; send it to a file or a pipe");
  std::string extension = "." + format;
  if (format.empty()) {
    extension.clear();
    for (const Option& option : options.table().options())
      if (option.place == Option::Place::positional && extension.empty() && options.given(option.name))
        if (const fs::path first = options.texts(option.name).front(); names_picture(first))
          extension = lower_extension(first);
    require(!extension.empty(), "--output: name the format that standard output is to take, such as png:- or glb:-");
  }
  output_ = folder() / (output_stem + extension);
  terminal_.rename(output_.string(), "standard output");
  return output_.string();
}

void StandardStreams::stand_in(OptionValues& options) {
  for (const Option& option : options.table().options()) {
    if (option.type != Option::Type::path || option.name == "output" || !options.given(option.name)) continue;
    std::vector<std::string> names = options.texts(option.name);
    bool changed = false;
    for (std::string& name : names)
      if (const std::optional<std::string> format = stream_format(name)) {
        const std::string given = name;
        require(takes_standard_input(option),
                fmt::format("{}: '{}' is standard input or output, which it cannot be; ./- is a file of that name",
                            display_name(option), name));
        name = read_input(*format, display_name(option));
        input_name_ = given;
        changed = true;
      }
    if (changed) options.set(option.name, names);
  }
  const bool has_output = std::ranges::count(options.table().options(), "output", &Option::name) > 0;
  if (!has_output || !options.given("output") || writes()) return;
  if (const std::optional<std::string> format = stream_format(options.text("output"))) {
    output_name_ = options.text("output");
    options.set("output", {choose_output(*format, options)});
    options.set("json", {"true"});  // nothing else is printed
  }
}

void StandardStreams::send() const {
  if (!writes()) return;
  std::ifstream file(output_, std::ios::binary);
  std::array<char, 1 << 16> part{};
  while (file.read(part.data(), std::streamsize(part.size())), file.gcount() > 0)
    if (std::fwrite(part.data(), 1, std::size_t(file.gcount()), stdout) != std::size_t(file.gcount())) break;
}

Json StandardStreams::as_given(Json report) const {
  if (report.is_string()) {
    std::string text = report.get<std::string>();
    for (const auto& [file, name] : {std::pair(output_, output_name_), std::pair(input_, input_name_)})
      text = replaced(replaced(std::move(text), file.string(), name), file.filename().string(), name);
    return text;
  }
  if (report.is_structured())
    for (Json& part : report) part = as_given(std::move(part));
  return report;
}

}  // namespace mq::app

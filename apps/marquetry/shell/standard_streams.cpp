// Files stand in for the streams: what reads pictures and models wants to look back and forth.
#include "shell/standard_streams.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <map>
#include <optional>
#include <utility>

#include "mq/base/error.h"
#include "mq/io/file_names.h"
#include "mq/io/held_files.h"
#include "mq/io/temporary_folder.h"
#include "shell/interrupt.h"

namespace mq::app {
namespace {

namespace fs = std::filesystem;

constexpr int most_links = 10000;

/// "" of "-", "ply" of "ply:-"; nothing where a file is named.
std::optional<std::string> stream_format(const std::string& name) {
  if (name == "-") return "";
  if (!name.ends_with(":-")) return {};
  const std::string format = name.substr(0, name.size() - 2);
  const bool is_word =
      !format.empty() && std::ranges::all_of(format, [](unsigned char c) { return std::isalnum(c); });
  return is_word ? std::optional(format) : std::nullopt;
}

/// The same, and "" of a pipe with a name, such as the shell's <(...) and /dev/stdin.
std::optional<std::string> input_format(const std::string& name) {
  std::error_code ignored;
  return fs::is_fifo(fs::status(name, ignored)) ? "" : stream_format(name);
}

/// Whether what it names is read first of all, and could come by a pipe.
bool takes_standard_input(const Option& option) {
  return option.place == Option::Place::positional || option.name == "config" || option.name == "mask";
}

/// Closed at the end, unless it is standard input.
struct Stream {
  int number = STDIN_FILENO;
  explicit Stream(const std::string& name) {
    if (stream_format(name)) return;
    number = ::open(name.c_str(), O_RDONLY | O_CLOEXEC);
    if (number < 0) throw IoError(fmt::format("{} cannot be read: {}", name, std::strerror(errno)));
  }
  ~Stream() {
    if (number != STDIN_FILENO) ::close(number);
  }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
};

/// What comes next, at most so much; 0: no more will. Waits no longer than Ctrl-C.
std::size_t read_part(const Stream& stream, char* to, std::size_t most) {
  for (;;) {
    if (Interrupt::requested()) throw Cancelled();
    pollfd ready{stream.number, POLLIN, 0};
    if (::poll(&ready, 1, 100) <= 0) continue;
    const ssize_t got = ::read(stream.number, to, most);
    if (got >= 0) return std::size_t(got);
    if (errno != EINTR) throw IoError(fmt::format("standard input cannot be read: {}", std::strerror(errno)));
  }
}

/// The first bytes that come, by which the format is known.
std::string first_bytes(const Stream& stream) {
  std::string bytes(256, '\0');
  std::size_t size = 0;
  while (size < bytes.size()) {
    const std::size_t got = read_part(stream, bytes.data() + size, bytes.size() - size);
    if (got == 0) break;
    size += got;
  }
  bytes.resize(size);
  return bytes;
}

/// `begin` and all that comes after it, into a file.
void keep(const std::string& begin, const Stream& stream, const fs::path& path) {
  std::ofstream file(path, std::ios::binary);
  file.write(begin.data(), std::streamsize(begin.size()));
  std::array<char, 1 << 16> part{};
  while (file) {
    const std::size_t got = read_part(stream, part.data(), part.size());
    if (got == 0) break;
    file.write(part.data(), std::streamsize(got));
  }
  file.close();
  if (!file)
    throw IoError(
        fmt::format("{}: standard input cannot be kept there (is the disk full? TMPDIR names another folder)",
                    path.parent_path().string()));
}

/// What standard output may be told to take, where a verb does not make pictures and models alike.
std::string formats_for(const std::string& verb) {
  static const std::map<std::string, std::string> others = {{"play", "html:-"},
                                                            {"export", "usdz:- or glb:-"},
                                                            {"relight", "mp4:-"},
                                                            {"render", "png:- or exr:-"},
                                                            {"remesh", "ply:- or glb:-"},
                                                            {"unwrap", "ply:- or glb:-"}};
  const auto found = others.find(verb);
  return found == others.end() ? "png:- or glb:-" : found->second;
}

}  // namespace

void refuse_standard_streams(const OptionValues& options) {
  for (const Option& option : options.table().options())
    if (option.type == Option::Type::path && options.given(option.name))
      for (const std::string& name : options.texts(option.name))
        require(!stream_format(name),
                fmt::format("{}: '{}' is standard input or output, which are not for this; name a file",
                            display_name(option), name));
}

const fs::path& StandardStreams::folder() {
  if (!folder_) {
    folder_.emplace(pipe_folder_begin, "standard input and output");
    std::signal(SIGPIPE, SIG_IGN);  // who reads no more may not keep the folder from being removed
  }
  return folder_->path();
}

void StandardStreams::call(const std::string& file, const std::string& given, const std::string& words) {
  given_.emplace_back(file, given);
  terminal_.rename(file, words);
}

/// Names of all that lies there, so that a model finds its pictures and parts.
void StandardStreams::show_current_folder() {
  if (std::exchange(shows_current_folder_, true)) return;
  std::error_code ignored;
  int count = 0;
  for (fs::directory_iterator at(".", ignored), end; !ignored && at != end && count < most_links;
       at.increment(ignored)) {
    std::error_code is_there;
    fs::create_symlink(fs::absolute(at->path()).lexically_normal(), folder() / "in" / at->path().filename(),
                       is_there);
    ++count;
  }
}

std::string StandardStreams::read_input(const std::string& given, const std::string& format,
                                        const std::string& option) {
  const bool is_standard = stream_format(given).has_value();
  if (is_standard) {
    require(standard_input_.empty(), option + ": standard input is taken already, by another option or name");
    require(::isatty(STDIN_FILENO) == 0, option + ": standard input is a terminal; pipe a file into it");
  }
  const Stream stream(given);
  const std::string begin = first_bytes(stream), words = is_standard ? "standard input" : given;
  require(!begin.empty(), fmt::format("{}: nothing came by {}", option, words));
  const std::string extension = format.empty() ? extension_by_content(begin) : "." + format;
  require(!extension.empty(),
          fmt::format(
              "{}: what comes by {} is in no format that shows in its first bytes; name it, such as obj:-",
              option, words));
  fs::create_directory(folder() / "in");
  std::string name = "standard_input" + extension;
  for (int n = 2; fs::exists(folder() / "in" / name); ++n)
    name = fmt::format("standard_input_{}{}", n, extension);
  const fs::path file = folder() / "in" / name;
  keep(begin, stream, file);
  if (is_standard) standard_input_ = file.string();
  call(file.string(), given, words);
  call(name, given, words);
  if (names_model(file) || names_animation(file) || extension == ".evolving") {
    show_current_folder();
    call(file.parent_path().string() + "/", "", "");
    call(file.parent_path().string(), ".", "the current folder");
  }
  return file.string();
}

std::string StandardStreams::choose_output(const std::string& format, const OptionValues& options) {
  require(!options.flag("json"), "--json: standard output takes the result; --report FILE writes the same");
  require(::isatty(STDOUT_FILENO) == 0,
          "--output: standard output is a terminal; send it to a file or a pipe");
  std::string extension = "." + format;
  if (format.empty()) {
    const std::string& verb = options.table().verb();
    require(verb != "track" && verb != "evolve",
            "--output: an evolving mesh is two files, and standard output takes one; name it, such as walk.evolving");
    extension.clear();
    for (const Option& option : options.table().options())
      if (option.place == Option::Place::positional && extension.empty() && options.given(option.name))
        if (const fs::path first = options.texts(option.name).front(); names_picture(first))
          extension = lower_extension(first);
    require(!extension.empty(),
            "--output: name the format that standard output is to take, such as " +
                formats_for(verb));
  }
  output_ = folder() / (standard_output_stem + extension);
  call(output_.string(), options.text("output"), "standard output");
  return output_.string();
}

void StandardStreams::stand_in(OptionValues& options) {
  for (const Option& option : options.table().options()) {
    if (option.type != Option::Type::path || option.name == "output" || !options.given(option.name)) continue;
    std::vector<std::string> names = options.texts(option.name);
    bool changed = false;
    for (std::string& name : names) {
      const bool takes = takes_standard_input(option);
      const std::optional<std::string> format = takes ? input_format(name) : stream_format(name);
      if (!format) continue;
      require(
          takes,
          fmt::format("{}: '{}' is standard input or output, which it cannot be; ./- is a file of that name",
                      display_name(option), name));
      name = read_input(name, *format, display_name(option));
      changed = true;
    }
    if (changed) options.set(option.name, names);
  }
  const bool has_output = std::ranges::count(options.table().options(), "output", &Option::name) > 0;
  if (!has_output || !options.given("output") || writes()) return;
  if (const std::optional<std::string> format = stream_format(options.text("output"))) {
    options.set("output", {choose_output(*format, options)});
    options.set("json", {"true"});  // nothing else is printed
  }
}

void StandardStreams::send() const {
  if (!writes()) return;
  std::ifstream file(output_, std::ios::binary);
  std::array<char, 1 << 16> part{};
  bool is_taken = true;
  while (is_taken && (file.read(part.data(), std::streamsize(part.size())), file.gcount() > 0))
    is_taken = std::fwrite(part.data(), 1, std::size_t(file.gcount()), stdout) == std::size_t(file.gcount());
  if (std::fflush(stdout) != 0 || !is_taken)
    throw IoError(errno == EPIPE ? "standard output: nobody reads it any more"
                                 : "standard output cannot be written to (is the disk full?)");
  terminal_.remark("wrote standard output");
}

Json StandardStreams::as_given(Json report) const {
  if (report.is_string()) {
    std::string text = report.get<std::string>();
    for (const auto& [file, name] : given_) text = replaced(std::move(text), file, name);
    return text;
  }
  if (report.is_structured())
    for (Json& part : report) part = as_given(std::move(part));
  return report;
}

}  // namespace mq::app

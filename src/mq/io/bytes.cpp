#include "mq/io/bytes.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

#include "mq/base/error.h"
#include "mq/io/held_files.h"

namespace mq {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const char* reason, const char* remedy) {
  throw IoError(fmt::format("cannot read {}: {}; {}", path.string(), reason, remedy));
}

/// Closes a file however the reading ends.
struct OpenFile {
  int id;
  ~OpenFile() { ::close(id); }
};

bool blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
bool ends_line(char c) { return c == '\n' || c == '\r'; }

/// std::from_chars says of numbers out of range only that they are: which end of the range?
double out_of_range(std::string_view word) {
  const std::size_t exponent = word.find_first_of("eE");
  const bool tiny = exponent == word.npos ? word.find_first_not_of("-0.") > word.find('.')
                                          : word.substr(exponent + 1).starts_with('-');
  const double size = tiny ? 0 : std::numeric_limits<double>::infinity();
  return word.starts_with('-') ? -size : size;
}

template <class Number>
void append_shortest(std::string& text, Number value) {
  char buffer[40];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  text.append(buffer, end);
}

}  // namespace

Bytes read_file(const std::filesystem::path& path) {
  const int id = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (id < 0)
    fail(path, std::strerror(errno),
         path.native().starts_with(held_scheme) ? "it is held in memory: write it to a file, and name that"
         : errno == ENOENT                      ? "check its name and folder"
                                                : "make it readable, or choose a file you may use");
  const OpenFile file{id};
  struct stat status;
  if (::fstat(id, &status) != 0) fail(path, std::strerror(errno), "check the disk");
  if (S_ISDIR(status.st_mode)) fail(path, "it is a directory", "name a file in it");
  if (!S_ISREG(status.st_mode)) fail(path, "it is not an ordinary file", "copy it to one first");

  Bytes bytes(std::size_t(status.st_size));
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t got = ::read(id, bytes.data() + done, bytes.size() - done);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail(path, std::strerror(errno), "check the disk");
    if (got == 0) break;  // cut while it was read
    done += std::size_t(got);
  }
  bytes.resize(done);
  return bytes;
}

bool to_number(std::string_view word, double& value) {
  if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);
  const char* end = word.data() + word.size();
  const auto result = std::from_chars(word.data(), end, value);
  if (result.ptr != end || word.empty()) return false;
  if (result.ec == std::errc::result_out_of_range) value = out_of_range(word);
  return result.ec != std::errc::invalid_argument;
}

void append_number(std::string& text, double value) { append_shortest(text, value); }
void append_number(std::string& text, float value) { append_shortest(text, value); }

std::string shown(std::string_view text) {
  std::string result = "\"";
  for (const char c : text.substr(0, 60)) result += (c & 0xe0) == 0 || c == 0x7f ? '?' : c;
  return result + (text.size() > 60 ? "...\"" : "\"");
}

/// The place after the line end at `at`, or `at` where the line goes on.
std::size_t Scanner::line_break(std::size_t at) const {
  if (at >= text_.size() || !ends_line(text_[at])) return at;
  return at + (text_.substr(at).starts_with("\r\n") ? 2 : 1);
}

void Scanner::skip_blanks() {
  while (at_ < text_.size()) {
    if (blank(text_[at_])) {
      ++at_;
    } else if (text_[at_] == '\\' && line_break(at_ + 1) != at_ + 1) {
      at_ = line_break(at_ + 1);
    } else {
      return;
    }
  }
}

std::string_view Scanner::word() {
  skip_blanks();
  const std::size_t begin = at_;
  while (at_ < text_.size() && !blank(text_[at_]) && !ends_line(text_[at_]) &&
         !(text_[at_] == '\\' && line_break(at_ + 1) != at_ + 1))
    ++at_;
  return text_.substr(begin, at_ - begin);
}

std::string_view Scanner::rest() {
  while (at_ < text_.size() && blank(text_[at_])) ++at_;
  const std::size_t begin = at_;
  while (at_ < text_.size() && !ends_line(text_[at_])) ++at_;
  std::size_t end = at_;
  while (end > begin && blank(text_[end - 1])) --end;
  return text_.substr(begin, end - begin);
}

void Scanner::next_line() {
  while (at_ < text_.size() && !ends_line(text_[at_])) ++at_;
  at_ = line_break(at_);
}

int Scanner::line(std::string_view text, std::size_t offset) {
  int line = 1;
  const std::size_t end = std::min(offset, text.size());
  for (std::size_t i = 0; i < end; ++i)
    if (text[i] == '\n' || (text[i] == '\r' && !text.substr(i + 1).starts_with('\n'))) ++line;
  return line;
}

Bytes edited(ByteView source, std::vector<Edit> edits) {
  std::stable_sort(edits.begin(), edits.end(),
                   [](const Edit& a, const Edit& b) { return a.begin < b.begin; });
  Bytes result;
  result.reserve(source.size() + 64);
  std::size_t at = 0;
  for (const Edit& edit : edits) {
    result.insert(result.end(), source.begin() + at, source.begin() + edit.begin);
    const ByteView text = bytes_of(edit.text);
    result.insert(result.end(), text.begin(), text.end());
    at = edit.end;
  }
  result.insert(result.end(), source.begin() + at, source.end());
  return result;
}

}  // namespace mq

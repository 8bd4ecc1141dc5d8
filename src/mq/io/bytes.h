#pragma once
/// Bytes of a file, the words and numbers in them, and changes to them that leave the rest alone.

#include <cstddef>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace mq {

using Bytes = std::vector<std::byte>;
using ByteView = std::span<const std::byte>;

/// The whole file. Throws `IoError` when it is missing, a directory, not an ordinary file or may
/// not be read.
Bytes read_file(const std::filesystem::path& path);

inline std::string_view text_of(ByteView bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}
inline ByteView bytes_of(std::string_view text) { return std::as_bytes(std::span(text)); }
inline Bytes to_bytes(std::string_view text) {
  const ByteView view = bytes_of(text);
  return {view.begin(), view.end()};
}

/// Appends a number as it lies in memory (files are little-endian, as the machines we build for are).
template <class Number>
void append_raw(Bytes& bytes, Number number) {
  const std::size_t end = bytes.size();
  bytes.resize(end + sizeof number);
  std::memcpy(bytes.data() + end, &number, sizeof number);
}

/// The number that `word` spells from its first to its last character, in any locale. What is
/// nearer to zero than the smallest double is zero, what is beyond the largest infinite.
/// False when it is not a number.
bool to_number(std::string_view word, double& value);

/// The shortest spelling that reads back as the same number.
void append_number(std::string& text, double value);
void append_number(std::string& text, float value);

/// `text` for a message: cut after 60 characters, what cannot be printed as '?'.
std::string shown(std::string_view text);

/// A cursor over lines of words. A blank, a tab or a backslash at the end of a line separates
/// words; a line ends at LF, CR LF or CR.
class Scanner {
 public:
  explicit Scanner(std::string_view text, std::size_t offset = 0) : text_(text), at_(offset) {}

  bool at_end() const { return at_ >= text_.size(); }
  std::size_t offset() const { return at_; }

  /// The next word of this line, empty where there is none left.
  std::string_view word();

  /// What is left of this line, not continued, without blanks at its ends.
  std::string_view rest();

  /// Goes to the start of the next line.
  void next_line();

  /// The number of the line that holds `offset`, from 1.
  static int line(std::string_view text, std::size_t offset);

 private:
  void skip_blanks();
  std::size_t line_break(std::size_t at) const;

  std::string_view text_;
  std::size_t at_ = 0;
};

/// A range of bytes to replace.
struct Edit {
  std::size_t begin = 0;
  std::size_t end = 0;
  std::string text;
};

/// `source` with the edits made, which may come in any order but must not overlap. Of two
/// insertions at one place the first given comes first.
Bytes edited(ByteView source, std::vector<Edit> edits);

}  // namespace mq

#pragma once
/// JSON as a user gives it: what is wrong with it is said by file, line and column.

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "mq/io/detail/json_text.h"

namespace mq {

/// "FILE, line 3, column 12", both from 1, of a byte of the text; columns count characters.
std::string text_place(const std::string& file, std::string_view text, std::size_t offset);

/// The same of the value that `steps` lead to, or of the last value on the way that there is. `text`
/// must be valid JSON.
std::string json_place(const std::string& file, std::string_view text,
                       const std::vector<JsonStep>& steps);

/// Throws `IoError` with the place at which `text`, which a parser refused so, is no JSON. `wanted`
/// says what the file should be.
[[noreturn]] void refuse_json(const std::string& file, std::string_view text,
                              const std::string& wanted, const nlohmann::detail::exception& error);

/// Throws `IoError` with the place at which `text` goes too deep (`most_json_levels`), if it does.
void refuse_deep_json(const std::string& file, std::string_view text);

/// The document in `text`, as `nlohmann::json` or `nlohmann::ordered_json`; refused as above.
template <class Json = nlohmann::json>
Json parse_json(const std::string& file, std::string_view text, const std::string& wanted) {
  refuse_deep_json(file, text);
  try {
    return Json::parse(text);
  } catch (const nlohmann::detail::exception& error) {
    refuse_json(file, text, wanted, error);
  }
}

/// A file of JSON, to be read with `JsonObject`.
struct JsonFile {
  std::string file;
  std::string_view text;  ///< must outlive it
  nlohmann::json document;
};

/// An object in a file. Members that are not there, or not what was asked for, are refused with an
/// `IoError`: the place, what was found, what was wanted.
class JsonObject {
 public:
  /// The document itself, which must be an object and outlive this; refused with `wanted`.
  JsonObject(const JsonFile& file, const std::string& wanted);

  bool has(const std::string& name) const { return value_->contains(name); }

  /// A finite number; `otherwise` where the member is left out.
  double number(const std::string& name) const;
  double number(const std::string& name, double otherwise) const;

  /// A whole number in [least, most].
  int whole(const std::string& name, int least, int most) const;
  std::string text(const std::string& name) const;
  bool truth(const std::string& name) const;  ///< true or false

  /// So many numbers; so many rows of them, one after another.
  std::vector<double> numbers(const std::string& name, std::size_t count) const;
  std::vector<double> rows(const std::string& name, std::size_t count, std::size_t columns) const;

  /// As many rows as there are.
  std::vector<double> rows(const std::string& name, std::size_t columns) const;

  /// A list of objects.
  std::vector<JsonObject> objects(const std::string& name) const;

  /// Refuses a member of another name: what is misspelt would be as if it were not there.
  void require_only(const std::vector<std::string>& names) const;

  /// "FILE, line 3, column 12: cameras[0]", where it begins.
  std::string place() const;

 private:
  JsonObject(const JsonFile& file, const nlohmann::json& value, std::vector<JsonStep> steps);
  std::vector<double> rows_of(const std::string& name, const nlohmann::json& value, std::size_t columns) const;
  const nlohmann::json& member(const std::string& name, const std::string& wanted) const;
  [[noreturn]] void refuse(const std::vector<JsonStep>& below, const nlohmann::json& found,
                           const std::string& wanted) const;

  const JsonFile* file_;
  const nlohmann::json* value_;
  std::vector<JsonStep> steps_;
};

}  // namespace mq

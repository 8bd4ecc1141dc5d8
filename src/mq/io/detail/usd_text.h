#pragma once
/// The text of a USD layer (Pixar, "Usda File Format"): its prims and what their properties are set to. Values
/// are found and left as text, so that of a long sequence one frame at a time becomes numbers.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace mq {

/// What a property has at a time code.
struct UsdSample {
  double time = 0;
  std::string_view value;  ///< empty: from here on it has none (None)
};

/// An attribute or a relationship (`type` is "rel").
struct UsdProperty {
  std::string_view type, name;     ///< "point3f[]", "points"
  std::string_view value;          ///< empty: none is set, or it is blocked (None)
  std::vector<UsdSample> samples;  ///< by increasing time
  std::string_view connection;     ///< of `NAME.connect = <PATH>`
  std::string_view metadata;       ///< between parentheses, these too; empty: none
  bool has_spline = false;         ///< that it changes by, which is not read
};

struct UsdPrim {
  std::string_view specifier, type, name;  ///< "def", "Mesh", "body"; none of these: the layer itself
  std::string_view metadata;
  std::vector<UsdProperty> properties;
  std::vector<UsdPrim> children;
  bool has_variants = false;  ///< of which none is read

  /// Null where there is none of that name.
  const UsdProperty* property(std::string_view name) const;
  const UsdPrim* child(std::string_view name) const;
};

/// How deep prims may lie in each other: what handles them calls itself for each.
inline constexpr int most_usd_levels = 256;

class UsdText {
 public:
  /// Reads the layer in `text`, which must outlive this, as every view does. Throws `IoError` with file and
  /// line where the text is no layer, or is cut short.
  UsdText(std::string file, std::string_view text);

  const UsdPrim& layer() const { return layer_; }
  const std::string& file() const { return file_; }

  /// Numbers of a value, tuples of `size` (1: plain numbers) in a list, one after another. Throws `IoError`
  /// with the line where it is something else, or one is not finite.
  std::vector<double> tuples(std::string_view value, int size) const;
  std::vector<int> integers(std::string_view value) const;

  /// All numbers of a value that is no list, whatever brackets are around them.
  std::vector<double> numbers(std::string_view value) const;

  /// The unquoted items of a list of words, such as ["a", "b"].
  std::vector<std::string_view> words(std::string_view value) const;

  /// The paths that a relationship or a connection of the prim at `prim` leads to, from the root on: as they are
  /// written, </Looks/skin>, or from the prim, <../Looks/skin> and <.inputs:set>; one, or a list.
  std::vector<std::string> targets(std::string_view value, const std::string& prim) const;

  /// The prim at a path from the root, of a property that it has it; null: there is none.
  const UsdPrim* prim_at(std::string_view path) const;

  /// What metadata, of a prim or a property, say by that name; empty: nothing.
  std::string_view member(std::string_view metadata, std::string_view name) const;

  /// Throws `IoError`: "FILE, line N: WHAT", of the line that `place`, a part of the text, begins in.
  [[noreturn]] void fail(std::string_view place, const std::string& what) const;

 private:
  std::string file_;
  std::string_view text_;
  UsdPrim layer_;
};

/// A path as it is written by the prim at `prim`, from the root on.
std::string usd_absolute(std::string_view path, std::string prim);

/// "word" of `"word"`, `'word'`, `@word@` and `<word>`, with their longer marks (""", @@@); as it is otherwise.
std::string_view usd_unquoted(std::string_view value);

}  // namespace mq

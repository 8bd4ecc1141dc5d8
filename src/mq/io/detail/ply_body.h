#pragma once
/// The values behind a PLY header, one after the other, whatever their encoding.

#include <bit>
#include <cstring>
#include <vector>

#include "mq/io/detail/ply.h"

namespace mq {

/// Bytes of a binary value.
constexpr int size_of(PlyType type) {
  constexpr int sizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return sizes[int(type)];
}

constexpr bool is_integer(PlyType type) { return type < PlyType::f32; }

/// A value and the bytes that say it.
struct PlyValue {
  double value = 0;
  std::size_t begin = 0;
  std::size_t end = 0;
};

class PlyReader {
 public:
  PlyReader(ByteView bytes, const PlyHeader& header, const std::string& name)
      : bytes_(bytes), encoding_(header.encoding), name_(name), at_(header.body) {}

  std::size_t offset() const { return at_; }

  /// The row that messages speak of.
  void set_place(const PlyElement& element, std::int64_t row) {
    element_ = &element;
    row_ = row;
  }

  PlyValue value(PlyType type) {
    if (encoding_ == PlyHeader::Encoding::text) return word();
    const std::size_t size = std::size_t(size_of(type));
    if (bytes_.size() - at_ < size) fail("the file ends there; it may be cut short");
    const PlyValue result{binary(type, bytes_.data() + at_), at_, at_ + size};
    at_ += size;
    return result;
  }

  /// The values of a list; how many is checked against what is left of the file.
  void list(const PlyProperty& property, std::vector<PlyValue>& values);

  /// Passes over the values of a row from property `first` on.
  void skip(const PlyElement& element);

  /// Says where in the file and throws `IoError`.
  [[noreturn]] void fail(const std::string& what) const;

 private:
  PlyValue word();
  double binary(PlyType type, const std::byte* from) const;

  ByteView bytes_;
  PlyHeader::Encoding encoding_;
  const std::string& name_;
  std::size_t at_;
  const PlyElement* element_ = nullptr;
  std::int64_t row_ = 0;
};

/// The bytes of `value` in the type and encoding; as text the shortest spelling that reads back.
std::string encoded(double value, PlyType type, PlyHeader::Encoding encoding);

/// What the properties of vertices and faces mean; −1 where there is none. Of several sets of texture
/// coordinates the one that is asked for counts; of none (−1) those of corners, and where a face has
/// none of these, the first of vertices.
struct PlyRoles {
  explicit PlyRoles(const PlyHeader& header, int uv_set = -1);

  const PlyElement* vertex = nullptr;
  const PlyElement* face = nullptr;
  int position[3] = {-1, -1, -1};
  int color[4] = {-1, -1, -1, -1};
  int uv[2] = {-1, -1};
  int normal[3] = {-1, -1, -1};  ///< all or none
  int indices = -1;
  int corner_uvs = -1;
  int texture = -1;
  int uv_sets = 0;  ///< lists texcoord, texcoord1, ... of faces, then pairs of vertices

  int channels() const {
    if (color[0] < 0 || color[1] < 0 || color[2] < 0) return 0;
    return color[3] < 0 ? 3 : 4;
  }
  /// A colour's largest stored value: 1 for floats, 0 for a type that holds no colours.
  double color_scale() const;
  Depth color_depth() const;

 private:
  void find_uv_sets(int wanted);
};

}  // namespace mq

#include "mq/io/detail/ply_body.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"

namespace mq {
namespace {

bool space(std::byte b) {
  const char c = char(b);
  return c == ' ' || (c >= '\t' && c <= '\r');
}

template <class Number>
double load(const std::byte* from, bool swapped) {
  std::byte raw[sizeof(Number)];
  std::memcpy(raw, from, sizeof raw);
  if (swapped) std::reverse(raw, raw + sizeof raw);
  Number number;
  std::memcpy(&number, raw, sizeof raw);
  return double(number);
}

template <class Number>
std::string store(double value, bool swapped) {
  if constexpr (std::is_integral_v<Number>) {
    value = std::clamp(std::round(value), double(std::numeric_limits<Number>::min()),
                       double(std::numeric_limits<Number>::max()));
  }
  const Number number = Number(value);
  std::string raw(sizeof number, '\0');
  std::memcpy(raw.data(), &number, sizeof number);
  if (swapped) std::reverse(raw.begin(), raw.end());
  return raw;
}

bool is_swapped(PlyHeader::Encoding encoding) {
  return (encoding == PlyHeader::Encoding::big_endian) ==
         (std::endian::native == std::endian::little);
}

int find(const PlyElement& element, std::initializer_list<const char*> names, bool list) {
  for (const char* name : names)
    for (std::size_t i = 0; i < element.properties.size(); ++i)
      if (element.properties[i].name == name &&
          element.properties[i].count_type.has_value() == list)
        return int(i);
  return -1;
}

}  // namespace

void PlyReader::fail(const std::string& what) const {
  throw IoError(fmt::format("{}, {} {} (byte {}): {}", name_, element_ ? element_->name : "element",
                            row_, at_, what));
}

PlyValue PlyReader::word() {
  while (at_ < bytes_.size() && space(bytes_[at_])) ++at_;
  const std::size_t begin = at_;
  while (at_ < bytes_.size() && !space(bytes_[at_])) ++at_;
  if (begin == at_) fail("the file ends there; it may be cut short");
  double value = 0;
  const std::string_view text = text_of(bytes_.subspan(begin, at_ - begin));
  if (!to_number(text, value)) fail(fmt::format("{} is not a number", shown(text)));
  return {value, begin, at_};
}

double PlyReader::binary(PlyType type, const std::byte* from) const {
  const bool swapped = is_swapped(encoding_);
  switch (type) {
    case PlyType::i8: return load<std::int8_t>(from, swapped);
    case PlyType::u8: return load<std::uint8_t>(from, swapped);
    case PlyType::i16: return load<std::int16_t>(from, swapped);
    case PlyType::u16: return load<std::uint16_t>(from, swapped);
    case PlyType::i32: return load<std::int32_t>(from, swapped);
    case PlyType::u32: return load<std::uint32_t>(from, swapped);
    case PlyType::f32: return load<float>(from, swapped);
    case PlyType::f64: return load<double>(from, swapped);
  }
  return 0;
}

void PlyReader::list(const PlyProperty& property, std::vector<PlyValue>& values) {
  const double count = value(*property.count_type).value;
  const double left = double(bytes_.size() - at_);
  const double least = encoding_ == PlyHeader::Encoding::text ? 1 : size_of(property.type);
  if (!(count >= 0) || count != std::floor(count))
    fail(fmt::format("list {} has {} values; it needs a count", property.name, count));
  if (count * least > left)
    fail(fmt::format("list {} has {} values, more than are left in the file; it may be cut short",
                     property.name, count));
  values.resize(std::size_t(count));
  for (PlyValue& v : values) v = value(property.type);
}

void PlyReader::skip(const PlyElement& element) {
  std::vector<PlyValue> values;
  for (const PlyProperty& property : element.properties) {
    if (property.count_type) {
      list(property, values);
    } else {
      value(property.type);
    }
  }
}

std::string encoded(double value, PlyType type, PlyHeader::Encoding encoding) {
  if (encoding == PlyHeader::Encoding::text) {
    std::string text;
    if (is_integer(type)) value = std::round(value);
    if (type == PlyType::f32 && double(float(value)) == value) {
      append_number(text, float(value));
    } else {
      append_number(text, value);
    }
    return text;
  }
  const bool swapped = is_swapped(encoding);
  switch (type) {
    case PlyType::i8: return store<std::int8_t>(value, swapped);
    case PlyType::u8: return store<std::uint8_t>(value, swapped);
    case PlyType::i16: return store<std::int16_t>(value, swapped);
    case PlyType::u16: return store<std::uint16_t>(value, swapped);
    case PlyType::i32: return store<std::int32_t>(value, swapped);
    case PlyType::u32: return store<std::uint32_t>(value, swapped);
    case PlyType::f32: return store<float>(value, swapped);
    case PlyType::f64: return store<double>(value, swapped);
  }
  return {};
}

PlyRoles::PlyRoles(const PlyHeader& header, int uv_set) {
  for (const PlyElement& element : header.elements) {
    if (element.name == "vertex") vertex = &element;
    if (element.name == "face") face = &element;
  }
  if (vertex) {
    position[0] = find(*vertex, {"x"}, false);
    position[1] = find(*vertex, {"y"}, false);
    position[2] = find(*vertex, {"z"}, false);
    color[0] = find(*vertex, {"red", "r", "diffuse_red"}, false);
    color[1] = find(*vertex, {"green", "g", "diffuse_green"}, false);
    color[2] = find(*vertex, {"blue", "b", "diffuse_blue"}, false);
    color[3] = find(*vertex, {"alpha", "a", "diffuse_alpha"}, false);
    if (color_scale() == 0) std::fill(color, color + 4, -1);
    normal[0] = find(*vertex, {"nx", "normal_x"}, false);
    normal[1] = find(*vertex, {"ny", "normal_y"}, false);
    normal[2] = find(*vertex, {"nz", "normal_z"}, false);
    if (*std::min_element(normal, normal + 3) < 0) std::fill(normal, normal + 3, -1);
  }
  if (face) {
    indices = find(*face, {"vertex_indices", "vertex_index"}, true);
    texture = find(*face, {"texnumber"}, false);
  }
  find_uv_sets(uv_set);
}

void PlyRoles::find_uv_sets(int wanted) {
  const bool any = wanted < 0;
  for (int i = 0; face; ++i) {
    const std::string name = i == 0 ? "texcoord" : fmt::format("texcoord{}", i);
    const int list = find(*face, {name.c_str()}, true);
    if (list < 0) break;
    if ((any && uv_sets == 0) || uv_sets == wanted) corner_uvs = list;
    ++uv_sets;
  }
  constexpr const char* pairs[][2] = {{"texture_u", "texture_v"},
                                      {"texture_s", "texture_t"},
                                      {"s", "t"},
                                      {"u", "v"},
                                      {"u0", "v0"},
                                      {"s0", "t0"},
                                      {"u1", "v1"},
                                      {"s1", "t1"},
                                      {"u2", "v2"},
                                      {"s2", "t2"}};
  for (const auto& pair : pairs) {
    const int first = vertex ? find(*vertex, {pair[0]}, false) : -1;
    const int second = vertex ? find(*vertex, {pair[1]}, false) : -1;
    if (first < 0 || second < 0) continue;
    if ((any && uv[0] < 0) || uv_sets == wanted) uv[0] = first, uv[1] = second;
    ++uv_sets;
  }
}

double PlyRoles::color_scale() const {
  if (channels() == 0) return 0;
  const PlyType type = vertex->properties[std::size_t(color[0])].type;
  for (int c = 1; c < channels(); ++c)
    if (vertex->properties[std::size_t(color[c])].type != type) return 0;
  if (type == PlyType::u8) return 255;
  if (type == PlyType::u16) return 65535;
  return is_integer(type) ? 0 : 1;
}

Depth PlyRoles::color_depth() const {
  const double scale = color_scale();
  return scale == 255 ? Depth::u8 : scale == 65535 ? Depth::u16 : Depth::f32;
}

}  // namespace mq

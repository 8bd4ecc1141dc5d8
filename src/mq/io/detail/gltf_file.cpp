#include "mq/io/detail/gltf_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <climits>
#include <cmath>
#include <cstring>
#include <set>

#include "mq/base/error.h"
#include "mq/io/detail/gltf.h"
#include "mq/io/detail/gltf_draco.h"
#include "mq/io/detail/gltf_meshopt.h"
#include "mq/io/json_read.h"
#include "mq/io/uri.h"

namespace mq {
namespace {

static_assert(std::endian::native == std::endian::little, "glTF is read as it lies in memory");

template <class Number>
Number load_number(const std::byte* from) {
  Number number;
  std::memcpy(&number, from, sizeof number);
  return number;
}

[[noreturn]] void wrong(const std::string& place, const char* key, const char* wanted) {
  throw IoError(fmt::format("{}: {} is not {}", place, key, wanted));
}

GltfType component_type(const Json& object, const std::string& place) {
  const std::int64_t type = json_count(object, "componentType", 0, place);
  if (type < 5120 || type > 5126 || type == 5124) wrong(place, "componentType", "a type of glTF");
  return GltfType(type);
}

int component_count(const Json& accessor, const std::string& place) {
  const std::string type = json_text_of(accessor, "type");
  if (type == "SCALAR") return 1;
  if (type == "VEC2") return 2;
  if (type == "VEC3") return 3;
  if (type == "VEC4") return 4;
  wrong(place, "type", "SCALAR, VEC2, VEC3 or VEC4");
}

/// Integers of an accessor that says so stand for −1 to 1.
void normalize(const Json& accessor, GltfValues& values) {
  const auto normalized = accessor.find("normalized");
  values.normalized = normalized != accessor.end() && normalized->is_boolean() &&
                      normalized->get<bool>() && values.type != GltfType::f32;
  if (values.normalized)
    for (double& value : values.values) value = std::max(value / largest_of(values.type), -1.0);
}

}  // namespace

double load_component(GltfType type, const std::byte* from) {
  switch (type) {
    case GltfType::i8: return load_number<std::int8_t>(from);
    case GltfType::u8: return load_number<std::uint8_t>(from);
    case GltfType::i16: return load_number<std::int16_t>(from);
    case GltfType::u16: return load_number<std::uint16_t>(from);
    case GltfType::u32: return load_number<std::uint32_t>(from);
    case GltfType::f32: return load_number<float>(from);
  }
  return 0;
}

int size_of(GltfType type) {
  if (type == GltfType::i8 || type == GltfType::u8) return 1;
  return type == GltfType::i16 || type == GltfType::u16 ? 2 : 4;
}

double largest_of(GltfType type) {
  switch (type) {
    case GltfType::i8: return 127;
    case GltfType::u8: return 255;
    case GltfType::i16: return 32767;
    case GltfType::u16: return 65535;
    case GltfType::u32: return 4294967295.0;
    case GltfType::f32: return 1;
  }
  return 1;
}

// ---- Members of JSON objects ----

std::int64_t json_count(const Json& object, const char* key, std::int64_t otherwise,
                        const std::string& place) {
  const auto found = object.find(key);
  if (found == object.end()) return otherwise;
  if (!found->is_number()) wrong(place, key, "a number");
  const double value = found->get<double>();
  if (!(value >= 0) || value > 9e15 || value != std::floor(value))
    wrong(place, key, "a whole number from 0");
  return std::int64_t(value);
}

double json_number(const Json& object, const char* key, double otherwise,
                   const std::string& place) {
  const auto found = object.find(key);
  if (found == object.end()) return otherwise;
  if (!found->is_number() || !std::isfinite(found->get<double>())) wrong(place, key, "a number");
  return found->get<double>();
}

std::vector<double> json_numbers(const Json& object, const char* key, std::vector<double> otherwise,
                                 const std::string& place) {
  const auto found = object.find(key);
  if (found == object.end()) return otherwise;
  const std::string wanted = fmt::format("an array of {} numbers", otherwise.size());
  if (!found->is_array() || found->size() != otherwise.size()) wrong(place, key, wanted.c_str());
  for (std::size_t i = 0; i < otherwise.size(); ++i) {
    const Json& value = (*found)[i];
    if (!value.is_number() || !std::isfinite(value.get<double>()))
      wrong(place, key, wanted.c_str());
    otherwise[i] = value.get<double>();
  }
  return otherwise;
}

const Json* json_object(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_object() ? &*found : nullptr;
}

const Json& json_array(const Json& object, const char* key, const std::string& place) {
  static const Json none = Json::array();
  const auto found = object.find(key);
  if (found == object.end()) return none;
  if (!found->is_array()) wrong(place, key, "an array");
  return *found;
}

std::string json_text_of(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

// ---- The file ----

GltfFile::GltfFile(const Document& document) : document_(document) {
  if (document.format == Document::Format::glb) {
    open_glb();
  } else {
    json_text_ = text_of(document.bytes);
    if (json_text_.starts_with("\xef\xbb\xbf")) json_text_.remove_prefix(3);
  }
  parse_json();
}

GltfFile::~GltfFile() = default;

void GltfFile::fail(const std::string& place, const std::string& what) {
  throw IoError(place + ": " + what);
}

std::string GltfFile::place(const char* array, std::int64_t index) const {
  return fmt::format("{}, {}[{}]", document_.name, array, index);
}

void GltfFile::open_glb() {
  const ByteView bytes = document_.bytes;
  const auto word = [&](std::size_t at) { return load_number<std::uint32_t>(bytes.data() + at); };
  if (bytes.size() < 20)
    fail(document_.name + ", header", "the file ends there; it may be cut short");
  if (word(4) != 2)
    fail(document_.name + ", header",
         fmt::format("GLB of version {}; write it as version 2 first", word(4)));
  if (word(8) > bytes.size())
    fail(document_.name + ", header",
         fmt::format("it should have {} bytes but has {}; it may be cut short", word(8),
                     bytes.size()));
  for (std::size_t at = 12; at + 8 <= bytes.size();) {
    const std::size_t length = word(at), type = word(at + 4);
    if (length > bytes.size() - at - 8)
      fail(fmt::format("{}, chunk at byte {}", document_.name, at), "it is longer than the file");
    const ByteView chunk = bytes.subspan(at + 8, length);
    if (at == 12 && type != 0x4e4f534a)
      fail(document_.name + ", header", "the first chunk is not JSON");
    if (at == 12) json_text_ = text_of(chunk);
    if (type == 0x004e4942 && !chunk_) chunk_ = chunk;
    at += 8 + length;
  }
}

void GltfFile::parse_json() {
  json_ = mq::parse_json(document_.name, json_text_, "glTF");
  if (!json_.is_object() || !json_object(json_, "asset"))
    throw IoError(document_.name + " is not glTF: its JSON has no asset");
  const std::string version = json_text_of(json_["asset"], "version");
  if (!version.starts_with("2."))
    fail(document_.name + ", asset",
         fmt::format("version {} is not 2.0; write it as glTF 2.0 first", shown(version)));
  buffers_.resize(size("buffers"));
}

std::size_t GltfFile::size(const char* array) const {
  return json_array(json_, array, document_.name).size();
}

const Json& GltfFile::item(const char* array, std::int64_t index) const {
  const Json& items = json_array(json_, array, document_.name);
  const std::string at = place(array, index);
  if (index < 0 || index >= std::int64_t(items.size()))
    fail(at, fmt::format("it is not there, {} are", items.size()));
  if (!items[std::size_t(index)].is_object()) fail(at, "it is not an object");
  return items[std::size_t(index)];
}

std::string GltfFile::buffer_name(std::size_t b) const {
  const std::string uri = json_text_of(item("buffers", std::int64_t(b)), "uri");
  return uri.starts_with("data:") ? "" : name_of_uri(uri);
}

Bytes GltfFile::load_buffer(int b) const {
  const std::string at = place("buffers", b);
  const std::string uri = json_text_of(item("buffers", b), "uri");
  if (uri.starts_with("data:")) {
    auto bytes = data_of_uri(uri);
    if (!bytes) fail(at, "its data URI is not base64");
    return std::move(*bytes);
  }
  if (uri.empty()) fail(at, "it has neither a name nor data");
  fail(at,
       fmt::format("its file {} is not there; put it beside the model", shown(name_of_uri(uri))));
}

ByteView GltfFile::buffer(int b) const {
  const std::string at = place("buffers", b);
  const Json& object = item("buffers", b);
  std::optional<ByteView> bytes;
  if (b == 0 && chunk_ && !object.contains("uri")) bytes = chunk_;
  for (const Part& part : document_.parts)
    if (!bytes && !buffer_name(std::size_t(b)).empty() && part.name == buffer_name(std::size_t(b)))
      bytes = ByteView(part.bytes);
  if (!bytes) {
    std::optional<Bytes>& loaded = buffers_[std::size_t(b)];
    if (!loaded) loaded = load_buffer(b);
    bytes = ByteView(*loaded);
  }
  const std::int64_t length = json_count(object, "byteLength", 0, at);
  if (length > std::int64_t(bytes->size()))
    fail(at, fmt::format("it should have {} bytes but has {}; it may be cut short", length,
                         bytes->size()));
  return bytes->first(std::size_t(length));
}

bool GltfFile::is_fallback(std::int64_t b) const {
  const Json* extensions = json_object(item("buffers", b), "extensions");
  for (const char* name : {"EXT_meshopt_compression", "KHR_meshopt_compression"})
    if (const Json* extension = extensions ? json_object(*extensions, name) : nullptr)
      if (const auto found = extension->find("fallback");
          found != extension->end() && found->is_boolean() && found->get<bool>())
        return true;
  return false;
}

/// Of a view or of its extension, which say it in the same words.
GltfView GltfFile::region(const Json& object, const std::string& at) const {
  GltfView view;
  view.buffer = int(std::min<std::int64_t>(json_count(object, "buffer", INT_MAX, at), INT_MAX));
  view.offset = std::size_t(json_count(object, "byteOffset", 0, at));
  view.length = std::size_t(json_count(object, "byteLength", 0, at));
  view.stride = std::size_t(json_count(object, "byteStride", 0, at));
  const std::size_t size = buffer(view.buffer).size();
  if (view.offset > size || view.length > size - view.offset)
    fail(at, fmt::format("bytes {} to {} of a buffer of {}", view.offset, view.offset + view.length,
                         size));
  return view;
}

std::optional<GltfView> GltfFile::stored_view(std::int64_t index) const {
  const Json& object = item("bufferViews", index);
  const std::string at = place("bufferViews", index);
  if (is_fallback(json_count(object, "buffer", INT_MAX, at))) return {};
  return region(object, at);
}

std::optional<GltfView> GltfFile::compressed_view(std::int64_t index) const {
  const auto [extension, name] = meshopt_of(item("bufferViews", index));
  if (!extension) return {};
  return region(*extension, fmt::format("{}.{}", place("bufferViews", index), name));
}

GltfView GltfFile::view(std::int64_t index) const {
  const Json& object = item("bufferViews", index);
  const std::string at = place("bufferViews", index);
  const auto [extension, name] = meshopt_of(object);
  if (!extension) return region(object, at);
  auto known = meshopt_.find(index);
  if (known == meshopt_.end())
    known = meshopt_.emplace(index, decode_meshopt(*extension, bytes(*compressed_view(index)), at)).first;
  return {-1, 0, known->second.size(), std::size_t(json_count(object, "byteStride", 0, at)), index};
}

ByteView GltfFile::bytes(const GltfView& view) const {
  if (view.decoded >= 0) return meshopt_.at(view.decoded);
  return buffer(view.buffer).subspan(view.offset, view.length);
}

void GltfFile::load(const GltfView& view, std::size_t offset, std::size_t count, int components,
                    GltfType type, const std::string& place, double* to) const {
  const std::size_t element = std::size_t(components * size_of(type));
  const std::size_t stride = view.stride ? view.stride : element;
  const ByteView from = bytes(view);
  if (count == 0) return;
  if (offset > from.size() || element > from.size() - offset ||
      (count - 1) > (from.size() - offset - element) / stride)
    fail(place, fmt::format("its {} elements reach beyond its buffer view", count));
  for (std::size_t i = 0; i < count; ++i)
    for (int c = 0; c < components; ++c)
      *to++ =
          load_component(type, from.data() + offset + i * stride + std::size_t(c * size_of(type)));
}

GltfValues GltfFile::decoded_values(std::size_t number, std::initializer_list<int> wanted) const {
  const GltfValues& values = decoded_[number].values;
  if (std::find(wanted.begin(), wanted.end(), values.components) == wanted.end())
    fail(document_.name, fmt::format("{} components decoded by Draco do not fit their use",
                                     values.components));
  return values;
}

GltfValues GltfFile::values(std::int64_t accessor, std::initializer_list<int> wanted) const {
  const auto beyond = accessor - std::int64_t(size("accessors"));
  if (beyond >= 0 && beyond < std::ssize(decoded_)) return decoded_values(std::size_t(beyond), wanted);
  const Json& object = item("accessors", accessor);
  const std::string at = place("accessors", accessor);
  GltfValues result;
  result.type = component_type(object, at);
  result.components = component_count(object, at);
  if (std::find(wanted.begin(), wanted.end(), result.components) == wanted.end())
    fail(at, fmt::format("its type {} does not fit its use", json_text_of(object, "type")));
  const auto count = std::size_t(json_count(object, "count", 0, at));
  std::size_t held = document_.bytes.size();
  for (const Part& part : document_.parts) held += part.bytes.size();
  const bool has_view = object.contains("bufferView");
  const GltfView from = has_view ? view(json_count(object, "bufferView", 0, at)) : GltfView();
  if (count > std::max(held, from.length))
    fail(at, fmt::format("{} elements are more than the file holds", count));
  result.values.assign(count * std::size_t(result.components), 0);
  if (has_view) {
    load(from, std::size_t(json_count(object, "byteOffset", 0, at)), count, result.components,
         result.type, at, result.values.data());
  } else if (!object.contains("sparse")) {
    fail(at, "it has no data");
  }
  add_sparse(object, at, result);
  normalize(object, result);
  return result;
}

void GltfFile::add_sparse(const Json& accessor, const std::string& place,
                          GltfValues& values) const {
  const Json* sparse = json_object(accessor, "sparse");
  if (!sparse) return;
  const std::string full = place + ".sparse";
  const Json *indices = json_object(*sparse, "indices"), *data = json_object(*sparse, "values");
  if (!indices || !data) fail(place, "its sparse part has no indices or no values");
  const auto count = std::size_t(json_count(*sparse, "count", 0, full));
  if (count > values.count()) fail(place, "it has more sparse values than elements");

  std::vector<double> at(count), to(count * std::size_t(values.components));
  load(view(json_count(*indices, "bufferView", -1, full)),
       std::size_t(json_count(*indices, "byteOffset", 0, full)), count, 1,
       component_type(*indices, full), place, at.data());
  load(view(json_count(*data, "bufferView", -1, full)),
       std::size_t(json_count(*data, "byteOffset", 0, full)), count, values.components, values.type,
       place, to.data());
  for (std::size_t i = 0; i < count; ++i) {
    if (!(at[i] >= 0 && at[i] < double(values.count())) || at[i] != std::floor(at[i]))
      fail(place, fmt::format("sparse index {} is out of range", at[i]));
    for (int c = 0; c < values.components; ++c)
      values.values[std::size_t(at[i]) * std::size_t(values.components) + std::size_t(c)] =
          to[i * std::size_t(values.components) + std::size_t(c)];
  }
}

std::optional<GltfLayout> GltfFile::layout(std::int64_t accessor) const {
  if (accessor >= std::int64_t(size("accessors"))) return {};  // decoded by Draco
  const Json& object = item("accessors", accessor);
  const std::string at = place("accessors", accessor);
  if (object.contains("sparse") || !object.contains("bufferView")) return {};
  const GltfView from = view(json_count(object, "bufferView", 0, at));
  if (from.decoded >= 0) return {};
  const std::size_t element =
      std::size_t(component_count(object, at) * size_of(component_type(object, at)));
  return GltfLayout{from.buffer, from.offset + std::size_t(json_count(object, "byteOffset", 0, at)),
                    from.stride ? from.stride : element};
}

// ---- Draco ----

std::int64_t GltfFile::add_decoded(std::int64_t view, std::int64_t attribute, std::int64_t accessor,
                                   GltfValues values, const std::string& at) const {
  const auto id = decoded_ids_.try_emplace({view, attribute, accessor}, decoded_.size());
  if (id.second) {
    if (accessor >= 0) {
      const Json& object = item("accessors", accessor);
      const auto count = std::size_t(json_count(object, "count", 0, place("accessors", accessor)));
      if (count != values.count())
        fail(at, fmt::format("its accessor {} says {} elements, and Draco's stream holds {}; the file may "
                             "be damaged: export it again",
                             accessor, count, values.count()));
      normalize(object, values);
    }
    const bool positions = attribute >= 0 && values.type == GltfType::f32 && values.components == 3;
    decoded_.push_back({std::move(values), positions ? draco_.at(view).step : 0});
  }
  return std::int64_t(size("accessors") + id.first->second);
}

Json GltfFile::decompressed(const Json& primitive, const std::string& at) const {
  const Json* extensions = json_object(primitive, "extensions");
  const Json* draco = extensions ? json_object(*extensions, "KHR_draco_mesh_compression") : nullptr;
  const Json* attributes = json_object(primitive, "attributes");
  if (!draco || !attributes) return primitive;
  const std::string full = at + ".extensions.KHR_draco_mesh_compression";
  const std::int64_t stream = json_count(*draco, "bufferView", -1, full);
  const Json* ids = json_object(*draco, "attributes");
  if (!ids || ids->empty()) fail(full, "it has no attributes");
  if (!draco_.contains(stream)) {
    std::set<std::uint32_t> wanted;
    for (const auto& [name, id] : ids->items())
      wanted.insert(std::uint32_t(std::min<std::int64_t>(json_count(*ids, name.c_str(), 0, full), UINT_MAX)));
    draco_[stream] = decode_draco(bytes(view(stream)), wanted, full);
  }
  const DracoMesh& mesh = draco_[stream];
  Json result = primitive;
  for (const auto& [name, number] : ids->items()) {
    if (!attributes->contains(name)) fail(full, fmt::format("{} is no attribute of it", shown(name)));
    const std::int64_t id = json_count(*ids, name.c_str(), 0, full);
    const auto values = mesh.attributes.find(std::uint32_t(id));
    if (values == mesh.attributes.end()) fail(full, fmt::format("its stream has no attribute {}", id));
    result["attributes"][name] = add_decoded(
        stream, id, json_count(*attributes, name.c_str(), -1, at), values->second, full);
  }
  // Whatever the mode, Draco holds triangles; of those of a strip the accessor counts other corners.
  const bool strip = json_count(primitive, "mode", 4, at) != 4;
  result["mode"] = 4;
  result["indices"] = add_decoded(stream, -1, strip ? -1 : json_count(primitive, "indices", -1, at),
                                  {1, GltfType::u32, false, mesh.corners}, full);
  return result;
}

double GltfFile::step(std::int64_t accessor) const {
  const auto beyond = accessor - std::int64_t(size("accessors"));
  return beyond >= 0 && beyond < std::ssize(decoded_) ? decoded_[std::size_t(beyond)].step : 0;
}

bool is_compressed_gltf(const Document& document) {
  if (!document.is_gltf()) return false;
  const GltfFile file(document);
  for (const Json& name : json_array(file.json(), "extensionsUsed", file.name()))
    if (name.is_string() && (name.get<std::string>() == "KHR_draco_mesh_compression" ||
                             name.get<std::string>().ends_with("_meshopt_compression")))
      return true;
  return false;
}

std::vector<std::string> gltf_parts(const Document& document) {
  const GltfFile file(document);
  std::vector<std::string> names;
  for (std::size_t b = 0; b < file.size("buffers"); ++b)
    if (const std::string name = file.buffer_name(b); !name.empty()) names.push_back(name);
  return names;
}

}  // namespace mq

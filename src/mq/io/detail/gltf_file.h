#pragma once
/// The container, the JSON, the buffers and the accessors of a glTF file, each checked when asked
/// for.

#include <array>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "mq/io/document.h"

namespace mq {

using Json = nlohmann::json;

/// Component types of accessors, by their numbers in the file.
enum class GltfType { i8 = 5120, u8 = 5121, i16 = 5122, u16 = 5123, u32 = 5125, f32 = 5126 };

int size_of(GltfType type);

/// The number that lies there.
double load_component(GltfType type, const std::byte* from);

/// What an integer is divided by when it stands for 0 to 1 (or −1 to 1); 1 for floats.
double largest_of(GltfType type);

/// The values of an accessor, `components` to an element.
struct GltfValues {
  int components = 0;
  GltfType type = GltfType::f32;  ///< as stored
  bool normalized = false;        ///< integers were divided by their largest value
  std::vector<double> values;

  std::size_t count() const { return components ? values.size() / std::size_t(components) : 0; }
};

/// Where an accessor's elements are stored: element i at `offset` + i · `stride` of a buffer.
struct GltfLayout {
  int buffer = 0;
  std::size_t offset = 0;
  std::size_t stride = 0;
};

/// Bytes of a view in a buffer.
struct GltfView {
  int buffer = 0;
  std::size_t offset = 0;
  std::size_t length = 0;
  std::size_t stride = 0;  ///< 0: elements are adjacent
  std::int64_t decoded = -1;  ///< the view whose decompressed bytes these are; −1: as they are stored
};

struct DracoMesh;

class GltfFile {
 public:
  /// Reads the container and the JSON. Throws `IoError`.
  explicit GltfFile(const Document& document);
  ~GltfFile();

  const Json& json() const { return json_; }
  std::string_view json_text() const { return json_text_; }

  /// The binary part of a GLB that has one.
  const std::optional<ByteView>& chunk() const { return chunk_; }

  /// An item of an array at the root; throws `IoError` where it is not there.
  const Json& item(const char* array, std::int64_t index) const;
  std::size_t size(const char* array) const;

  /// The name of the file that buffer b is in; empty where it is in this file.
  std::string buffer_name(std::size_t b) const;

  /// The bytes of a buffer, at least as many as it declares.
  ByteView buffer(int b) const;

  /// A view, decompressed where meshopt compressed it.
  GltfView view(std::int64_t index) const;
  ByteView bytes(const GltfView& view) const;

  /// What a view occupies in buffers: as the view says, and as its meshopt extension does. Nothing
  /// where there is no such part, or it lies in a buffer without bytes (a "fallback").
  std::optional<GltfView> stored_view(std::int64_t index) const;
  std::optional<GltfView> compressed_view(std::int64_t index) const;

  /// `primitive` with what Draco compressed (its attributes and indices) as accessors beyond those of
  /// the file, decoded once; as it is where nothing is.
  Json decompressed(const Json& primitive, const std::string& place) const;
  /// The step of the grid that Draco rounded an accessor to; 0: none.
  double step(std::int64_t accessor) const;
  /// Whether anything that was asked for was compressed, by meshopt or Draco.
  bool used_meshopt() const { return !meshopt_.empty(); }
  bool used_draco() const { return !draco_.empty(); }

  /// Values of an accessor with one of the wanted numbers of components.
  GltfValues values(std::int64_t accessor, std::initializer_list<int> components) const;

  /// Where the elements are; nothing for sparse accessors, compressed ones and those without a view.
  std::optional<GltfLayout> layout(std::int64_t accessor) const;

  const std::string& name() const { return document_.name; }

  /// "NAME, nodes[3]": an item for messages.
  std::string place(const char* array, std::int64_t index) const;

  /// Throws `IoError`.
  [[noreturn]] static void fail(const std::string& place, const std::string& what);

 private:
  void open_glb();
  void parse_json();
  Bytes load_buffer(int b) const;
  GltfView region(const Json& object, const std::string& place) const;
  bool is_fallback(std::int64_t buffer) const;
  std::int64_t add_decoded(std::int64_t view, std::int64_t attribute, std::int64_t accessor,
                           GltfValues values, const std::string& place) const;
  GltfValues decoded_values(std::size_t number, std::initializer_list<int> wanted) const;
  void add_sparse(const Json& accessor, const std::string& place, GltfValues& values) const;
  void load(const GltfView& view, std::size_t offset, std::size_t count, int components,
            GltfType type, const std::string& place, double* to) const;

  const Document& document_;
  std::string_view json_text_;
  std::optional<ByteView> chunk_;
  Json json_;
  mutable std::vector<std::optional<Bytes>> buffers_;  ///< those decoded from URIs
  mutable std::map<std::int64_t, Bytes> meshopt_;      ///< of views, decompressed
  mutable std::map<std::int64_t, DracoMesh> draco_;    ///< of views, decoded

  /// Of a stream of Draco, seen through an accessor.
  struct Decoded {
    GltfValues values;
    double step = 0;
  };
  mutable std::vector<Decoded> decoded_;
  /// Their numbers by view, Draco's id (−1: indices) and accessor.
  mutable std::map<std::array<std::int64_t, 3>, std::size_t> decoded_ids_;
};

/// A member that is a number that counts or indexes, from 0; `otherwise` where it is missing.
/// Throws `IoError` naming `place` when it is something else.
std::int64_t json_count(const Json& object, const char* key, std::int64_t otherwise,
                        const std::string& place);
/// The same for any finite number, and for arrays of `size` of them.
double json_number(const Json& object, const char* key, double otherwise, const std::string& place);
std::vector<double> json_numbers(const Json& object, const char* key, std::vector<double> otherwise,
                                 const std::string& place);
/// A member that is an object, or null.
const Json* json_object(const Json& object, const char* key);
/// The items of a member that is an array; none where it is missing.
const Json& json_array(const Json& object, const char* key, const std::string& place);
std::string json_text_of(const Json& object, const char* key);

}  // namespace mq

#pragma once
/// A glTF file taken apart into its JSON and its buffer views, and put together again: in the other
/// container, or with views of other bytes.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mq/io/detail/gltf_file.h"

namespace mq {

class GltfPacker {
 public:
  /// Copies the JSON; bytes are those of `file`, which must stay. Throws `IoError` where views are damaged.
  explicit GltfPacker(const GltfFile& file);

  /// All but "buffers" and "bufferViews", which `packed` writes.
  Json& json() { return json_; }

  /// A view of bytes of its own; `more` are members besides ("byteStride", "target").
  std::int64_t add_view(Bytes bytes, Json more = Json::object());

  /// What is stored for a view becomes a stream of meshopt; `extension` says "mode", "count" and
  /// "byteStride" of it. Nothing of what the view holds changes for readers.
  void compress_view(std::int64_t view, Bytes stream, Json extension);

  /// The file with one buffer, in a GLB or, named after `stem`, beside a glTF. Views that nothing names
  /// are left out, bytes that several views share are stored once. Throws `Unsupported` for a GLB
  /// beyond 4 GB.
  Document packed(Document::Format format, const std::string& stem);

  /// Whether a file names views in none but the ways known here (a member "bufferView").
  static bool can_pack(const GltfFile& file);

 private:
  /// Bytes of a buffer of the file, or of their own.
  struct Source {
    std::optional<GltfView> region;
    Bytes own;
    bool is_there() const { return region.has_value() || !own.empty(); }
  };
  struct View {
    Json members;
    Source stored;
    Source stream;  ///< of meshopt
  };
  /// Bytes `begin` to `end` of a buffer of the file, which lie from `to` on in the new one.
  struct Segment {
    int buffer = 0;
    std::size_t begin = 0, end = 0, to = 0;
  };

  void place_regions(const std::vector<char>& used);
  std::size_t place(const Source& source);
  Json view_json(const View& view);

  const GltfFile& file_;
  Json json_;
  std::vector<View> views_;
  std::vector<Segment> segments_;
  Bytes binary_;
  std::size_t fallback_ = 0;  ///< bytes of the buffer that stands for what is compressed
};

}  // namespace mq

#pragma once
/// The store of an evolving mesh: a manifest, NAME.evolving, and its blocks, NAME.blocks beside it.
/// docs/evolving_format.md describes every byte.
///
/// Blocks are only ever appended, and a block counts once the manifest has a whole line for it. So
/// a writer that is stopped leaves a store that holds everything up to its last frame, and a reader
/// may follow while it is written. It is there from its first frame on. Positions are multiples of
/// a step of 2ᵏ model units.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "mq/evolving/evolving_mesh.h"
#include "mq/io/atomic_file.h"
#include "mq/io/bytes.h"

namespace mq {

/// The step for a surface of this size: the power of two that is at least a millionth of it, and
/// less than two.
double store_step(double diagonal);

/// Positions as a store of this step gives them back.
std::vector<Vector3> rounded(std::vector<Vector3> positions, double step);

/// A line of the manifest.
struct StoredBlock {
  std::int64_t offset = 0;  ///< in the file of blocks
  std::int64_t bytes = 0;
  std::uint32_t checksum = 0;  ///< CRC-32 of IEEE 802.3
};
struct StoredSegment : StoredBlock {
  int vertices = 0, triangles = 0;
};
struct StoredFrame : StoredBlock {
  int number = 0;
  int segment = 0;
  std::string measured;  ///< what its maker had to say about it: a JSON object, or empty
};

/// Segments and frames that are in no store, but in a file of another format (animation_read.h).
class EvolvingSource {
 public:
  virtual ~EvolvingSource() = default;
  virtual EvolvingSegment segment(int index) const = 0;
  virtual std::vector<Vector3> positions(int frame) const = 0;
};

class EvolvingReader {
 public:
  /// What is no store, as if it were one: positions are the source's, in a unit of so many metres, and `step` what a
  /// store of them would have.
  EvolvingReader(std::filesystem::path file, std::shared_ptr<const EvolvingSource> source,
                 std::vector<StoredSegment> segments, std::vector<StoredFrame> frames, double step,
                 double metres_per_unit = 1);

  /// Reads the manifest. What follows the first line that is broken, or that names bytes the blocks
  /// do not have, is left out and `broken` says so. Throws `IoError` where either file cannot be
  /// read or the manifest's first line is not that of such a store.
  explicit EvolvingReader(std::filesystem::path manifest);

  const std::vector<StoredSegment>& segments() const { return segments_; }
  const std::vector<StoredFrame>& frames() const { return frames_; }
  double step() const { return step_; }
  double metres_per_unit() const { return metres_per_unit_; }          ///< 1 of a store, which says nothing of it
  const std::filesystem::path& manifest() const { return manifest_; }  ///< or the file that is no store
  const std::filesystem::path& blocks_file() const { return blocks_; }
  bool is_store() const { return !source_; }
  const std::string& about() const { return about_; }    ///< a JSON object
  const std::string& broken() const { return broken_; }  ///< empty: the store is whole

  /// One segment, one frame, whichever is asked for. Throws `IoError` naming the place where its
  /// checksum is another or its bytes say nothing sensible.
  EvolvingSegment segment(int index) const;
  std::vector<Vector3> positions(int frame) const;

  /// Frames whose bytes, or whose segment's, are not those that were written, by checksum, in
  /// order.
  std::vector<int> damaged() const;

  /// Everything. Throws as `segment` and `positions` do.
  EvolvingMesh read() const;

 private:
  friend class EvolvingWriter;
  Bytes bytes_of(const StoredBlock& block, const std::string& what) const;
  Bytes block(const StoredBlock& block, const std::string& what) const;
  const std::vector<std::int64_t>& key(int segment) const;
  std::string add_line(std::string_view line, std::int64_t blocks_size);

  std::filesystem::path manifest_, blocks_;
  std::shared_ptr<const EvolvingSource> source_;  ///< null: it is a store
  std::vector<StoredSegment> segments_;
  std::vector<StoredFrame> frames_;
  double step_ = 0, metres_per_unit_ = 1;
  std::string about_, broken_;
  std::int64_t whole_blocks_ = 0;  ///< bytes that sound lines name
  mutable int key_segment_ = -1;
  mutable std::vector<std::int64_t> key_;
};

class EvolvingWriter {
 public:
  /// Begins a store. Until its first frame has been added it is kept under temporary names: what is
  /// there under these two names is only replaced by a store with a frame, and stays if the writer
  /// goes before. `about` is a JSON object for whoever reads, such as the options that made it.
  EvolvingWriter(const std::filesystem::path& manifest, double step,
                 const std::string& about = "{}");

  /// Goes on with a store (no other source) as `reader` found it: what is broken is cut off, and so are frames and
  /// segments after the first `frames`.
  EvolvingWriter(const EvolvingReader& reader, int frames);

  /// Appends a segment; `positions` are those of its first frame, against which all are coded.
  void add_segment(const EvolvingSegment& segment, const std::vector<Vector3>& positions);

  /// Appends a frame of the segment appended last. Positions are rounded to the step.
  void add_frame(int number, const std::vector<Vector3>& positions,
                 const std::string& measured = {});

  double step() const { return step_; }

 private:
  EvolvingWriter() = default;
  friend void write_evolving(const std::filesystem::path&, const EvolvingMesh&, double,
                             const std::string&, const std::vector<std::string>&);
  void begin(const std::string& blocks_name, const std::string& about);
  StoredBlock append(const Bytes& bytes);
  void append_line(const std::string& line);

  /// The files of a store that has no frame yet.
  struct Beginning {
    AtomicFile manifest, blocks;
    Beginning(const std::filesystem::path& manifest_, const std::filesystem::path& blocks_)
        : manifest(manifest_), blocks(blocks_) {}
  };

  std::unique_ptr<Beginning> beginning_;     ///< null: they are in their place
  std::filesystem::path manifest_, blocks_;  ///< where they are now
  double step_ = 0;
  int segment_ = -1;
  std::int64_t size_ = 0;
  std::vector<std::int64_t> key_;
};

/// A whole evolving mesh at once: both files appear whole, or neither does. `measured` per frame,
/// or empty.
void write_evolving(const std::filesystem::path& manifest, const EvolvingMesh& evolving,
                    double step, const std::string& about = "{}",
                    const std::vector<std::string>& measured = {});

}  // namespace mq

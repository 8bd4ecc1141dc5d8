#pragma once
/// The store of an evolving mesh: a manifest, NAME.evolving, and its blocks, NAME.blocks beside it.
/// docs/evolving_format.md describes every byte.
///
/// Blocks are only ever appended, and a block counts once the manifest has a whole line for it. So
/// a writer that is stopped leaves a store that holds everything up to its last frame, and a reader
/// may follow while it is written. It is there from its first frame on. Positions are multiples of
/// a step; segments and frames are what is new since those before them, from the first of each group of frames on.
/// Stores of version 1 are read, and are made anew in version 2 where they are gone on with.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "mq/evolving/evolving_mesh.h"
#include "mq/io/atomic_file.h"
#include "mq/io/bytes.h"
#include "mq/io/detail/evolving_motion.h"
#include "mq/io/detail/store_coder.h"

namespace mq {

/// The step for a surface of this size: the power of two that is at least a millionth of it, and
/// less than two.
double store_step(double diagonal);

/// The largest step with which no position is off by more than `error`, in model units, of those with eight
/// significant bits. Throws `InvalidInput` where `error` is not positive and finite.
double step_within(double error);

/// How far u and v of an atlas laid out may be off in a store, in texels: much less than what textures are drawn with.
inline constexpr double store_uv_error = 1.0 / 32;

/// The largest power of two with which no u or v is off by more than `error`; 0 for an error of 0.
double uv_step_within(double error);

/// Frames in a group, at most, where nobody says how many: to read one, none that is not in its group is needed.
constexpr int store_group_frames = 32;

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
  double uv_step() const { return uv_step_; }                          ///< 0: texture coordinates are as they were
  int group_frames() const { return group_frames_; }                   ///< the most that a group is given
  double metres_per_unit() const { return metres_per_unit_; }          ///< 1 of a store, which says nothing of it
  const std::filesystem::path& manifest() const { return manifest_; }  ///< or the file that is no store
  const std::filesystem::path& blocks_file() const { return blocks_; }
  bool is_store() const { return !source_; }
  const std::string& about() const { return about_; }    ///< a JSON object
  const std::string& broken() const { return broken_; }  ///< empty: the store is whole

  /// One segment, one frame, whichever is asked for: at no more cost than its own where the one before it was asked for
  /// last, else at that of all before it in its group. Throws `IoError` naming the place where its
  /// checksum is another or its bytes say nothing sensible.
  EvolvingSegment segment(int index) const;
  std::vector<Vector3> positions(int frame) const;

  /// Frames whose bytes, or those of what is needed to read them, are not those that were written, by checksum, in
  /// order.
  std::vector<int> damaged() const;

  /// Everything. Throws as `segment` and `positions` do.
  EvolvingMesh read() const;

 private:
  friend class EvolvingWriter;
  /// Frames that are read without those before them: where a segment is whole.
  struct Group {
    StoredBlock block;  ///< of its first segment, whole
    int segment = 0, first_frame = 0;
  };
  /// A segment that was read.
  struct Place {
    int group = -1, segment = -1;
    EvolvingSegment found;
  };
  /// A frame that was read, and what the next one is told from.
  struct Moment {
    int frame = -1;
    Place place;
    CodingOrder order;
    MotionState motion;
  };

  Bytes bytes_of(const StoredBlock& block, const std::string& what) const;
  Bytes block(const StoredBlock& block, const std::string& what) const;
  bool is_changed(const StoredBlock& block) const;
  const std::vector<std::int64_t>& key(int segment) const;
  void read_head(std::string_view line);
  std::string add_line(std::string_view line, std::int64_t blocks_size);
  std::string add_segment_line(const StoredBlock& block, std::int64_t segment, const nlohmann::ordered_json& line);
  std::string named(const std::string& what) const;
  void require_counts(const Place& place) const;
  void begin_group(Place& place, int group) const;
  void next_segment(Place& place) const;
  const Moment& moment(int frame) const;

  std::filesystem::path manifest_, blocks_;
  std::shared_ptr<const EvolvingSource> source_;  ///< null: it is a store
  std::vector<StoredSegment> segments_;
  std::vector<StoredFrame> frames_;
  std::vector<Group> groups_;
  std::vector<int> group_of_segment_, group_of_frame_;
  std::vector<std::int64_t> end_of_frame_;  ///< in the manifest, of its line
  int version_ = 0, segment_lines_ = 0, group_frames_ = store_group_frames;
  double step_ = 0, uv_step_ = 0, metres_per_unit_ = 1;
  std::string about_, broken_;
  std::int64_t whole_blocks_ = 0;  ///< bytes that sound lines name
  mutable Place place_;
  mutable Moment moment_;
  mutable int key_segment_ = -1;  ///< of version 1
  mutable std::vector<std::int64_t> key_;
};

class EvolvingWriter {
 public:
  /// Begins a store, whose texture coordinates are multiples of `uv_step`, a power of two; 0: as they are. Until its
  /// first frame has been added it is kept under temporary names: what is there under these two names is only replaced
  /// by a store with a frame, and stays if the writer goes before. `about` is a JSON object for whoever reads, such as
  /// the options that made it. Groups have at most `group_frames` frames.
  EvolvingWriter(const std::filesystem::path& manifest, double step, const std::string& about = "{}",
                 double uv_step = 0, int group_frames = store_group_frames);

  /// Goes on with a store (no other source) as `reader` found it: what is broken is cut off, and so are frames and
  /// segments after the first `frames`.
  EvolvingWriter(const EvolvingReader& reader, int frames);

  /// Appends a segment.
  void add_segment(const EvolvingSegment& segment);

  /// Appends a frame of the segment appended last. Positions are rounded to the step.
  void add_frame(int number, const std::vector<Vector3>& positions,
                 const std::string& measured = {});

  double step() const { return coder_.step(); }

 private:
  EvolvingWriter() = default;
  friend void write_evolving(const std::filesystem::path&, const EvolvingMesh&, double,
                             const std::string&, const std::vector<std::string>&, double, int);
  void begin(const std::string& blocks_name, const std::string& about);
  void make_anew(const EvolvingReader& reader, int frames) const;
  void go_on(const EvolvingReader& reader, int frames);
  void append(const StorePiece& piece);

  /// The files of a store that has no frame yet.
  struct Beginning {
    AtomicFile manifest, blocks;
    Beginning(const std::filesystem::path& manifest_, const std::filesystem::path& blocks_)
        : manifest(manifest_), blocks(blocks_) {}
  };

  std::unique_ptr<Beginning> beginning_;     ///< null: they are in their place
  std::filesystem::path manifest_, blocks_;  ///< where they are now
  StoreCoder coder_;
};

/// A whole evolving mesh at once: both files appear whole, or neither does. `measured` per frame,
/// or empty. `uv_step` and `group_frames` as `EvolvingWriter` has them.
void write_evolving(const std::filesystem::path& manifest, const EvolvingMesh& evolving,
                    double step, const std::string& about = "{}",
                    const std::vector<std::string>& measured = {}, double uv_step = 0,
                    int group_frames = store_group_frames);

}  // namespace mq

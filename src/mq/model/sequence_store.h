#pragma once
/// Where a sequence that is followed is kept, frame after frame, and what of it is there already.

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "mq/evolving/evolving_mesh.h"
#include "mq/io/evolving_file.h"
#include "mq/io/followed_frame.h"
#include "mq/model/messages.h"

namespace mq {

/// A store is taken up, or not, and then begun or gone on with; frames are added from then on.
class SequenceStore {
 public:
  virtual ~SequenceStore() = default;

  virtual std::string name() const = 0;  ///< for messages

  /// What can be gone on with.
  struct Stored {
    FollowedFrame frame;
    int segment = 0;
  };

  /// The sound frames that are there, up to the first that is not; none where there is no store.
  /// Changes nothing. Warns of what is broken or damaged. Throws where it cannot be read.
  virtual std::vector<Stored> take_up(Messages& messages) = 0;

  /// Of what was taken up. Throws as `EvolvingReader` does.
  virtual EvolvingSegment segment(int index) const = 0;
  virtual std::vector<Vector3> positions(int frame) const = 0;

  /// Throws `InvalidInput` where what was taken up was made in another way than it would be now.
  virtual void require_same_maker() const {}

  /// Begins anew, with positions that are multiples of `step`; what is there is replaced once a
  /// frame is added.
  virtual void begin(double step) = 0;

  /// Goes on after the first `frames` of what was taken up; the rest is cut off.
  virtual void go_on(int frames) = 0;

  virtual double step() const = 0;  ///< once taken up, or begun

  /// A segment, and the frames of it.
  virtual void add_segment(const EvolvingSegment& segment) = 0;
  virtual void add_frame(const FollowedFrame& frame, const std::vector<Vector3>& positions) = 0;
};

/// The store that other programs read: io/evolving_file.h.
class EvolvingStore : public SequenceStore {
 public:
  /// Throws `InvalidInput` where a store was made in another way.
  using SameMaker = std::function<void(const EvolvingReader& reader)>;

  /// `about` is a JSON object for whoever reads, such as the options; see `EvolvingWriter`, also for `group_frames`.
  explicit EvolvingStore(std::filesystem::path manifest, std::string about = "{}",
                         SameMaker require_same_maker = {}, int group_frames = store_group_frames);

  std::string name() const override { return manifest_.string(); }
  std::vector<Stored> take_up(Messages& messages) override;
  EvolvingSegment segment(int index) const override { return reader_->segment(index); }
  std::vector<Vector3> positions(int frame) const override { return reader_->positions(frame); }
  void require_same_maker() const override;
  void begin(double step) override;
  void go_on(int frames) override;
  double step() const override { return writer_ ? writer_->step() : reader_->step(); }
  void add_segment(const EvolvingSegment& segment) override;
  void add_frame(const FollowedFrame& frame, const std::vector<Vector3>& positions) override;

 private:
  std::filesystem::path manifest_;
  std::string about_;
  SameMaker require_same_maker_;
  int group_frames_;
  std::optional<EvolvingReader> reader_;
  std::optional<EvolvingWriter> writer_;
};

/// Kept in memory alone.
class MemoryStore : public SequenceStore {
 public:
  const EvolvingMesh& mesh() const { return mesh_; }
  const std::vector<FollowedFrame>& frames() const { return frames_; }

  std::string name() const override { return "the store"; }
  std::vector<Stored> take_up(Messages& messages) override;
  EvolvingSegment segment(int index) const override { return mesh_.segments[std::size_t(index)]; }
  std::vector<Vector3> positions(int frame) const override;
  void begin(double step) override;
  void go_on(int frames) override;
  double step() const override { return step_; }
  void add_segment(const EvolvingSegment& segment) override;
  void add_frame(const FollowedFrame& frame, const std::vector<Vector3>& positions) override;

 private:
  EvolvingMesh mesh_;
  std::vector<FollowedFrame> frames_;
  double step_ = 0;
};

}  // namespace mq

#pragma once
/// A sequence of meshes, each a mesh of its own, followed by one whose triangulation changes only
/// where it must (thesis 6.3).
///
///     FileFrames frames("scan/", {}, messages);
///     EvolvingStore store("scan.evolving");
///     const FollowedSequence found =
///         SequenceTracker(frames, store, {.follow = {.remeshing = Remeshing::parts}}).run();
///
/// A frame is followed and stored before the next one is; where a part of it is to be replaced, a few
/// more are read ahead, to see whether they ask for it as well. What is needed to go on is in the store,
/// so that a run that was stopped can be taken up.

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "mq/base/defect.h"
#include "mq/base/progress.h"
#include "mq/base/stopwatch.h"
#include "mq/io/followed_frame.h"
#include "mq/model/captured_frame.h"
#include "mq/model/frame_loader.h"
#include "mq/model/messages.h"
#include "mq/model/sequence_store.h"
#include "mq/model/template_follower.h"

namespace mq {

struct SequenceTrackerOptions {
  TemplateFollowerOptions follow = {};

  /// Frames that cannot be read, or hold no mesh to follow.
  enum class BadFrames { refused, left_out } bad_frames = BadFrames::refused;

  /// How far a store's positions may be off, as a fraction of the first frame's diagonal; none: by `store_step`.
  std::optional<double> error = {};

  /// Whether a store that is there is gone on with. The result is that of one run.
  enum class Resume { never, where_possible } resume = Resume::never;
};

struct FollowedSequence {
  std::vector<FollowedFrame> frames;  ///< with those that the store had
  std::vector<SkippedFrame> skipped;  ///< all of them
  Defects defects;  ///< warnings: of each kind, of the first frame that has it, which it names
};

class SequenceTracker {
 public:
  /// The loader, the store and who hears the messages must stay.
  SequenceTracker(const FrameLoader& frames, SequenceStore& store,
                  SequenceTrackerOptions options = {}, Messages& messages = nobody());
  ~SequenceTracker();

  /// Follows all frames, or those that the store does not have; once. Throws `InvalidInput` naming
  /// the frame that cannot be followed, or that the store was not made of; what `FrameLoader` and
  /// `SequenceStore` throw; `Cancelled`, which leaves the frames that were followed in the store.
  FollowedSequence run(const Progress& progress = {});

  /// Finds out what can be known before anything is written: whether the first frame can be read
  /// and be a template, or the store be taken up. Throws as `run` does.
  void rehearse();

 private:
  /// One that hears nothing.
  static Messages& nobody();

  std::unique_ptr<CapturedFrame> read(int frame, const Mesh* before) const;
  std::unique_ptr<CapturedFrame> prepare(int frame);
  CapturedFrame* ahead(int frame, int after, const Mesh& before);
  void follow(CapturedFrame& frame, const Stopwatch& watch, const Progress& progress);
  void open_store(const Mesh& first);
  void say_defects(const CapturedFrame& frame);
  void say_safe(int frames) const;
  void require_all_known() const;
  void require_known_motion(int first, int end) const;
  void list_missing_before(int frame);
  [[noreturn]] void refuse_none() const;
  std::string naming(int frame, const std::string& what) const;

  // sequence_resume.cpp
  int take_up();
  void take_up_segments(const std::vector<SequenceStore::Stored>& stored);
  int still_sound(const std::vector<SequenceStore::Stored>& stored) const;
  bool stays_left_out(int frame, int next) const;
  bool is_bad(int frame) const;
  [[noreturn]] void refuse_resuming(const std::string& why) const;

  const FrameLoader& frames_;
  SequenceStore& store_;
  SequenceTrackerOptions options_;
  Messages& messages_;
  TemplateFollower follower_;
  FollowedSequence found_;
  std::vector<SkippedFrame> skipped_;  ///< since the last frame that was followed
  std::map<int, std::unique_ptr<CapturedFrame>> read_ahead_;  ///< null: not to be followed
  std::set<std::string> said_;         ///< kinds of defects
  bool is_taken_up_ = false, is_open_ = false;
};

/// The first frame in which the template no longer shows what was captured.
struct LostFrame {
  int number = 0;
  double p95 = 0, max = 0;  ///< distances, of the diagonal
  /// A part of all points is, or few are: where a part came, went, or touches another.
  enum class Extent { many, few } extent = Extent::many;
};

/// A frame is lost of which 5 % of the points are farther than `lost_distance`, or one farther than five times
/// that, of the diagonal.
std::optional<LostFrame> first_lost(const std::vector<FollowedFrame>& frames);

}  // namespace mq

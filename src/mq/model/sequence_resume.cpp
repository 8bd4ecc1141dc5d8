// A store is gone on with as far as its frames are still those of the sequence: nothing of it is
// changed before that is known. What is needed to follow the next frame is what the store says, and
// of the first frames of its segments what was captured: colours, material, shapes at rest.
#include <fmt/format.h>

#include <utility>

#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/model/sequence_tracker.h"

namespace mq {

using Stored = SequenceStore::Stored;

/// Takes up the store: returns the first frame that is not in it. Changes nothing yet.
int SequenceTracker::take_up() {
  std::vector<Stored> stored = store_.take_up(messages_);
  stored.resize(std::size_t(still_sound(stored)));
  if (stored.empty()) return 0;
  store_.require_same_maker();
  take_up_segments(stored);
  const int last = int(stored.size()) - 1;
  const bool same = last > 0 && stored[last - 1].segment == stored[last].segment;
  follower_.take_up(stored[last].frame.number, store_.positions(last),
                    same ? store_.positions(last - 1) : std::vector<Vector3>());
  for (Stored& one : stored) {
    if (one.frame.added < 0)
      refuse_resuming(
          fmt::format("it does not say how its frame {} was followed", one.frame.number));
    if (one.frame.match && one.frame.match->remesh_seconds) follower_.count_passing(one.frame);
    found_.frames.push_back(std::move(one.frame));
  }
  is_taken_up_ = true;
  return frames_.index_of(found_.frames.back().number) + 1;
}

/// What was known when the segments were begun.
void SequenceTracker::take_up_segments(const std::vector<Stored>& stored) {
  for (int f = 0; f < std::ssize(stored); ++f) {
    if (f > 0 && stored[f].segment == stored[f - 1].segment) continue;
    const int frame = frames_.index_of(stored[f].frame.number);
    const EvolvingSegment segment = store_.segment(stored[f].segment);
    if (f > 0) follower_.take_up(stored[f - 1].frame.number, store_.positions(f - 1), {});
    const Mesh before = follower_.follows() ? follower_.mesh() : Mesh();
    const std::unique_ptr<CapturedFrame> captured =
        read(frame, follower_.follows() ? &before : nullptr);
    if (!follower_.take_up(*captured, store_.step(), segment, store_.positions(f)))
      refuse_resuming(frames_.name(frame) + " is not the mesh that it was made of");
  }
}

/// How many of a store's frames are still of the sequence as it is: those before the first that was
/// changed since, or was left out and can be followed now. Of what has another beginning nothing
/// is: then it may be another sequence, and the store is not given up for it.
int SequenceTracker::still_sound(const std::vector<Stored>& stored) const {
  int expected = 0;
  for (int f = 0; f < std::ssize(stored); ++f, ++expected) {
    const FollowedFrame& known = stored[f].frame;
    const int frame = frames_.index_of(known.number);
    if (frame < 0)
      throw InvalidInput(
          fmt::format("{}: {}: its frame {} is not one of these frames; track them without {}",
                      store_.name(), option_name("resume"), known.number, option_name("resume")));
    for (; expected < frame; ++expected)
      if (!stays_left_out(expected, f)) return f;
    if (!frames_.is_changed(frame, known.files)) continue;
    if (f == 0) refuse_resuming(frames_.name(frame) + " is not the mesh that it was made of");
    messages_.remark(frames_.name(frame) + " was changed since it was followed");
    return f;
  }
  return int(stored.size());
}

/// Whether a frame that the store leaves out still has to be, before its frame `next`.
bool SequenceTracker::stays_left_out(int frame, int next) const {
  if (!is_bad(frame)) {
    if (next == 0)
      refuse_resuming(frames_.name(frame) +
                      ", which it leaves out, can be followed now and comes first");
    messages_.remark(fmt::format("{} is not in {}, and can be followed now", frames_.name(frame),
                                 store_.name()));
    return false;
  }
  if (options_.bad_frames == SequenceTrackerOptions::BadFrames::refused)
    throw InvalidInput(fmt::format(
        "{}: {}: it has no frame {}, which is one of these frames; give {} if it was left out, or "
        "track without {}",
        store_.name(), option_name("resume"), frames_.number(frame), option_name("bad_frames"),
        option_name("resume")));
  return true;
}

/// Whether it cannot be followed now either.
bool SequenceTracker::is_bad(int frame) const {
  try {
    read(frame, nullptr);
    return false;
  } catch (const Cancelled&) {
    throw;
  } catch (const OutOfMemory&) {
    throw;
  } catch (const Error&) {
    return true;
  }
}

void SequenceTracker::refuse_resuming(const std::string& why) const {
  throw InvalidInput(fmt::format("{}: {}: {}; track without {}", store_.name(),
                                 option_name("resume"), why, option_name("resume")));
}

}  // namespace mq

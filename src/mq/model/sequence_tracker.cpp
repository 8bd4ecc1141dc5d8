#include "mq/model/sequence_tracker.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/base/words.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

double step_of(const Mesh& mesh, const std::optional<double>& error) {
  const double diagonal = mesh.positions.empty() ? 0 : bounding_box(mesh).diagonal();
  require(diagonal > 0,
          "the mesh has no triangle with an area: check that it is a mesh, and not cut short");
  return error ? step_within(*error * diagonal) : store_step(diagonal);
}

}  // namespace

Messages& SequenceTracker::nobody() {
  static Messages silent;
  return silent;
}

SequenceTracker::SequenceTracker(const FrameLoader& frames, SequenceStore& store,
                                 SequenceTrackerOptions options, Messages& messages)
    : frames_(frames),
      store_(store),
      options_(std::move(options)),
      messages_(messages),
      follower_(options_.follow) {}
SequenceTracker::~SequenceTracker() = default;

FollowedSequence SequenceTracker::run(const Progress& progress) {
  if (options_.error && options_.follow.remeshing != Remeshing::none && *options_.error > options_.follow.within)
    throw InvalidInput(fmt::format("{}: found {:.3g} % of the diagonal, and {} is {:.3g} %: what is rounded by more than frames "
                                   "are to be followed by would be replaced in each of them; wanted no more than that",
                                   option_name("error"), 100 * *options_.error, option_name("within"),
                                   100 * options_.follow.within));
  require_all_known();
  const int begun =
      options_.resume == SequenceTrackerOptions::Resume::where_possible ? take_up() : 0;
  if (begun > 0) {
    messages_.remark(fmt::format("goes on after frame {}", frames_.number(begun - 1)));
    say_safe(begun);
  }
  for (int frame = begun; frame < frames_.count(); ++frame) {
    list_missing_before(frame);
    const Progress part = progress.step(fmt::format("frame {}", frames_.number(frame)),
                                        1.0 / (frames_.count() - begun));
    const Stopwatch watch;
    try {
      if (const std::unique_ptr<CapturedFrame> captured = prepare(frame)) {
        require_known_motion(frame, frame + 1);
        follow(*captured, watch, part);
      }
    } catch (const InvalidInput& error) {
      throw InvalidInput(naming(frame, error.what()));
    }
    if (!found_.frames.empty()) say_safe(frame + 1);
  }
  list_missing_before(frames_.count());
  if (found_.frames.empty()) refuse_none();
  if (!is_open_) store_.go_on(int(found_.frames.size()));  // cuts off what is broken
  for (const FollowedFrame& frame : found_.frames)
    std::ranges::copy(frame.skipped, std::back_inserter(found_.skipped));
  std::ranges::copy(skipped_, std::back_inserter(found_.skipped));
  return std::move(found_);
}

void SequenceTracker::rehearse() {
  require_all_known();
  if (options_.resume == SequenceTrackerOptions::Resume::where_possible && take_up() > 0) return;
  bool is_begun = false;
  for (int frame = 0; frame < frames_.count() && !is_begun; ++frame) {
    try {
      if (const std::unique_ptr<CapturedFrame> first = prepare(frame)) {
        first->as_template(step_of(first->model().mesh, options_.error), 0, 0);
        is_begun = true;
      }
    } catch (const InvalidInput& error) {
      throw InvalidInput(naming(frame, error.what()));
    }
  }
  if (!is_begun) refuse_none();
}

/// Of frames that are left out where they are bad that is known when it is their turn.
void SequenceTracker::require_all_known() const {
  if (options_.bad_frames == SequenceTrackerOptions::BadFrames::refused) require_known_motion(0, frames_.count());
}

/// Where parts of the sequence say how it moves, none of its frames may be missing there.
void SequenceTracker::require_known_motion(int first, int end) const {
  if (!options_.follow.motion) return;
  std::vector<int> missing;
  for (int frame = first; frame < end; ++frame)
    if (!options_.follow.motion->has(frames_.number(frame))) missing.push_back(frames_.number(frame));
  if (missing.empty()) return;
  throw InvalidInput(fmt::format("{}: {} {} in no part, {}; follow the parts that should have them to their end",
                                 option_name("motion"), counted(std::ssize(missing), "frame"),
                                 missing.size() == 1 ? "is" : "are",
                                 missing.size() == 1
                                     ? fmt::format("number {}", missing.front())
                                     : fmt::format("from number {} to {}", missing.front(), missing.back())));
}

/// Facing as what follows the frame before does.
std::unique_ptr<CapturedFrame> SequenceTracker::read(int frame, const Mesh* before) const {
  const TemplateFollowerOptions& how = options_.follow;
  const bool coloured = how.colours == TemplateFollowerOptions::Colours::used;
  return std::make_unique<CapturedFrame>(
      frames_, frame, before,
      CaptureOptions{
          .longest_edge = how.longest_edge(),
          .colours = coloured ? CaptureOptions::Colours::used : CaptureOptions::Colours::left,
          .truth = how.truth});
}

/// One that comes later; bad ones are left for when it is their turn.
CapturedFrame* SequenceTracker::ahead(int frame, int after, const Mesh& before) {
  for (int next = frame + 1; next < frames_.count(); ++next) {
    auto place = read_ahead_.find(next);
    if (place == read_ahead_.end()) {
      std::unique_ptr<CapturedFrame> found;
      try {
        found = read(next, &before);
      } catch (const Cancelled&) {
        throw;
      } catch (const OutOfMemory&) {
        throw;
      } catch (const Error&) {
        if (options_.bad_frames == SequenceTrackerOptions::BadFrames::refused) return nullptr;
      }
      place = read_ahead_.emplace(next, std::move(found)).first;
    }
    if (place->second && --after == 0) return place->second.get();
  }
  return nullptr;
}

/// Null where it cannot be followed, and such frames are to be left out.
std::unique_ptr<CapturedFrame> SequenceTracker::prepare(int frame) {
  if (auto known = read_ahead_.extract(frame); !known.empty() && known.mapped())
    return std::move(known.mapped());
  try {
    if (!follower_.follows()) return read(frame, nullptr);
    const Mesh before = follower_.mesh();
    return read(frame, &before);
  } catch (const Cancelled&) {
    throw;
  } catch (const OutOfMemory&) {
    throw;
  } catch (const Error& error) {
    const std::string why = naming(frame, error.what());
    if (options_.bad_frames == SequenceTrackerOptions::BadFrames::refused)
      throw InvalidInput(why + "; or leave out such frames with " + option_name("bad_frames"));
    messages_.warning(why + "; it is left out");
    skipped_.push_back({frames_.number(frame), why});
    return nullptr;
  }
}

void SequenceTracker::follow(CapturedFrame& frame, const Stopwatch& watch,
                             const Progress& progress) {
  FollowedFrame found;
  found.number = frames_.number(frame.frame());
  found.turned = int(frame.turned().size());
  found.skipped = std::exchange(skipped_, {});
  say_defects(frame);
  if (!is_open_) open_store(frame.model().mesh);
  const FrameAhead later = [&](int after, const Mesh& before) {
    return ahead(frame.frame(), after, before);
  };
  if (follower_.follow(frame, later, store_.step(), found, progress) ==
      TemplateFollower::Segment::begun)
    store_.add_segment(follower_.segment());
  found.files = frames_.files(frame.frame(), frame.model());
  if (options_.follow.motion) options_.follow.motion->require_made_of(found.number, found.files);
  found.seconds = watch.seconds();
  store_.add_frame(found, follower_.positions());
  found_.frames.push_back(std::move(found));
}

/// The one taken up, or a new one, which is there once it has a frame.
void SequenceTracker::open_store(const Mesh& first) {
  if (is_taken_up_)
    store_.go_on(int(found_.frames.size()));
  else
    store_.begin(step_of(first, options_.error));
  is_open_ = true;
}

/// Of each kind of defect, the first frame that has it: what is cut apart or left out there is so
/// in what follows it.
void SequenceTracker::say_defects(const CapturedFrame& frame) {
  Defects all = frame.defects();
  std::erase_if(all, [&](const Defect& defect) {
    return defect.severity != Defect::Severity::warning || !said_.insert(defect.kind).second;
  });
  for (Defect& defect : all) {
    const std::string name = frames_.name(frame.frame());
    messages_.warning(name + ": " + short_sentence(defect));
    defect.message = fmt::format("{}: {}", name, defect.message);
    found_.defects.push_back(std::move(defect));
  }
}

/// What a run that is stopped from here on leaves.
void SequenceTracker::say_safe(int frames) const {
  messages_.safe(fmt::format("{} has {} of {} frames, and {} goes on from there", store_.name(),
                             frames, frames_.count(), option_name("resume")));
}

void SequenceTracker::list_missing_before(int frame) {
  for (const int number : frames_.missing_before(frame))
    skipped_.push_back(
        {number, fmt::format("{}: there is no frame {}", frames_.sequence(), number)});
}

void SequenceTracker::refuse_none() const {
  throw InvalidInput(option_name("bad_frames") + ": not one of the frames can be followed: " +
                     (skipped_.empty() ? std::string("there is none") : skipped_[0].why));
}

std::string SequenceTracker::naming(int frame, const std::string& what) const {
  const std::string name = frames_.name(frame);
  return what.find(name) == what.npos ? name + ": " + what : what;
}

std::optional<LostFrame> first_lost(const std::vector<FollowedFrame>& frames) {
  for (const FollowedFrame& frame : frames) {
    const auto& [mean, p95, max] = frame.distance;
    if (p95 > lost_distance) return LostFrame{frame.number, p95, max, LostFrame::Extent::many};
    if (max > farthest_in_within * lost_distance)
      return LostFrame{frame.number, p95, max, LostFrame::Extent::few};
  }
  return {};
}

}  // namespace mq

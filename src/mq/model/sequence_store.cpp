#include "mq/model/sequence_store.h"

#include <utility>

#include "mq/io/path_status.h"
#include "mq/model/stored_frames.h"

namespace mq {

EvolvingStore::EvolvingStore(std::filesystem::path manifest, std::string about,
                             SameMaker require_same_maker, int group_frames)
    : manifest_(std::move(manifest)),
      about_(std::move(about)),
      require_same_maker_(std::move(require_same_maker)),
      group_frames_(group_frames) {}

std::vector<SequenceStore::Stored> EvolvingStore::take_up(Messages& messages) {
  reader_.reset();
  if (!is_there(manifest_)) return {};
  reader_.emplace(manifest_);
  warn_of_broken(messages, *reader_);
  const std::vector<int> damaged = reader_->damaged();
  warn_of_damage(messages, *reader_, damaged);
  const std::vector<StoredFrame>& stored = reader_->frames();
  const std::size_t sound = damaged.empty() ? stored.size() : std::size_t(damaged.front());
  std::vector<Stored> frames;
  for (std::size_t f = 0; f < sound; ++f)
    frames.push_back({followed_frame(stored[f].number, stored[f].measured), stored[f].segment});
  return frames;
}

void EvolvingStore::require_same_maker() const {
  if (require_same_maker_) require_same_maker_(*reader_);
}

void EvolvingStore::begin(double step) { writer_.emplace(manifest_, step, about_, 0, group_frames_); }

void EvolvingStore::go_on(int frames) { writer_.emplace(*reader_, frames); }

void EvolvingStore::add_segment(const EvolvingSegment& segment) { writer_->add_segment(segment); }

void EvolvingStore::add_frame(const FollowedFrame& frame, const std::vector<Vector3>& positions) {
  writer_->add_frame(frame.number, positions, followed_text(frame));
}

std::vector<SequenceStore::Stored> MemoryStore::take_up(Messages&) {
  std::vector<Stored> all;
  for (std::size_t f = 0; f < frames_.size(); ++f)
    all.push_back({frames_[f], mesh_.frames[f].segment});
  return all;
}

std::vector<Vector3> MemoryStore::positions(int frame) const {
  return mesh_.frames[std::size_t(frame)].positions;
}

void MemoryStore::begin(double step) {
  *this = {};
  step_ = step;
}

void MemoryStore::go_on(int frames) {
  frames_.resize(std::size_t(frames));
  mesh_.frames.resize(std::size_t(frames));
  mesh_.segments.resize(frames == 0 ? 0 : std::size_t(mesh_.frames.back().segment) + 1);
}

void MemoryStore::add_segment(const EvolvingSegment& segment) {
  mesh_.segments.push_back(segment);
}

void MemoryStore::add_frame(const FollowedFrame& frame, const std::vector<Vector3>& positions) {
  mesh_.frames.push_back({frame.number, int(mesh_.segments.size()) - 1, rounded(positions, step_)});
  frames_.push_back(frame);
}

}  // namespace mq

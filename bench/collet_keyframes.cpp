// collet_keyframes FRAMES OUT.evolving [UNTIL [WITHIN]]: a sequence shown by keyframes, chosen by components, genus
// and area (baseline/keyframes.h) and followed both ways, as an evolving mesh in which nothing lives on from one
// to the next.
//
// Frames are followed as by `track`. UNTIL says how far. replaced (default): up to the frame in which `track --remesh
// --within WITHIN` (in % of the diagonal) would replace a part. distance: up to the frame of which more than 5 % of the
// points are farther than WITHIN, or one is five times as far; triangles stay however long they become.
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "tool.h"
#include "mq/base/error.h"
#include "mq/baseline/keyframes.h"
#include "mq/io/evolving_file.h"
#include "mq/model/frame_loader.h"
#include "mq/model/sequence_tracker.h"

namespace mq {
namespace {

/// The frames of a sequence from one on, forwards or backwards; by increasing number.
class FramesFrom : public FrameLoader {
 public:
  FramesFrom(const FrameLoader& all, int first, int direction) : all_(all), first_(first), direction_(direction) {}
  int count() const override { return direction_ > 0 ? all_.count() - first_ : first_ + 1; }
  int number(int frame) const override { return direction_ * all_.number(place(frame)); }
  std::string name(int frame) const override { return all_.name(place(frame)); }
  std::string sequence() const override { return all_.sequence(); }
  Model read(int frame) const override { return all_.read(place(frame)); }
  std::vector<KnownFile> files(int frame, const Model& model) const override { return all_.files(place(frame), model); }

 private:
  int place(int frame) const { return first_ + direction_ * frame; }
  const FrameLoader& all_;
  int first_, direction_;
};

/// How far a keyframe goes.
struct Until {
  Remeshing remeshing = Remeshing::keyframes;  ///< or none: as far as distances allow
  double within = TemplateFollowerOptions().within;
};

/// Keeps up to so many frames, and those of the first segment alone.
class FirstSegment : public MemoryStore {
 public:
  FirstSegment(int most, const Until& until) : most_(most), until_(until) {}
  void add_segment(const EvolvingSegment& segment) override {
    if (!mesh().segments.empty()) throw Cancelled();
    MemoryStore::add_segment(segment);
  }
  void add_frame(const FollowedFrame& frame, const std::vector<Vector3>& positions) override {
    if (until_.remeshing == Remeshing::none && !frames().empty() && is_far(frame.distance)) throw Cancelled();
    MemoryStore::add_frame(frame, positions);
    if (int(frames().size()) == most_) throw Cancelled();
  }

 private:
  bool is_far(const SurfaceDistance& distance) const {
    return distance.p95 > until_.within || distance.max > farthest_in_within * until_.within;
  }

  int most_;
  Until until_;
};

FirstSegment followed(const FrameLoader& frames, int keyframe, int direction, int most, const Until& until) {
  const FramesFrom part(frames, keyframe, direction);
  FirstSegment store(most, until);
  try {
    SequenceTracker(part, store, {.follow = {.remeshing = until.remeshing, .within = until.within}}).run();
  } catch (const Cancelled&) {
    // It is as long as it can be.
  }
  return store;
}

/// What one keyframe shows.
struct Shown {
  KeyframeRange range;
  EvolvingSegment segment;
  double step = 0;
  std::vector<std::vector<Vector3>> positions;  // by frame
  std::vector<FollowedFrame> frames;
};

Shown shown_by(const FrameLoader& all, int keyframe, int first, int last, const Until& until) {
  const FirstSegment back = followed(all, keyframe, -1, keyframe - first + 1, until),
                     on = followed(all, keyframe, 1, last - keyframe + 1, until);
  require(back.mesh().frames[0].positions == on.mesh().frames[0].positions,
          "a keyframe is not the same mesh both ways");
  Shown shown{{keyframe, keyframe - int(back.frames().size()) + 1, keyframe + int(on.frames().size()) - 1},
              on.mesh().segments[0], on.step(), {}, {}};
  const auto add = [&shown](const FirstSegment& store, std::size_t frame) {
    shown.positions.push_back(store.mesh().frames[frame].positions);
    shown.frames.push_back(store.frames()[frame]);
    shown.frames.back().number = std::abs(shown.frames.back().number);
  };
  for (std::size_t f = back.frames().size() - 1; f > 0; --f) add(back, f);
  for (std::size_t f = 0; f < on.frames().size(); ++f) add(on, f);
  std::cerr << "keyframe " << all.number(keyframe) << ": frames " << all.number(shown.range.first) << " to "
            << all.number(shown.range.last) << "\n";
  return shown;
}

void write(const std::string& out, std::vector<Shown>& all) {
  std::ranges::sort(all, {}, [](const Shown& shown) { return shown.range.first; });
  EvolvingMesh evolving;
  std::vector<std::string> measured;
  int vertices = 0, triangles = 0, before = 0;
  double step = all[0].step;
  for (Shown& shown : all) {
    for (int& id : shown.segment.vertex_ids) id = vertices++;
    for (int& id : shown.segment.triangle_ids) id = triangles++;
    const int count = shown.segment.triangle_count();
    step = std::min(step, shown.step);
    for (std::size_t f = 0; f < shown.frames.size(); ++f) {
      FollowedFrame& frame = shown.frames[f];
      frame.kept = f == 0 ? 0 : count;
      frame.added = f == 0 ? count : 0;
      frame.removed = f == 0 ? before : 0;
      measured.push_back(followed_text(frame));
      evolving.frames.push_back({frame.number, int(evolving.segments.size()), std::move(shown.positions[f])});
    }
    evolving.segments.push_back(std::move(shown.segment));
    before = count;
  }
  write_evolving(out, evolving, step, "{}", measured);
}

int main(int count, char** words) {
  const std::string how = count > 3 ? words[3] : "replaced";
  require(count >= 3 && count <= 5 && (how == "replaced" || how == "distance"),
          "usage: collet_keyframes FRAMES OUT.evolving [replaced|distance [WITHIN]]");
  Until until;
  if (how == "distance") until.remeshing = Remeshing::none;
  if (count > 4) until.within = std::stod(words[4]) / 100;
  Messages messages;
  const FileFrames frames(words[1], {}, messages);
  std::vector<std::vector<ComponentShape>> shapes;
  for (int f = 0; f < frames.count(); ++f) shapes.push_back(component_shapes(make_surface(frames.read(f).mesh)));
  const std::vector<double> scores = keyframe_scores(shapes);
  std::vector<Shown> all;
  choose_keyframes(scores, [&](int keyframe, int first, int last) {
    all.push_back(shown_by(frames, keyframe, first, last, until));
    return all.back().range;
  });
  write(words[2], all);
  std::printf("| keyframe | shows | components | genus | area | score |\n|---|---|---|---|---|---|\n");
  for (const Shown& shown : all) {
    const KeyframeRange& range = shown.range;
    int genus = 0;
    double area = 0;
    for (const ComponentShape& shape : shapes[std::size_t(range.keyframe)]) genus += shape.genus, area += shape.area;
    std::printf("| %d | %d to %d | %zu | %d | %.4g | %.4f |\n", frames.number(range.keyframe),
                frames.number(range.first), frames.number(range.last), shapes[std::size_t(range.keyframe)].size(), genus,
                area, scores[std::size_t(range.keyframe)]);
  }
  return 0;
}

}  // namespace
}  // namespace mq

int main(int count, char** words) { return mq::run_tool(mq::main, count, words); }

// A frame is followed with what the last one left; where that does not show it, the template is
// replaced, here and there or as a whole, and what is kept of it goes on with its ids.
#include "mq/model/template_follower.h"

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <utility>

#include "mq/base/stopwatch.h"
#include "mq/io/evolving_file.h"
#include "mq/mesh/closest_point.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/soundness.h"
#include "mq/remesh/remesh.h"
#include "mq/track/rest_shape.h"

namespace mq {
namespace {

/// Of what 95 % are to keep, how far the surfaces may be apart that are left as they are: less and
/// less, until they keep it; at first two edges.
constexpr std::array accuracies_in_within = {0.0, 4.0, 2.0, 1.0, 0.5};
/// What 95 % are within where half of it is: of a normal distribution it is 2.9. So much of a frame being
/// off alike is noise, up to some times what is wanted; more is a template that lost its way.
constexpr double within_in_noise = 3, most_noise_in_within = 4;
/// Where something passes, no smaller differences are replaced than so many times what half is within:
/// six standard deviations.
constexpr double least_in_noise = 9;
/// Triangles are renewed once one is so many times as long or as large as at rest; then all that the verb
/// remesh takes for distorted are.
constexpr double most_distortion = 4.5;
/// Of a noisy sequence, frames after one that must be there to ask for a change: what passes is in two often.
constexpr int least_asked = 2;
/// Seeds of frames that are so many edges from each other are of one place.
constexpr int near_edges = 2;
/// Mean edges of what is tracked, in the spacing of a graph's nodes: what a graph can follow; and
/// shorter, so that what is replaced does not take much with it that could have stayed.
constexpr double longest_left = 0.5, longest_remeshed = 0.3;

TrackOptions track_options(const TemplateFollowerOptions& options) {
  TrackOptions track = options.track;
  track.colour_cycles =
      options.colours == TemplateFollowerOptions::Colours::used ? options.colour_cycles : 0;
  return track;
}

/// A frame that the template of the frame before was deformed to.
void put(const TrackedFrame& tracked, int triangles, FollowedFrame& found) {
  found.distance = tracked.distance;
  found.distortion = tracked.distortion;
  found.match = FollowedFrame::Match{tracked.matched, tracked.predicted, tracked.recognised,
                                     tracked.known,   tracked.seconds,   {}};
  found.kept = triangles;
  found.added = found.removed = 0;
}

double percentile_of(std::vector<double> values, int percent) {
  if (values.empty()) return 0;
  const auto at = values.begin() + std::ssize(values) * percent / 100;
  std::ranges::nth_element(values, at);
  return *at;
}

/// How far vertices of a frame and of what shows it are from the other one, in diagonals of the frame;
/// those that are left do not count.
struct Residuals {
  std::vector<double> there, back;
  double p95() const { return std::max(percentile_of(there, 95), percentile_of(back, 95)); }
  double median() const { return std::max(percentile_of(there, 50), percentile_of(back, 50)); }
};

/// Closest points of the vertices of both surfaces on each other.
struct NearestPlaces {
  std::vector<ClosestPoint> there, back;

  NearestPlaces(const Mesh& mesh, const ClosestPointFinder& on_mesh, const TrackTarget& target)
      : there(target.closest()(mesh.positions)), back(on_mesh(target.surface().mesh.positions)) {}
};

/// `left_there`: per vertex of the mesh; empty: none is left.
Residuals residuals(const NearestPlaces& nearest, const TrackTarget& target, const std::vector<char>& left_there,
                    const std::vector<char>& left_back) {
  const auto kept = [&](const std::vector<ClosestPoint>& places, const std::vector<char>& left) {
    std::vector<double> distances;
    for (std::size_t v = 0; v < places.size(); ++v)
      if (left.empty() || !left[v]) distances.push_back(std::sqrt(places[v].squared_distance) / target.diagonal());
    return distances;
  };
  return {kept(nearest.there, left_there), kept(nearest.back, left_back)};
}

/// 95 % of what is not left are within this; `found`: the template remeshed, or nothing.
double p95_without(const PassingPlaces& passing, const NearestPlaces& before,
                   const std::optional<Remeshed>& found, const TrackTarget& target) {
  if (!found)
    return passing.seeds == 0 ? surface_distance(before.there, before.back, target).p95
                              : residuals(before, target, passing.of_template, passing.of_target).p95();
  if (passing.seeds == 0) return surface_distance(found->mesh, target).p95;
  std::vector<char> left;
  for (const int v : found->template_vertices) left.push_back(v >= 0 && passing.of_template[v]);
  const ClosestPointFinder on_found(found->mesh);
  return residuals(NearestPlaces(found->mesh, on_found, target), target, left, passing.of_target).p95();
}

/// Rest shapes, of what is pulled by what passes as it is now: it comes back by itself.
std::vector<std::array<Vector3, 3>> rest_without(const PassingPlaces& passing, const Mesh& mesh,
                                                 std::vector<std::array<Vector3, 3>> rest) {
  for (int t = 0; t < mesh.triangle_count(); ++t)
    if (std::ranges::any_of(mesh.triangles[t], [&](int v) { return passing.pulled[v] != 0; }))
      for (int k = 0; k < 3; ++k) rest[t][k] = mesh.position(t, k);
  return rest;
}

}  // namespace

double TemplateFollowerOptions::longest_edge() const {
  return (remeshing == Remeshing::none ? longest_left : longest_remeshed) * track.node_spacing;
}

struct TemplateFollower::Template {
  TrackTemplate known;
  SurfaceTracker tracker;
  double edge;  ///< mean length at the segment's first frame

  Template(TrackTemplate known_, double edge_, const TrackOptions& options)
      : known(std::move(known_)),
        tracker(mesh_of(known.segment, rest_shape(known.mesh(), known.rest)), known.colours,
                options),
        edge(edge_) {}
};

TemplateFollower::TemplateFollower(TemplateFollowerOptions options)
    : options_(std::move(options)) {}
TemplateFollower::~TemplateFollower() = default;

const EvolvingSegment& TemplateFollower::segment() const { return template_->known.segment; }

Mesh TemplateFollower::mesh() const { return mesh_of(segment(), positions_); }

/// The template, at `current` in the frame `before`, deformed to a later one: as it is known to move, else as the frame
/// says.
TrackedFrame TemplateFollower::deformed(const CapturedFrame& frame, int before, std::span<const Vector3> current,
                                        std::span<const Vector3> previous, double step, const Progress& progress) const {
  TrackedFrame tracked;
  if (options_.motion) {
    if (auto moved = options_.motion->moved(before, frame.number(), current))
      tracked = template_->tracker.follow_known(current, std::move(*moved), frame.target(), progress);
  }
  if (!tracked.known || tracked.distance.p95 > lost_distance)
    tracked = template_->tracker.follow(current, previous, frame.target(), progress);
  tracked.distortion = distortion(template_->known, tracked.positions);
  tracked.positions = rounded(std::move(tracked.positions), step);
  return tracked;
}

/// The same, as it was ahead of its turn or now.
TrackedFrame TemplateFollower::track(CapturedFrame& frame, int before, double step, const Progress& progress) {
  if (!ahead_.empty() && ahead_.front().frame == &frame) {
    TrackedFrame tracked = std::move(ahead_.front().tracked);
    ahead_.pop_front();
    return tracked;
  }
  ahead_.clear();
  return deformed(frame, before, positions_, previous_, step, progress);
}

/// The same for a frame ahead; null: there is none.
const TemplateFollower::Tracked* TemplateFollower::track_ahead(int after, const FrameAhead& ahead,
                                                               double step) {
  while (std::ssize(ahead_) < after) {
    const int count = int(ahead_.size());
    const auto at = [&](int back) -> const std::vector<Vector3>& {  // 0: the last, 1: the one before
      if (count > back) return ahead_[std::size_t(count - 1 - back)].tracked.positions;
      return count == back ? positions_ : previous_;
    };
    CapturedFrame* frame = ahead(count + 1, mesh_of(segment(), at(0)));
    if (frame == nullptr) return nullptr;
    const int before = count > 0 ? ahead_.back().frame->number() : last_;
    TrackedFrame tracked = deformed(*frame, before, at(0), at(1), step, {});
    Surface surface =
        make_surface(mesh_of(segment(), tracked.positions), {.kind = WeldOptions::Kind::none});
    ahead_.push_back({frame, std::move(tracked), std::move(surface)});
  }
  return &ahead_[std::size_t(after - 1)];
}

TemplateFollower::Segment TemplateFollower::follow(CapturedFrame& frame, const FrameAhead& ahead,
                                                   double step, FollowedFrame& found,
                                                   const Progress& progress) {
  bool begun = !follows();
  const int before = std::exchange(last_, frame.number());
  if (!begun) {
    TrackedFrame tracked = track(frame, before, step, progress.step("follow", 0.7));
    begun = options_.restart && tracked.distance.p95 > *options_.restart;
    if (!begun) {
      previous_ = std::move(positions_);
      put(tracked, segment().triangle_count(), found);
      positions_ = std::move(tracked.positions);
      surface_ = make_surface(mesh(), {.kind = WeldOptions::Kind::none});
      if (options_.remeshing != Remeshing::none)
        return remesh_frame(frame, ahead, step, found, progress.step("remesh", 0.3)) ? Segment::begun
                                                                              : Segment::same;
    }
  }
  if (begun) begin(frame, step, found);
  measure(frame, found);
  return begun ? Segment::begun : Segment::same;
}

/// The frame's own mesh is the template from here on.
void TemplateFollower::begin(CapturedFrame& frame, double step, FollowedFrame& found) {
  found.removed = follows() ? segment().triangle_count() : 0;
  set_template(frame.as_template(step, next_vertex_, next_triangle_));
  count_ids(segment());
  previous_.clear();
  found.distance = surface_distance(template_->known.mesh(), frame.target());
  found.distortion = {1, 1};
  found.kept = 0;
  found.added = segment().triangle_count();
}

void TemplateFollower::count_passing(const FollowedFrame& frame) {
  ++remeshed_frames_;
  noisy_frames_ += frame.passing > 0;
}

/// What is not to be replaced, as the frames after do not ask for it. Only distances ask: what is
/// distorted is so in all frames. Where something passed in most frames before, and the sequence ends before enough
/// of them could ask, none does.
PassingPlaces TemplateFollower::passing(const CapturedFrame& frame, const SearchedSurface& from,
                                        const SearchedSurface& to, const FrameAhead& ahead, double step,
                                        RemeshOptions how) {
  how.rest = {};
  const RemeshSeeds seeds = remesh_seeds(from, to, how);
  std::vector<SeedPlaces> places;
  const auto any = [](const std::vector<char>& all) { return std::ranges::count(all, 1) > 0; };
  const auto can_pass = [&] {
    if (options_.confirming_frames == 0) return false;
    const CapturedFrame* next = ahead(1, mesh());
    return next != nullptr ? !frame.is_mesh_of(*next) : is_noisy();
  };
  if ((any(seeds.of_template) || any(seeds.of_target)) && can_pass()) {
    for (int after = 1; after <= options_.confirming_frames; ++after) {
      const Tracked* there = track_ahead(after, ahead, step);
      if (there == nullptr) break;
      const TrackTarget& target = there->frame->target();
      const ClosestPointFinder closest(there->surface.mesh);
      places.push_back(places_of(
          remesh_seeds({there->surface, closest}, {target.surface(), target.closest()}, how),
          there->surface, near_edges));
    }
    if (is_noisy() && std::ssize(places) < std::min(least_asked, options_.confirming_frames))
      places.emplace_back(surface_.mesh.positions.size(), 0);
  }
  return passing_places(seeds, from.surface, over_holes(from.surface, to.surface, to.closest),
                        places);
}

/// Replaces what of the template does not show the frame: at first what is two edges off, and less
/// and less where too many points are farther than wanted. Nothing: it all stays.
std::optional<Remeshed> TemplateFollower::remeshed_within(CapturedFrame& frame,
                                                          const FrameAhead& ahead, double step,
                                                          const Progress& progress) {
  const TrackTarget& target = frame.target();
  const ClosestPointFinder on_tracked(surface_.mesh);
  const NearestPlaces nearest(surface_.mesh, on_tracked, target);
  const SearchedSurface from{surface_, on_tracked, nearest.there},
      to{target.surface(), target.closest(), nearest.back};
  const double noise = residuals(nearest, target, {}, {}).median();
  const double within = std::clamp(within_in_noise * noise, options_.within,
                                   most_noise_in_within * options_.within);
  const double far = within * target.diagonal();
  RemeshOptions how{.farthest = farthest_in_within * far};
  std::optional<Remeshed> found;
  double tolerance = std::numeric_limits<double>::infinity();
  for (const double part : accuracies_in_within) {
    how.accuracy = part * far;
    how.left_of_template = how.left_of_target = {};
    if (how.accuracy >= tolerance) continue;
    const PassingPlaces left = passing(frame, from, to, ahead, step, how);
    if (part == 0) passing_now_ = left.seeds;
    if (left.seeds > 0 && part > 0 && how.accuracy < least_in_noise * noise * target.diagonal())
      break;
    how.left_of_template = left.of_template;
    how.left_of_target = left.of_target;
    how.outgrown =
        left.seeds > 0 ? RemeshOptions::Outgrown::left : RemeshOptions::Outgrown::replaced;
    // What is a little distorted waits until something changes anyway.
    const auto rest = rest_without(left, surface_.mesh, template_->known.rest);
    how.rest = rest;
    if (left.asked > 0 || worst_distortion(surface_.mesh, rest) > most_distortion) {
      found = remesh(from, to, how, progress.step("remesh", part > 0 ? 0.1 : 0.5));
      tolerance = found->tolerance;
    }
    if (p95_without(left, nearest, found, target) <= within) break;
  }
  return found;
}

/// Replaces what of the template does not show the frame, or all of it; whether it did.
bool TemplateFollower::remesh_frame(CapturedFrame& frame, const FrameAhead& ahead, double step,
                                    FollowedFrame& found, const Progress& progress) {
  const Stopwatch watch;
  const std::optional<Remeshed> remeshed = remeshed_within(frame, ahead, step, progress);
  found.passing = passing_now_;
  count_passing(found);
  const bool changes = remeshed && (remeshed->added > 0 || remeshed->removed > 0);
  if (changes && options_.remeshing == Remeshing::keyframes)
    begin(frame, step, found);
  else if (changes)
    replace_parts(frame, step, *remeshed, found);
  found.match->remesh_seconds = watch.seconds();
  measure(frame, found);
  return changes;
}

void TemplateFollower::replace_parts(CapturedFrame& frame, double step, const Remeshed& remeshed,
                                     FollowedFrame& found) {
  const EvolvingSegment next = remeshed_segment(remeshed, segment(), next_vertex_, next_triangle_);
  const std::vector<Vector3> positions =
      rounded(unfolded_onto(frame.target(), remeshed.mesh), step);
  previous_ = positions_before(segment(), previous_, next, positions);
  set_template(carried_on(frame, next, positions));
  count_ids(next);
  found.distance = surface_distance(template_->known.mesh(), frame.target());
  found.distortion = distortion(template_->known, positions_);
  found.kept = remeshed.kept;
  found.added = remeshed.added;
  found.removed = remeshed.removed;
  found.replaced =
      FollowedFrame::Replacement{remeshed.distorted, remeshed.template_seeds, remeshed.target_seeds,
                                 remeshed.reached, remeshed.rounds};
}

/// The template of a segment that remeshing made of the one that is followed.
TrackTemplate TemplateFollower::carried_on(CapturedFrame& frame, const EvolvingSegment& next,
                                           const std::vector<Vector3>& positions) const {
  const MaterialFrame* truth = frame.has_truth() ? &frame.truth() : nullptr;
  return carried(template_->known, next, positions, frame.target(), truth);
}

void TemplateFollower::set_template(TrackTemplate next) {
  ahead_.clear();
  positions_ = next.start;
  surface_ = make_surface(next.mesh(), {.kind = WeldOptions::Kind::none});
  template_ = std::make_unique<Template>(std::move(next), mean_edge_length(surface_),
                                         track_options(options_));
}

void TemplateFollower::count_ids(const EvolvingSegment& of) {
  for (const int id : of.vertex_ids) next_vertex_ = std::max(next_vertex_, id + 1);
  for (const int id : of.triangle_ids) next_triangle_ = std::max(next_triangle_, id + 1);
}

void TemplateFollower::measure(CapturedFrame& frame, FollowedFrame& found) const {
  found.manifold = is_manifold(surface_);
  found.folded = int(folded_triangles(surface_).size());
  if (!frame.has_truth()) return;
  const DriftSummary drifted =
      summary(drift(positions_, template_->known.material, frame.truth(), frame.truth_tolerance()));
  found.drift = FollowedFrame::Drift{drifted, drifted.mean / template_->edge};
}

void TemplateFollower::take_up(int number, std::vector<Vector3> positions, std::vector<Vector3> previous) {
  ahead_.clear();
  last_ = number;
  positions_ = std::move(positions);
  if (!previous.empty()) previous_ = std::move(previous);
}

bool TemplateFollower::take_up(CapturedFrame& frame, double step, const EvolvingSegment& next,
                               const std::vector<Vector3>& positions) {
  if (follows() && change(segment(), next).kept > 0) {
    previous_ = positions_before(segment(), positions_, next, positions);
    set_template(carried_on(frame, next, positions));
  } else {
    previous_.clear();
    set_template(frame.as_template(step, next_vertex_, next_triangle_));
    if (segment().triangles != next.triangles) return false;
  }
  count_ids(next);
  return true;
}

}  // namespace mq

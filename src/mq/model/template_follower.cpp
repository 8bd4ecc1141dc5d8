// A frame is followed with what the last one left; where that does not show it, the template is
// replaced, here and there or as a whole, and what is kept of it goes on with its ids.
#include "mq/model/template_follower.h"

#include <algorithm>
#include <array>
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
/// less, until they keep it.
constexpr std::array accuracies_in_within = {4.0, 2.0, 1.0, 0.5};
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
  found.match = FollowedFrame::Match{tracked.matched, tracked.predicted, tracked.seconds, {}};
  found.kept = triangles;
  found.added = found.removed = 0;
}

/// Replaces what of the template does not show the frame: at first what is two edges off, and less
/// and less where too many points are farther than wanted.
Remeshed remeshed_within(const Surface& tracked, const TrackTarget& target,
                         std::span<const std::array<Vector3, 3>> rest, double within,
                         const Progress& progress) {
  const double far = within * target.diagonal();
  const ClosestPointFinder on_tracked(tracked.mesh);
  const SearchedSurface from{tracked, on_tracked}, to{target.surface(), target.closest()};
  RemeshOptions how{.farthest = farthest_in_within * far, .rest = rest};
  Remeshed found = remesh(from, to, how, progress.step("remesh", 0.5));
  double p95 = surface_distance(found.mesh, target).p95;
  for (const double part : accuracies_in_within) {
    if (p95 <= within) break;
    how.accuracy = part * far;
    if (how.accuracy < found.tolerance) {
      found = remesh(from, to, how, progress.step("remesh", 0.1));
      p95 = surface_distance(found.mesh, target).p95;
    }
  }
  return found;
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

TemplateFollower::Segment TemplateFollower::follow(CapturedFrame& frame, double step,
                                                   FollowedFrame& found, const Progress& progress) {
  bool begun = !follows();
  if (!begun) {
    TrackedFrame tracked = template_->tracker.follow(positions_, previous_, frame.target(),
                                                     progress.step("follow", 0.7));
    tracked.distortion = distortion(template_->known, tracked.positions);
    begun = options_.restart && tracked.distance.p95 > *options_.restart;
    if (!begun) {
      previous_ = std::move(positions_);
      put(tracked, segment().triangle_count(), found);
      positions_ = rounded(std::move(tracked.positions), step);
      surface_ = make_surface(mesh(), {.kind = WeldOptions::Kind::none});
      if (options_.remeshing != Remeshing::none)
        return remesh_frame(frame, step, found, progress.step("remesh", 0.3)) ? Segment::begun
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

/// Replaces what of the template does not show the frame, or all of it; whether it did.
bool TemplateFollower::remesh_frame(CapturedFrame& frame, double step, FollowedFrame& found,
                                    const Progress& progress) {
  const Stopwatch watch;
  const Remeshed remeshed =
      remeshed_within(surface_, frame.target(), template_->known.rest, options_.within, progress);
  const bool changes = remeshed.added > 0 || remeshed.removed > 0;
  if (changes && options_.remeshing == Remeshing::keyframes)
    begin(frame, step, found);
  else if (changes)
    replace_parts(frame, step, remeshed, found);
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

void TemplateFollower::take_up(std::vector<Vector3> positions, std::vector<Vector3> previous) {
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

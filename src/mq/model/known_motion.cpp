#include "mq/model/known_motion.h"

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/mesh/closest_point.h"
#include "mq/mesh/surface_point.h"
#include "mq/track/track_template.h"

namespace mq {
namespace {

/// Whether a part replaced triangles in this frame only as they were distorted: the surface stayed what it was. What
/// comes, goes or parts moves unlike what is around it.
bool is_made_anew_in_place(const StoredFrame& frame) {
  const auto replaced = followed_frame(frame.number, frame.measured).replaced;
  return replaced && replaced->template_seeds == 0 && replaced->target_seeds == 0;
}

}  // namespace

StoredMotion::StoredMotion(const std::vector<std::filesystem::path>& stores) {
  for (const std::filesystem::path& path : stores) {
    stores_.push_back(std::make_unique<EvolvingReader>(path));
    const EvolvingReader& store = *stores_.back();
    require(store.broken().empty(), fmt::format("{}: {}; go on with that part where it was stopped, or make it again",
                                                path.string(), store.broken()));
    for (std::size_t f = 0; f < store.frames().size(); ++f) {
      const int number = store.frames()[f].number;
      const auto [at, is_new] = places_.try_emplace(number, Place{int(stores_.size()) - 1, int(f)});
      if (!is_new)
        throw InvalidInput(fmt::format(
            "{}: frame {} is in {} too: parts of a sequence have each of its frames once; leave one of them out",
            path.string(), number, stores_[std::size_t(at->second.store)]->manifest().string()));
    }
  }
}

std::optional<std::vector<Vector3>> StoredMotion::moved(int before, int after, std::span<const Vector3> points) const {
  const auto from = places_.find(before), to = places_.find(after);
  if (from == places_.end() || to == places_.end() || from->second.store != to->second.store ||
      from->second.frame + 1 != to->second.frame)
    return {};
  const EvolvingReader& store = *stores_[std::size_t(from->second.store)];
  const StoredFrame &first = store.frames()[std::size_t(from->second.frame)],
                    &next = store.frames()[std::size_t(to->second.frame)];
  if (first.segment != next.segment && !is_made_anew_in_place(next)) return {};
  const EvolvingSegment segment = store.segment(first.segment);
  const Mesh mesh = mesh_of(segment, store.positions(from->second.frame));
  std::vector<Vector3> there = store.positions(to->second.frame);
  if (first.segment != next.segment)
    there = positions_before(store.segment(next.segment), there, segment, mesh.positions);
  const std::vector<ClosestPoint> nearest = ClosestPointFinder(mesh)(points);
  std::vector<Vector3> result(points.begin(), points.end());
  for (std::size_t i = 0; i < result.size(); ++i)
    result[i] += value_at(mesh, there, nearest[i]) - point_at(mesh, nearest[i]);
  return result;
}

void StoredMotion::require_made_of(int frame, const std::vector<KnownFile>& files) const {
  const auto place = places_.find(frame);
  if (place == places_.end()) return;
  const EvolvingReader& store = *stores_[std::size_t(place->second.store)];
  const FollowedFrame known = followed_frame(frame, store.frames()[std::size_t(place->second.frame)].measured);
  // The first is the mesh; pictures may be used by one and not by the other.
  if (known.files.empty() || files.empty() || known.files.front().print == files.front().print) return;
  throw InvalidInput(fmt::format("{} followed another file as frame {}, of {} bytes where {} has {} now: make that "
                                 "part again",
                                 store.manifest().string(), frame, known.files.front().print.bytes,
                                 files.front().name, files.front().print.bytes));
}

}  // namespace mq

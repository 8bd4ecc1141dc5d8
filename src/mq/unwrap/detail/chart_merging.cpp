#include "mq/unwrap/detail/chart_merging.h"

#include <algorithm>

#include "mq/base/error.h"

namespace mq {

ChartMerging::ChartMerging(const Surface& surface, const std::vector<int>& patches, int count)
    : surface_(&surface),
      charts_(patches),
      merged_(surface.twins.size()),
      members_(std::size_t(count)),
      parents_(std::size_t(count), -1),
      parts_(std::size_t(count), {-1, -1}) {
  for (int t = 0; t < surface.triangle_count(); ++t)
    if (patches[t] >= 0) members_[patches[t]].push_back(t);
  for (HalfEdge h = 0; h < HalfEdge(merged_.size()); ++h)
    merged_[h] = surface.twins[h] >= 0 && patches[h / 3] >= 0 &&
                 patches[h / 3] == patches[surface.twins[h] / 3];
}

HalfEdge ChartMerging::next_at_boundary(HalfEdge h) const {
  h = next(h);
  while (merged_[h]) h = next(surface_->twins[h]);
  return h;
}

std::vector<std::vector<HalfEdge>> ChartMerging::loops(int chart) const {
  std::vector<HalfEdge> boundary;
  for (const int t : members_[chart])
    for (int k = 0; k < 3; ++k)
      if (!merged_[3 * t + k]) boundary.push_back(3 * t + k);
  std::ranges::sort(boundary);
  std::vector<char> seen(boundary.size());
  std::vector<std::vector<HalfEdge>> loops;
  for (std::size_t i = 0; i < boundary.size(); ++i) {
    if (seen[i]) continue;
    loops.emplace_back();
    HalfEdge h = boundary[i];
    do {
      loops.back().push_back(h);
      seen[std::size_t(std::ranges::lower_bound(boundary, h) - boundary.begin())] = 1;
      h = next_at_boundary(h);
    } while (h != boundary[i]);
  }
  return loops;
}

/// Whether the boundary runs from h to `after` on this side, and back on the other; not at the end
/// of a cut, where it turns.
bool ChartMerging::follows(HalfEdge h, HalfEdge after) const {
  return surface_->twins[h] != after &&
         next_at_boundary(surface_->twins[after]) == surface_->twins[h];
}

void ChartMerging::add_seams(int chart, const std::vector<HalfEdge>& loop,
                             std::vector<ChartSeam>& seams) const {
  const int count = int(loop.size());
  const auto other = [&](int i) {
    const HalfEdge twin = surface_->twins[loop[i % count]];
    return twin < 0 ? -1 : charts_[twin / 3];
  };
  const auto goes_on = [&](int i) {  // from edge i to the one after it
    return other(i) >= 0 && other(i) == other(i + 1) &&
           follows(loop[i % count], loop[(i + 1) % count]);
  };
  int begin = 0;
  while (begin < count && goes_on(begin)) ++begin;
  for (int i = begin + 1; i <= begin + count; ++i) {
    if (other(i) < 0) continue;
    if (i == begin + 1 || !goes_on(i - 1)) seams.push_back({{chart, other(i)}, {}, 0});
    const HalfEdge h = loop[i % count];
    seams.back().edges.push_back(h);
    seams.back().length +=
        (surface_->mesh.position(h / 3, (h + 1) % 3) - surface_->mesh.position(h / 3, h % 3))
            .norm();
  }
}

std::vector<ChartSeam> ChartMerging::seams(int chart) const {
  std::vector<ChartSeam> seams;
  for (const std::vector<HalfEdge>& loop : loops(chart)) add_seams(chart, loop, seams);
  // Of the two sides of a cut one will do.
  std::erase_if(seams, [&](const ChartSeam& seam) {
    return seam.charts[0] == seam.charts[1] &&
           seam.edges.front() > surface_->twins[seam.edges.back()];
  });
  return seams;
}

bool ChartMerging::closes(const ChartSeam& seam) const {
  const auto boundary = [&](int chart) {
    std::size_t count = 0;
    for (const int t : members_[chart])
      for (int k = 0; k < 3; ++k) count += !merged_[3 * t + k];
    return count;
  };
  const auto [a, b] = seam.charts;
  return boundary(a) + (a == b ? 0 : boundary(b)) == 2 * seam.edges.size();
}

std::vector<HalfEdge> ChartMerging::joined(const ChartSeam& seam) const {
  std::vector<HalfEdge> both = seam.edges;
  for (const HalfEdge h : seam.edges) both.push_back(surface_->twins[h]);
  return both;
}

int ChartMerging::merge(const ChartSeam& seam) {
  const auto [a, b] = seam.charts;
  require(is_whole(a) && is_whole(b), "charts to merge must be whole");
  const int fresh = chart_count();
  std::vector<int> members = members_[a];
  if (a != b) members.insert(members.end(), members_[b].begin(), members_[b].end());
  for (const int t : members) charts_[t] = fresh;
  for (const HalfEdge h : joined(seam)) merged_[h] = 1;
  members_.push_back(std::move(members));
  parents_.push_back(-1);
  parts_.push_back({a, a == b ? -1 : b});
  parents_[a] = parents_[b] = fresh;
  return fresh;
}

int ChartMerging::joint(int chart, int triangle, int other) const {
  const auto has = [&](int part, int t) {
    return std::ranges::find(members_[part], t) != members_[part].end();
  };
  for (;;) {
    const auto [a, b] = parts_[chart];
    if (a < 0) return chart;
    if (b < 0 || (has(a, triangle) && has(a, other)))
      chart = a;
    else if (has(b, triangle) && has(b, other))
      chart = b;
    else
      return chart;
  }
}

}  // namespace mq

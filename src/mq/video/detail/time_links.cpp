#include "mq/video/detail/time_links.h"

#include <algorithm>
#include <unordered_map>

#include "mq/base/error.h"
#include "mq/video/texel_owners.h"

namespace mq {
namespace {

/// Texels of a seam's other side lie at most this far outside of their chart.
constexpr double reach = 2;

/// Per pixel of a texture the unknown that it is, or -1.
std::vector<int> unknown_at(const Texels& texels, int width, int height) {
  std::vector<int> result(std::size_t(width) * height, -1);
  for (int t = 0; t < texels.size(); ++t)
    result[std::size_t(texels.places[t].y) * width + texels.places[t].x] = t;
  return result;
}

/// Whether a triangle that lives in two segments has the same texture coordinates in both, and
/// where each of its corners in the one is in the other.
struct Twin {
  int triangle = -1;  // of the segment before
  std::array<int, 3> corner = {0, 1, 2};
  bool moved = false;
};

Twin twin(const EvolvingSegment& before, const EvolvingSegment& after, int b, int a) {
  Twin result{b, {0, 1, 2}, false};
  for (int k = 0; k < 3; ++k) {
    for (int l = 0; l < 3; ++l)
      if (before.vertex_ids[before.triangles[b][l]] == after.vertex_ids[after.triangles[a][k]])
        result.corner[k] = l;
    result.moved = result.moved || before.uvs[before.corner_uvs[b][result.corner[k]]] !=
                                       after.uvs[after.corner_uvs[a][k]];
  }
  return result;
}

/// Per triangle of `after` its twin.
std::vector<Twin> twins(const EvolvingSegment& before, const EvolvingSegment& after) {
  std::unordered_map<int, int> index;
  for (int t = 0; t < before.triangle_count(); ++t) index[before.triangle_ids[t]] = t;
  std::vector<Twin> result(after.triangles.size());
  for (int t = 0; t < after.triangle_count(); ++t)
    if (const auto found = index.find(after.triangle_ids[t]); found != index.end())
      result[t] = twin(before, after, found->second, t);
  return result;
}

}  // namespace

int TimeLinks::nearest(int row) const {
  int best = -1;
  double weight = 0;
  for (int e = starts[row]; e < starts[row + 1]; ++e)
    if (entries[e].weight > weight) best = entries[e].column, weight = entries[e].weight;
  return best;
}

TimeLinks identical_links(int count) {
  TimeLinks links;
  for (int i = 0; i < count; ++i) {
    links.entries.push_back({i, 1.0});
    links.starts.push_back(i + 1);
  }
  return links;
}

AtlasFrame::AtlasFrame(const EvolvingSegment& segment, const std::vector<Vector3>& positions,
                       int width, int height, const Progress& progress)
    : segment_(segment) {
  require(!segment.uvs.empty(), "the evolving mesh has no texture coordinates");
  surface_ = std::make_unique<Surface>(
      make_surface(mesh_of(segment, positions), {.kind = WeldOptions::Kind::none}));
  atlas_ = std::make_unique<Atlas>(make_atlas(*surface_, {{.width = width, .height = height}}));
  space_ = std::make_unique<TexelSpace>(*surface_, *atlas_, TexelSpaceOptions{}, progress);
}

TimeLinks texel_links(const AtlasFrame& before, const AtlasFrame& after) {
  const int width = after.atlas().textures[0].width, height = after.atlas().textures[0].height;
  const std::vector<int> unknown = unknown_at(before.space().texels(), width, height);
  const Texels& texels = after.space().texels();
  const bool one_segment = before.segment().triangle_ids == after.segment().triangle_ids &&
                           before.segment().uvs == after.segment().uvs;
  const TexelOwners owners(after.surface().mesh, one_segment ? 0 : width, one_segment ? 0 : height,
                           1, reach);
  const std::vector<Twin> twin_of =
      one_segment ? std::vector<Twin>() : twins(before.segment(), after.segment());
  TimeLinks links;
  const auto link_itself = [&](int x, int y) {
    const int t = unknown[std::size_t(y) * width + x];
    if (t >= 0) links.entries.push_back({t, 1.0});
  };
  const auto link_by_triangle = [&](int x, int y) {
    const TexelOwners::Owner& owner = owners.owner(x, y);
    if (owner.triangle < 0 || twin_of[owner.triangle].triangle < 0) return;
    const Twin& there = twin_of[owner.triangle];
    if (!there.moved) return link_itself(x, y);
    if (owner.distance > 0 || before.atlas().chart[there.triangle] < 0) return;
    const Vector3 b = nearest_in_triangle(owners.corners(owner.triangle), owners.place(x, y));
    Vector3 was;
    for (int k = 0; k < 3; ++k) was[there.corner[k]] = b[k];
    for (const BasisWeight& w : before.space().basis_at(there.triangle, was))
      links.entries.push_back({w.unknown, w.weight});
  };
  for (int t = 0; t < texels.size(); ++t) {
    const Texels::Place& place = texels.places[t];
    if (one_segment)
      link_itself(place.x, place.y);
    else
      link_by_triangle(place.x, place.y);
    links.starts.push_back(int(links.entries.size()));
  }
  return links;
}

}  // namespace mq

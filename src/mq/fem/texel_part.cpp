// Which cells a part needs. A row of the matrix is complete where all cells around its texel are integrated, and all
// cells near seams whose functions the texel takes part in. These are found along the seams, stretch by stretch
// between two texel lines, from the very terms that the functions are made of (`Seams::add_value`): where one of a
// stretch's places lies near what is needed, all of them are. Twice: cells that are needed couple among themselves
// what other stretches bring. All this is generous by a texel or two; a test compares the rows.

#include "mq/fem/texel_part.h"

#include <algorithm>
#include <cmath>

#include "mq/atlas/texel_grid.h"
#include "mq/fem/detail/part_window.h"
#include "mq/fem/detail/shown_places.h"

namespace mq {
namespace {

/// Texels between an own texel and a place of a seam that may have to do with its row or with those of the texels
/// beside it, which decide how weak texels are held.
constexpr int near = 3;

/// Triangles that meet what is needed, and all that share a vertex with these, so that everything around a vertex
/// is there.
std::vector<char> needed_triangles(const Surface& surface, const Atlas& atlas, const PartWindows& windows) {
  std::vector<char> needed(atlas.chart.size(), 0), touched(std::size_t(surface.mesh.vertex_count()), 0);
  for (std::size_t t = 0; t < needed.size(); ++t) {
    if (atlas.chart[t] < 0 || !windows.meets(surface.mesh.texture(int(t)), atlas.corners[t])) continue;
    for (const int v : surface.mesh.triangles[t]) touched[std::size_t(v)] = 1;
  }
  for (std::size_t t = 0; t < needed.size(); ++t)
    needed[t] = atlas.chart[t] >= 0 && std::ranges::any_of(surface.mesh.triangles[t], [&](int v) {
                  return touched[std::size_t(v)] != 0;
                });
  return needed;
}

/// The atlas with these triangles alone, in textures that are cut down to the windows.
Atlas part_of_atlas(const Surface& surface, const Atlas& atlas, const std::vector<char>& needed,
                    const PartWindows& windows) {
  Atlas part = atlas;
  part.texel_area = 0;
  part.defects.clear();
  for (std::size_t t = 0; t < needed.size(); ++t) {
    if (!needed[t]) {
      part.chart[t] = -1;
      continue;
    }
    const PartWindows::Window& window = windows.of(surface.mesh.texture(int(t)));
    auto& p = part.corners[t];
    for (TexelPoint& corner : p) corner.x -= window.x0 * TexelPoint::one, corner.y -= window.y0 * TexelPoint::one;
    part.texel_area += 0.5 * std::abs(double(orientation(p[0], p[1], p[2]))) / double(TexelPoint::one) /
                       double(TexelPoint::one);
  }
  for (HalfEdge h = 0; h < HalfEdge(part.edges.size()); ++h)
    if (part.chart[std::size_t(h / 3)] >= 0 && part.edges[std::size_t(h)] != EdgeKind::boundary &&
        part.chart[std::size_t(surface.twins[std::size_t(h)] / 3)] < 0)
      part.edges[std::size_t(h)] = EdgeKind::boundary;
  for (std::size_t k = 0; k < part.textures.size(); ++k) {
    const PartWindows::Window& window = windows.of(int(k));
    part.textures[k].width = std::max(1, window.x1 - window.x0);
    part.textures[k].height = std::max(1, window.y1 - window.y0);
  }
  // Areas of texels are taken to be those of the whole.
  part.surface_area = part.texel_area * (atlas.surface_area / atlas.texel_area);
  return part;
}

/// Every place of the stretches of seams near `windows` is added to them.
void add_seams(const Seams& seams, PartWindows& windows) {
  std::vector<SeamTerm> terms;
  std::vector<TexturePlace> found;
  for (int e = 0; e < seams.count(); ++e) {
    const auto breaks = seams.breaks(e);
    for (std::size_t i = 1; i < breaks.size(); ++i) {
      terms.clear();
      seams.add_value(e, (breaks[i - 1] + breaks[i]) / 2, terms);
      if (std::ranges::none_of(terms, [&](const SeamTerm& term) { return windows.is_near(term.place); })) continue;
      for (const SeamTerm& term : terms) found.push_back(term.place);
    }
  }
  for (const TexturePlace& place : found) windows.add(place);
}

}  // namespace

TexelPart::TexelPart(const Surface& surface, const Atlas& atlas, const Seams& seams, const BlockOwners& owners,
                     int part, const TexelSpaceOptions& how, const Progress& progress)
    : surface_(surface), part_(part) {
  PartWindows windows(atlas, owners, part, near);
  if (windows.empty()) return;
  add_seams(seams, windows);
  add_seams(seams, windows);
  windows.close();
  atlas_ = std::make_unique<Atlas>(part_of_atlas(surface, atlas, needed_triangles(surface, atlas, windows), windows));
  progress.step("find the halo", 0.1).at(1);
  if (std::ranges::none_of(atlas_->chart, [](int chart) { return chart >= 0; })) return;
  TexelSpaceOptions options = how;
  options.cells = windows.cells(*atlas_);
  space_ = std::make_unique<TexelSpace>(surface, *atlas_, options, progress.step("space", 0.9));
  places_ = space_->texels().places;
  owner_.resize(places_.size());
  for (int i = 0; i < space_->size(); ++i) {
    Texels::Place& place = places_[std::size_t(i)];
    const PartWindows::Window& window = windows.of(place.texture);
    place.x += window.x0;
    place.y += window.y0;
    owner_[std::size_t(i)] = owners(place);
    if (owner_[std::size_t(i)] == part) own_.push_back(i);
  }
}

TexelPart::~TexelPart() = default;

bool TexelPart::has_texture(int texture) const {
  return std::ranges::any_of(own_, [&](int i) { return places_[std::size_t(i)].texture == texture; });
}

/// Where the part ends, but not the whole, no own function is left.
std::vector<int> TexelPart::boundary() const {
  std::vector<int> own = space_->boundary();
  std::erase_if(own, [&](int i) { return owner_[std::size_t(i)] != part_; });
  return own;
}

/// Points where an own function counts: there all others are as in the whole.
ShownPlaces TexelPart::shown() const {
  ShownPlaces places;
  const auto is_own = [&](int i) { return owner_[std::size_t(i)] == part_; };
  for_each_shown(
      surface_, *atlas_, *space_,
      [&](int i) {
        if (is_own(i)) places.covered_.push_back(i);
      },
      [&](int triangle, const Vector3& barycentric) {
        const std::vector<BasisWeight> terms = space_->basis_at(triangle, barycentric);
        if (std::ranges::none_of(terms, is_own, &BasisWeight::unknown)) return;
        places.weights_.insert(places.weights_.end(), terms.begin(), terms.end());
        places.ends_.push_back(int(places.weights_.size()));
      });
  return places;
}

double ShownPlaces::largest(const Vector& values) const {
  double largest = 0;
  const auto look_at = [&](double value) {
    if (std::isfinite(value)) largest = std::max(largest, value);
  };
  for (const int i : covered_) look_at(values[i]);
  for (std::size_t p = 0, k = 0; p < ends_.size(); ++p) {
    double sum = 0;
    for (; k < std::size_t(ends_[p]); ++k) sum += weights_[k].weight * values[weights_[k].unknown];
    look_at(sum);
  }
  return largest;
}

void TexelPart::let_go_of_space() {
  space_.reset();
  atlas_.reset();
}

}  // namespace mq

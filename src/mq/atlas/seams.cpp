// At a point p of a seam with copies p_1 ... p_m in the textures, a function bilinear in each chart
// has m values; the seam-continuous one takes their mean (thesis 5.5, step 2). Where three charts
// meet, the mean over three copies at the vertex and the mean over two on the edges beside it
// differ by a finite amount, which no mesh of nodes may see jump over a short edge; so the
// difference is faded out along the edge, over `blend` texels of its shorter side.

#include "mq/atlas/seams.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace mq {
namespace {

/// Crossings nearer to each other than this, in texels of the longer side, are one.
constexpr double same_crossing = 1e-9;
/// Fractions nearer than this to a texel line are on it: rounding of interpolated points.
constexpr double on_line = 1e-12;

TexturePlace place_at(int texture, const TexelPoint& a, const TexelPoint& b, double s) {
  const auto split = [&](std::int64_t from, std::int64_t to, int& cell, double& fraction) {
    const long double offset = (long double)(s) * (long double)(to - from);
    const long double whole = std::floor(offset);
    const std::int64_t at = from + std::int64_t(whole);
    cell = floor_texel(at);
    fraction = double(((long double)(at & (TexelPoint::one - 1)) + (offset - whole)) /
                      (long double)(TexelPoint::one));
    if (fraction > 1 - on_line) ++cell, fraction = 0;
    if (fraction < on_line) fraction = 0;
  };
  TexturePlace place{texture};
  split(a.x, b.x, place.column, place.x);
  split(a.y, b.y, place.row, place.y);
  return place;
}

double texel_distance(const TexelPoint& a, const TexelPoint& b) {
  return std::hypot(double(b.x - a.x), double(b.y - a.y)) / double(TexelPoint::one);
}

/// Parameters in (0, 1) at which the segment crosses texel lines.
void add_crossings(std::int64_t from, std::int64_t to, std::vector<double>& at) {
  const auto [low, high] = std::minmax(from, to);
  for (std::int64_t line = floor_texel(low) + 1; line * TexelPoint::one < high; ++line)
    at.push_back(double(line * TexelPoint::one - from) / double(to - from));
}

auto key(const TexturePlace& p) { return std::tie(p.texture, p.row, p.column, p.y, p.x); }

}  // namespace

Seams::Seams(const Surface& surface, const Atlas& atlas) : surface_(surface), atlas_(atlas) {
  seam_.assign(atlas.edges.size(), -1);
  for (HalfEdge h = 0; h < HalfEdge(atlas.edges.size()); ++h) {
    if (atlas.chart[h / 3] < 0 || atlas.edges[h] != EdgeKind::seam || surface.twins[h] < h)
      continue;
    seam_[h] = seam_[surface.twins[h]] = count();
    first_.push_back(h);
    second_.push_back(surface.twins[h]);
  }
  find_vertices();
  find_breaks();
}

TexelPoint Seams::end_point(HalfEdge h, int end) const {
  const bool at_start = (first_[seam_[h]] == h) == (end == 0);
  const int corner = at_start ? h : next(h);
  return atlas_.corners[corner / 3][corner % 3];
}

TexturePlace Seams::place(HalfEdge h, double s) const {
  return place_at(surface_.mesh.texture(h / 3), end_point(h, 0), end_point(h, 1), s);
}

void Seams::find_breaks() {
  offsets_.assign(1, 0);
  std::vector<double> at;
  for (int e = 0; e < count(); ++e) {
    at.clear();
    double longest = 0, shortest = HUGE_VAL;
    for (HalfEdge h : half_edges(e)) {
      const TexelPoint a = end_point(h, 0), b = end_point(h, 1);
      add_crossings(a.x, b.x, at);
      add_crossings(a.y, b.y, at);
      longest = std::max(longest, texel_distance(a, b));
      shortest = std::min(shortest, texel_distance(a, b));
    }
    length_.push_back(shortest);
    if (const double reach = 1 / blend_rate(e); reach < 1) {
      if (blends(e, 0)) at.push_back(reach);
      if (blends(e, 1)) at.push_back(1 - reach);
    }
    std::sort(at.begin(), at.end());
    const double same = same_crossing / longest;
    breaks_.push_back(0);
    for (double s : at)
      if (s - breaks_.back() > same && 1 - s > same) breaks_.push_back(s);
    breaks_.push_back(1);
    offsets_.push_back(int(breaks_.size()));
  }
}

void Seams::find_vertices() {
  // Corners around a vertex are joined across every edge that the surface continues over.
  std::vector<int> parent(atlas_.edges.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int c) {
    while (parent[c] != c) c = parent[c] = parent[parent[c]];
    return c;
  };
  const auto join = [&](int a, int b) {
    a = root(a), b = root(b);
    if (a != b) parent[std::max(a, b)] = std::min(a, b);
  };
  std::vector<char> touched(atlas_.edges.size());
  for (HalfEdge h = 0; h < HalfEdge(atlas_.edges.size()); ++h) {
    if (atlas_.chart[h / 3] < 0 || atlas_.edges[h] == EdgeKind::boundary) continue;
    const HalfEdge twin = surface_.twins[h];
    join(h, next(twin));
    join(next(h), twin);
  }
  for (HalfEdge h = 0; h < HalfEdge(atlas_.edges.size()); ++h)
    if (seam_[h] >= 0) touched[root(h)] = touched[root(next(h))] = 1;

  std::vector<std::pair<int, int>> members;  // root, corner
  for (int c = 0; c < int(parent.size()); ++c)
    if (atlas_.chart[c / 3] >= 0 && touched[root(c)]) members.push_back({root(c), c});
  std::sort(members.begin(), members.end());

  class_.assign(parent.size(), -1);
  class_offsets_.assign(1, 0);
  std::vector<TexturePlace> places;
  for (std::size_t begin = 0, end; begin < members.size(); begin = end) {
    places.clear();
    for (end = begin; end < members.size() && members[end].first == members[begin].first; ++end) {
      const int c = members[end].second;
      const TexelPoint& p = atlas_.corners[c / 3][c % 3];
      places.push_back(place_at(surface_.mesh.texture(c / 3), p, p, 0));
    }
    std::sort(places.begin(), places.end(),
              [](const auto& a, const auto& b) { return key(a) < key(b); });
    places.erase(std::unique(places.begin(), places.end(),
                             [](const auto& a, const auto& b) { return key(a) == key(b); }),
                 places.end());
    for (std::size_t k = begin; k < end; ++k)
      class_[members[k].second] = int(class_offsets_.size()) - 1;
    copies_.insert(copies_.end(), places.begin(), places.end());
    class_offsets_.push_back(int(copies_.size()));
  }
}

std::span<const TexturePlace> Seams::copies(int corner) const {
  const int c = class_[corner];
  if (c < 0) return {};
  return {copies_.data() + class_offsets_[c],
          std::size_t(class_offsets_[c + 1] - class_offsets_[c])};
}

SeamTerm Seams::side(HalfEdge h, double s0, double weight) const {
  const TexelPoint a = end_point(h, 0), b = end_point(h, 1);
  return {place(h, s0), weight, 0, double(b.x - a.x) / double(TexelPoint::one),
          double(b.y - a.y) / double(TexelPoint::one)};
}

/// Whether the value at an end differs from the mean of the two sides.
bool Seams::blends(int seam, int end) const {
  const auto places = copies(end == 0 ? first_[seam] : next(first_[seam]));
  if (places.size() == 1) return false;
  return places.size() > 2 || key(place(first_[seam], end)) == key(place(second_[seam], end));
}

/// Of the weight of an end's value, per unit of s: over `blend` texels or the whole seam.
double Seams::blend_rate(int seam) const { return std::max(length_[seam] / blend, 1.0); }

void Seams::add_end(int seam, double s0, int end, std::vector<SeamTerm>& value) const {
  const double slope = blend_rate(seam);
  const double weight = 1 - (end == 0 ? s0 : 1 - s0) * slope;
  if (weight <= 0 || !blends(seam, end)) return;
  const double rate = end == 0 ? -slope : slope;
  const HalfEdge first = first_[seam];
  const auto places = copies(end == 0 ? first : next(first));
  const double count = double(places.size());
  for (const TexturePlace& p : places) value.push_back({p, weight / count, rate / count, 0, 0});
  for (HalfEdge h : half_edges(seam))
    value.push_back({place(h, end), -weight / 2, -rate / 2, 0, 0});
}

void Seams::add_value(int seam, double s0, std::vector<SeamTerm>& value) const {
  for (HalfEdge h : half_edges(seam)) value.push_back(side(h, s0, 0.5));
  add_end(seam, s0, 0, value);
  add_end(seam, s0, 1, value);
}

}  // namespace mq

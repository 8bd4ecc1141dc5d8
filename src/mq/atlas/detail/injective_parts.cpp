// A texel's box is all that is closer to it than one column and one row: where its bilinear
// function is not 0. Two places of a chart meet in a box only where a border of the chart runs
// through it, or where one layer lies on another all over it, and then on the texel's centre, too.
// So only there the triangles that meet the box are listed and joined where they hang together;
// what stays apart are the places.

#include "mq/atlas/detail/injective_parts.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "mq/atlas/detail/coverage_of_texture.h"
#include "mq/image/resample.h"
#include "mq/image/wrap.h"

namespace mq {
namespace {

/// A texel, before any wrapping, that a triangle reads.
struct Reading {
  int chart, row, column, triangle;
  auto texel() const { return std::tuple(chart, row, column); }
};

/// One of several places that a texel of a chart stands for, and a triangle there.
struct PlaceOf {
  int triangle;
  int texel;  ///< numbered among those that stand for several
  int place;
};

bool turns_positive(const Atlas& atlas, int triangle) {
  const auto& p = atlas.corners[std::size_t(triangle)];
  return orientation(p[0], p[1], p[2]) > 0;
}

/// Whether the triangles at an edge lie one beside the other in their chart; a fold lies on itself.
bool lies_flat(const Surface& surface, const Atlas& atlas, HalfEdge h) {
  return atlas.edges[std::size_t(h)] == EdgeKind::inside &&
         turns_positive(atlas, h / 3) == turns_positive(atlas, surface.twins[std::size_t(h)] / 3);
}

/// Per texel of one texture whether it may stand for several places of one chart.
class Suspects {
 public:
  Suspects(const Surface& surface, const Atlas& atlas, int texture)
      : atlas_(atlas), wrap_(atlas.textures[std::size_t(texture)].wrap) {
    const Image<int> count = coverage_of_texture(surface, atlas, texture).count;
    marks_ = Image<char>(count.width(), count.height(), 1);
    for (int y = 0; y < count.height(); ++y)
      for (int x = 0; x < count.width(); ++x) marks_(x, y) = count(x, y) > 1;
    for (HalfEdge h = 0; h < HalfEdge(atlas.edges.size()); ++h)
      if (atlas.chart[std::size_t(h / 3)] >= 0 && surface.mesh.texture(h / 3) == texture &&
          !lies_flat(surface, atlas, h))
        mark_along(h);
  }

  bool operator()(int row, int column) const {
    return marks_(wrapped(column, marks_.width(), wrap_), wrapped(row, marks_.height(), wrap_));
  }

 private:
  /// The texels whose boxes an edge meets, and a few more.
  void mark_along(HalfEdge h) {
    const auto& corners = atlas_.corners[std::size_t(h / 3)];
    TexelPoint a = corners[std::size_t(h % 3)], b = corners[std::size_t(next(h) % 3)];
    if (b.y < a.y) std::swap(a, b);
    const double slope = b.y > a.y ? (b.column() - a.column()) / (b.row() - a.row()) : 0;
    for (int row = floor_texel(a.y); row <= floor_texel(b.y); ++row) {
      const auto column_at = [&](double y) {
        return b.y > a.y ? a.column() + (y - a.row()) * slope : a.column();
      };
      const double enters = column_at(std::max(a.row(), double(row)));
      const double leaves = b.y > a.y ? column_at(std::min(b.row(), row + 1.0)) : b.column();
      constexpr double hair = 1e-6;
      const int from = int(std::floor(std::min(enters, leaves) - hair));
      const int to = int(std::floor(std::max(enters, leaves) + hair)) + 1;
      for (int column = from; column <= to; ++column)
        mark(row, column), mark(row + 1, column);
    }
  }

  void mark(int row, int column) {
    marks_(wrapped(column, marks_.width(), wrap_), wrapped(row, marks_.height(), wrap_)) = 1;
  }

  const Atlas& atlas_;
  Wrap wrap_;
  Image<char> marks_;
};

std::vector<Reading> suspect_readings(const Surface& surface, const Atlas& atlas,
                                      const Footprints& footprints, const Progress& progress) {
  std::vector<Reading> readings;
  for (int k = 0; k < int(atlas.textures.size()); ++k) {
    const Suspects suspects(surface, atlas, k);
    for (int t = 0; t < surface.triangle_count(); ++t) {
      const int chart = atlas.chart[std::size_t(t)];
      if (chart < 0 || atlas.charts[std::size_t(chart)].triangles == 1 || surface.mesh.texture(t) != k) continue;
      if (t % 1024 == 0) progress.check();
      for (const TexelSpan& span : footprints.of(t))
        for (int column = span.first; column < span.end; ++column)
          if (suspects(span.row, column)) readings.push_back({chart, span.row, column, t});
    }
  }
  return readings;
}

/// Triangles that meet a texel's box hang together where they share an edge or a corner that is
/// closer to the texel than so many columns and rows. Around a notch of the border it may be
/// outside the box.
constexpr double near_enough = 2;

bool is_near(const TexelPoint& p, const Reading& texel) {
  return std::abs(p.column() - texel.column) < near_enough &&
         std::abs(p.row() - texel.row) < near_enough;
}

bool is_near(const Atlas& atlas, HalfEdge h, const Reading& texel) {
  const auto& corners = atlas.corners[std::size_t(h / 3)];
  const TexelPoint &a = corners[std::size_t(h % 3)], &b = corners[std::size_t(next(h) % 3)];
  double enters = 0, leaves = 1;  // the part of the edge between the columns, and between the rows
  const auto cut = [&](double from, double to) {
    if (from == to) return void(leaves = std::abs(from) < near_enough ? leaves : -1);
    const double s = (-near_enough - from) / (to - from), r = (near_enough - from) / (to - from);
    enters = std::max(enters, std::min(s, r));
    leaves = std::min(leaves, std::max(s, r));
  };
  cut(a.column() - texel.column, b.column() - texel.column);
  cut(a.row() - texel.row, b.row() - texel.row);
  return enters < leaves;
}

/// Finds out how many places of one texel its readings, by triangle, show, and which each does.
class Places {
 public:
  Places(const Surface& surface, const Atlas& atlas) : surface_(surface), atlas_(atlas) {}

  int find(std::span<const Reading> readings) {
    parent_.resize(readings.size());
    std::iota(parent_.begin(), parent_.end(), 0);
    join_at_edges(readings);
    join_at_corners(readings);
    int count = 0;
    place_.resize(readings.size());
    for (std::size_t i = 0; i < readings.size(); ++i)  // roots come before what hangs from them
      place_[i] = parent_[i] == int(i) ? count++ : place_[std::size_t(parent_[i])];
    return count;
  }
  int place(std::size_t reading) const { return place_[reading]; }

 private:
  int root(int i) const {
    while (parent_[std::size_t(i)] != i) i = parent_[std::size_t(i)];
    return i;
  }

  void join(int i, int j) {
    i = root(i), j = root(j);
    if (i != j) parent_[std::size_t(std::max(i, j))] = std::min(i, j);
  }

  void join_at_edges(std::span<const Reading> readings) {
    for (std::size_t i = 0; i < readings.size(); ++i)
      for (int k = 0; k < 3; ++k) {
        const HalfEdge h = 3 * readings[i].triangle + k, twin = surface_.twins[std::size_t(h)];
        if (twin < h || !lies_flat(surface_, atlas_, h)) continue;
        const auto other = std::ranges::lower_bound(readings, twin / 3, {}, &Reading::triangle);
        if (other != readings.end() && other->triangle == twin / 3 &&
            is_near(atlas_, h, readings[0]))
          join(int(i), int(other - readings.begin()));
      }
  }

  /// Around one vertex nothing is far, whatever cuts end there; folds are kept apart.
  void join_at_corners(std::span<const Reading> readings) {
    corners_.clear();
    for (std::size_t i = 0; i < readings.size(); ++i)
      for (int k = 0; k < 3; ++k) {
        const int t = readings[i].triangle;
        const TexelPoint& p = atlas_.corners[std::size_t(t)][std::size_t(k)];
        if (is_near(p, readings[0]))
          corners_.push_back({surface_.mesh.triangles[std::size_t(t)][std::size_t(k)], p,
                              turns_positive(atlas_, t), int(i)});
      }
    const auto at = [](const Corner& c) { return std::tie(c.vertex, c.point, c.turns_positive); };
    std::ranges::sort(corners_, {}, [&](const Corner& c) { return std::tuple(at(c), c.reading); });
    for (std::size_t k = 1; k < corners_.size(); ++k)
      if (at(corners_[k]) == at(corners_[k - 1]))
        join(corners_[k].reading, corners_[k - 1].reading);
  }

  struct Corner {
    int vertex;
    TexelPoint point;
    bool turns_positive;
    int reading;
  };
  const Surface& surface_;
  const Atlas& atlas_;
  std::vector<int> parent_, place_;
  std::vector<Corner> corners_;
};

/// Texels that stand for several places of a chart, triangle by triangle.
std::vector<PlaceOf> shared_places(const Surface& surface, const Atlas& atlas,
                                   std::vector<Reading> readings) {
  std::ranges::sort(readings, {},
                    [](const Reading& r) { return std::tuple(r.texel(), r.triangle); });
  std::vector<PlaceOf> shared;
  Places places(surface, atlas);
  int texels = 0;
  for (std::size_t begin = 0, end; begin < readings.size(); begin = end) {
    for (end = begin + 1; end < readings.size(); ++end)
      if (readings[end].texel() != readings[begin].texel()) break;
    const std::span<const Reading> of_texel(readings.data() + begin, end - begin);
    if (of_texel.size() < 2 || places.find(of_texel) < 2) continue;
    for (std::size_t i = 0; i < of_texel.size(); ++i)
      shared.push_back({of_texel[i].triangle, texels, places.place(i)});
    ++texels;
  }
  std::ranges::stable_sort(shared, {}, &PlaceOf::triangle);
  return shared;
}

/// Grows sheets in charts that share texels with themselves; the others are one each.
class Growth {
 public:
  Growth(const Surface& surface, const Atlas& atlas, std::vector<PlaceOf> shared)
      : surface_(surface), atlas_(atlas), shared_(std::move(shared)) {
    int texels = 0;
    for (const PlaceOf& p : shared_) texels = std::max(texels, p.texel + 1);
    taken_.assign(std::size_t(texels), {-1, -1});
    parts_.part.assign(atlas.chart.size(), -1);
  }

  InjectiveParts run() {
    for (int t = 0; t < int(atlas_.chart.size()); ++t)
      if (atlas_.chart[std::size_t(t)] >= 0 && parts_.part[std::size_t(t)] < 0) grow_from(t);
    renumber();
    return std::move(parts_);
  }

 private:
  void grow_from(int seed) {
    const int part = parts_.count();
    parts_.chart.push_back(atlas_.chart[std::size_t(seed)]);
    area_.push_back(0);
    std::vector<int> queue;
    const auto reach = [&](int t) {
      if (parts_.part[std::size_t(t)] >= 0 || !fits(t, part)) return;
      for (const PlaceOf& p : places_of(t)) taken_[std::size_t(p.texel)] = {part, p.place};
      parts_.part[std::size_t(t)] = part;
      const auto& p = atlas_.corners[std::size_t(t)];
      area_.back() += std::abs(double(orientation(p[0], p[1], p[2])));
      queue.push_back(t);
    };
    reach(seed);
    for (std::size_t i = 0; i < queue.size(); ++i)
      for (int k = 0; k < 3; ++k)
        if (atlas_.edges[std::size_t(3 * queue[i] + k)] == EdgeKind::inside)
          reach(surface_.twins[std::size_t(3 * queue[i] + k)] / 3);
  }

  std::span<const PlaceOf> places_of(int t) const {
    const auto range = std::ranges::equal_range(shared_, t, {}, &PlaceOf::triangle);
    return {range.begin(), range.end()};
  }

  /// Whether no texel of the triangle stands for another place in the sheet already.
  bool fits(int t, int part) const {
    return std::ranges::all_of(places_of(t), [&](const PlaceOf& p) {
      const auto& [by, place] = taken_[std::size_t(p.texel)];
      return by != part || place == p.place;
    });
  }

  void renumber() {
    std::vector<int> order(std::size_t(parts_.count()));
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, {}, [&](int s) {
      return std::pair(parts_.chart[std::size_t(s)], -area_[std::size_t(s)]);
    });
    std::vector<int> number(order.size()), chart;
    for (const int s : order) {
      number[std::size_t(s)] = int(chart.size());
      chart.push_back(parts_.chart[std::size_t(s)]);
    }
    parts_.chart = std::move(chart);
    for (int& s : parts_.part)
      if (s >= 0) s = number[std::size_t(s)];
  }

  const Surface& surface_;
  const Atlas& atlas_;
  std::vector<PlaceOf> shared_;             // by triangle
  std::vector<std::pair<int, int>> taken_;  // per texel: the sheet that came last, and its place
  std::vector<double> area_;
  InjectiveParts parts_;
};

}  // namespace

InjectiveParts find_injective_parts(const Surface& surface, const Atlas& atlas,
                                    const Footprints& footprints, const Progress& progress) {
  std::vector<Reading> readings = suspect_readings(surface, atlas, footprints, progress);
  progress.at(0.4);
  std::vector<PlaceOf> shared = shared_places(surface, atlas, std::move(readings));
  progress.at(0.9);
  InjectiveParts parts = Growth(surface, atlas, std::move(shared)).run();
  progress.at(1);
  return parts;
}

}  // namespace mq

// The surface lies in cubic cells of side h = `around`. A sample, a texel or the middle of a small triangle, has an
// area a and a squared difference d². Of a cell c, with A(c) = Σ a and E(c) = Σ a d² over its samples,
//
//     difference(c)² = Σ_o w(o) E(c + o) / max(Σ_o w(o) A(c + o), 2 h²),    w(o) = Π_axes (1 − |o| / 2),
//
// over the 27 cells around. A plane along the axes has Σ w A = (h / 2 + h + h / 2)² = 4 h². There are two cells at each
// place, for what faces to one side and to the other, so that the two sides of a leaf are two places; of a cell that
// faces elsewhere only what has much the same normal counts.
#include "mq/draw/texture_difference.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <unordered_map>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/draw/detail/textures.h"
#include "mq/image/colour.h"
#include "mq/image/resample.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

using CellKey = std::uint64_t;
constexpr int key_bits = 21;
constexpr CellKey faces_back = CellKey(1) << 63;

struct DifferenceCell {
  CellKey key = 0;
  double area = 0, energy = 0;
  Vector3 normal = Vector3::Zero();  ///< of the first triangle
  double largest = -1;               ///< squared difference ...
  SurfacePoint at;                   ///< ... of the sample there
};

/// Cells in the order in which they were first met.
struct DifferenceCells {
  std::vector<DifferenceCell> cells;
  std::unordered_map<CellKey, std::size_t> of_key;
  std::size_t last = 0;
  std::int64_t samples = 0;

  void add(const DifferenceCell& one) {
    if (cells.empty() || cells[last].key != one.key) {  // else it is of the same cell as the one before
      const auto [found, is_new] = of_key.try_emplace(one.key, cells.size());
      last = found->second;
      if (is_new) return cells.push_back(one);
    }
    DifferenceCell& cell = cells[last];
    cell.area += one.area;
    cell.energy += one.energy;
    if (one.largest > cell.largest) cell.largest = one.largest, cell.at = one.at;
  }
  const DifferenceCell* find(CellKey key) const {
    const auto found = of_key.find(key);
    return found == of_key.end() ? nullptr : &cells[found->second];
  }
};

class DifferenceSampler {
 public:
  DifferenceSampler(const Surface& surface, const Atlas& atlas, const std::vector<const Image<float>*>& before,
                    const std::vector<const Image<float>*>& after, double cell)
      : surface_(surface), atlas_(atlas), before_(before), after_(after), cell_(cell) {
    const Box box = bounding_box(surface.mesh);
    // Fewer, larger cells where a model is so large, in texels, that they cannot be numbered.
    cell_ = std::max(cell_, (box.high - box.low).maxCoeff() / double((1 << key_bits) - 4));
    low_ = box.low - Vector3::Constant(cell_);
  }

  double cell() const { return cell_; }

  CellKey key_of(const Vector3& point, const Vector3& normal) const {
    CellKey key = 0;
    for (int k = 0; k < 3; ++k) key = (key << key_bits) | CellKey((point[k] - low_[k]) / cell_);
    const Vector3 oblique(0.71, 0.57, 0.41);  // few faces of models lie along it
    return normal.dot(oblique) < 0 ? key | faces_back : key;
  }

  /// The texels whose centres lie in the triangle, or its middle.
  void add_triangle(int t, DifferenceCells& cells, const Progress& progress) {
    const auto& corners = atlas_.corners[std::size_t(t)];
    for (std::size_t k = 0; k < 3; ++k) corner_[k] = {corners[k].column(), corners[k].row()};
    std::int64_t count = 0;
    for_rows([&](double, double first, double last) { count += std::int64_t(last - first) + 1; });
    const double area = triangle_area(surface_.mesh, t) / double(std::max<std::int64_t>(count, 1));
    const Vector3 normal = triangle_normal(surface_.mesh, t);
    const auto add = [&](const Vector2& place) {
      const SurfacePoint at{t, barycentric(place)};
      const double square = squared_difference(t, place);
      cells.add({key_of(point_at(surface_.mesh, at), normal), area, area * square, normal, square, at});
    };
    for_rows([&](double row, double first, double last) {
      progress.check();
      for (double column = first; column <= last; ++column) add({column, row});
    });
    if (count == 0) add((corner_[0] + corner_[1] + corner_[2]) / 3);
    cells.samples += std::max<std::int64_t>(count, 1);
  }

 private:
  Vector3 barycentric(const Vector2& place) const {
    const Vector2 a = corner_[1] - corner_[0], b = corner_[2] - corner_[0], p = place - corner_[0];
    const double whole = a.x() * b.y() - a.y() * b.x();
    Vector3 weights = Vector3::Constant(1.0 / 3);
    if (whole == 0) return weights;
    weights[1] = std::clamp((p.x() * b.y() - p.y() * b.x()) / whole, 0.0, 1.0);
    weights[2] = std::clamp((a.x() * p.y() - a.y() * p.x()) / whole, 0.0, 1.0 - weights[1]);
    weights[0] = 1 - weights[1] - weights[2];
    return weights;
  }

  /// body(row, first column, last column) of whole rows and columns inside of the triangle.
  template <class Body>
  void for_rows(const Body& body) const {
    const auto [low, high] = std::minmax({corner_[0].y(), corner_[1].y(), corner_[2].y()});
    for (double row = std::ceil(low); row <= high; ++row) {
      double left = 1e300, right = -1e300;
      for (std::size_t k = 0; k < 3; ++k) {
        const Vector2 &a = corner_[k], &b = corner_[(k + 1) % 3];
        if (a.y() == b.y() || row < std::min(a.y(), b.y()) || row > std::max(a.y(), b.y())) continue;
        const double column = a.x() + (row - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
        left = std::min(left, column), right = std::max(right, column);
      }
      const double first = std::ceil(left), last = std::floor(right);
      if (first <= last) body(row, first, last);
    }
  }

  double squared_difference(int t, const Vector2& place) {
    const auto texture = std::size_t(surface_.mesh.texture(t));
    const Image<float>&a = *before_[texture], &b = *after_[texture];
    const int channels = std::min(colour_channels(a.channels()), colour_channels(b.channels()));
    here_.resize(std::size_t(channels)), there_.resize(std::size_t(channels));
    const Wrap wrap = atlas_.textures[texture].wrap;
    sample(a, place.x(), place.y(), wrap, here_);
    sample(b, place.x(), place.y(), wrap, there_);
    double square = 0;
    for (std::size_t k = 0; k < here_.size(); ++k) {
      const double difference = double(here_[k]) - there_[k];
      if (!std::isfinite(difference))
        throw InvalidInput(fmt::format("texture {} holds {} and {} at texel (column {:.0f}, row {:.0f}): only "
                                       "finite values can be compared",
                                       texture, here_[k], there_[k], place.x(), place.y()));
      square += difference * difference;
    }
    return square / channels;
  }

  const Surface& surface_;
  const Atlas& atlas_;
  const std::vector<const Image<float>*>&before_, &after_;
  double cell_;
  Vector3 low_ = Vector3::Zero();
  std::array<Vector2, 3> corner_;
  std::vector<float> here_, there_;
};

DifferenceCells difference_cells(const DifferenceSampler& sampler, const Surface& surface, const Atlas& atlas,
                         const Progress& progress) {
  constexpr std::int64_t block = 512;
  const std::int64_t count = surface.triangle_count();
  std::vector<DifferenceCells> parts(std::size_t((count + block - 1) / block));
  std::atomic<std::int64_t> done = 0;
  parallel_blocks(count, block, [&](std::int64_t begin, std::int64_t end) {
    DifferenceSampler own = sampler;
    DifferenceCells& part = parts[std::size_t(begin / block)];
    for (std::int64_t t = begin; t < end; ++t)
      if (atlas.chart[std::size_t(t)] >= 0) own.add_triangle(int(t), part, progress);
    progress.at(double(done += end - begin) / double(count));
  });
  DifferenceCells all;
  for (DifferenceCells& part : parts) {
    for (const DifferenceCell& cell : part.cells) all.add(cell);
    all.samples += part.samples;
    part = {};
  }
  return all;
}

/// difference(c)².
double smoothed_difference(const DifferenceCells& all, const DifferenceCell& cell, double side) {
  double area = 0, energy = 0;
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z) {
        const CellKey step = (CellKey(std::int64_t(x)) << (2 * key_bits)) + (CellKey(std::int64_t(y)) << key_bits) +
                             CellKey(std::int64_t(z));
        const double weight = (1 - std::abs(x) / 2.0) * (1 - std::abs(y) / 2.0) * (1 - std::abs(z) / 2.0);
        for (const CellKey key : {cell.key + step, (cell.key + step) ^ faces_back}) {
          const DifferenceCell* const near = all.find(key);
          if (near == nullptr || near->normal.dot(cell.normal) <= 0) continue;
          area += weight * near->area;
          energy += weight * near->energy;
        }
      }
  return energy / std::max(area, 2 * side * side);
}

DifferencePlace difference_place(const Surface& surface, const Atlas& atlas, const SurfacePoint& at) {
  DifferencePlace place;
  place.at = at;
  place.point = point_at(surface.mesh, at);
  place.normal = triangle_normal(surface.mesh, at.triangle);
  place.texture = surface.mesh.texture(at.triangle);
  const auto& corners = atlas.corners[std::size_t(at.triangle)];
  for (int k = 0; k < 3; ++k) {
    place.column += at.barycentric[k] * corners[std::size_t(k)].column();
    place.row += at.barycentric[k] * corners[std::size_t(k)].row();
  }
  return place;
}

/// Whether a person who looks at one sees the other too.
bool seen_together(const DifferencePlace& a, const DifferencePlace& b, double apart) {
  return (a.point - b.point).norm() <= apart && a.normal.dot(b.normal) > 0;
}

}  // namespace

TextureDifference texture_difference(const Surface& surface, const Atlas& atlas,
                                     const std::vector<const Image<float>*>& before,
                                     const std::vector<const Image<float>*>& after,
                                     const TextureDifferenceOptions& options, const Progress& progress) {
  check_textures(atlas, before);
  check_textures(atlas, after);
  require(options.around > 0 && options.apart > 0 && options.most > 0,
          "where textures differ is looked for around places, apart from each other, in numbers above 0");
  TextureDifference result;
  const double spacing = atlas.texel_spacing();
  if (!(spacing > 0)) return result;
  const DifferenceSampler sampler(surface, atlas, before, after, options.around * spacing);
  const DifferenceCells all = difference_cells(sampler, surface, atlas, progress.step("compare texels", 0.9));
  result.looked = all.samples;
  double area = 0, energy = 0;
  std::vector<std::pair<double, std::size_t>> order(all.cells.size());
  for (const DifferenceCell& cell : all.cells) area += cell.area, energy += cell.energy;
  parallel_for(std::ssize(order), [&](std::int64_t i) {
    order[std::size_t(i)] = {smoothed_difference(all, all.cells[std::size_t(i)], sampler.cell()), std::size_t(i)};
  });
  if (area > 0) result.rms = std::sqrt(energy / area);
  std::ranges::stable_sort(order, std::ranges::greater(), [](const auto& one) { return one.first; });
  for (const auto& [square, which] : order) {
    if (!(square > 0) || std::ssize(result.places) == options.most) break;
    DifferencePlace place = difference_place(surface, atlas, all.cells[which].at);
    place.difference = std::sqrt(square);
    if (std::ranges::none_of(result.places, [&](const DifferencePlace& earlier) {
          return seen_together(earlier, place, options.apart * spacing);
        }))
      result.places.push_back(place);
  }
  progress.step("find places", 0.1).at(1);
  return result;
}

}  // namespace mq

// u and v are whole numbers, multiples of the step or the bits of reals in their order, and are predicted in space.

#include "mq/io/detail/evolving_uvs.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <limits>
#include <unordered_map>
#include <utility>

#include "mq/io/detail/coding_order.h"

namespace mq {
namespace {

constexpr int double_bits = 0, float_bits = 1, uv_steps = 2;  // how texture coordinates are whole numbers

/// Of doubles, whole numbers in the same order.
std::int64_t ordered(double value) {
  const auto bits = std::bit_cast<std::int64_t>(value);
  return bits ^ ((bits >> 63) & std::numeric_limits<std::int64_t>::max());
}
double of_ordered(std::int64_t bits) {
  return std::bit_cast<double>(bits ^ ((bits >> 63) & std::numeric_limits<std::int64_t>::max()));
}
std::int64_t ordered_float(double value) {
  const auto bits = std::bit_cast<std::int32_t>(float(value));
  return bits ^ ((bits >> 31) & std::numeric_limits<std::int32_t>::max());
}
double of_ordered_float(std::int64_t value) {
  const auto bits = std::int32_t(value);
  return double(std::bit_cast<float>(bits ^ ((bits >> 31) & std::numeric_limits<std::int32_t>::max())));
}

bool is_float_value(double value) {
  return std::abs(value) <= double(std::numeric_limits<float>::max()) &&
         std::bit_cast<std::int64_t>(double(float(value))) == std::bit_cast<std::int64_t>(value);
}
bool has_steps(double value, double step) { return step > 0 && std::abs(value / step) <= 0x1p50; }

std::int64_t whole_uv(double value, int kind, double step) {
  if (kind == uv_steps) return std::llround(value / step);
  return kind == float_bits ? ordered_float(value) : ordered(value);
}
double real_uv(std::int64_t value, int kind, double step) {
  if (kind == uv_steps) return double(value) * step;
  return kind == float_bits ? of_ordered_float(value) : of_ordered(value);
}

/// Goes through all texture coordinates that are new; `residual(context, i, predicted)` codes one value, and returns
/// what it differs by.
template <class Residual>
void code_uvs(std::vector<std::int64_t>& values, const CodingOrder& order, const std::vector<int>& places,
              std::int64_t weight, const Residual& residual) {
  std::vector<std::uint32_t> left(values.size() / 2);
  for (int uv = 0; uv < order.vertex_count(); ++uv) {
    if (places[std::size_t(uv)] != new_place) continue;
    const int context = left_context(order, left, uv, uv_streams);
    const auto predicted = predicted_in_space<2>(values, order, uv, weight);
    for (std::size_t k = 0; k < 2; ++k)
      left[std::size_t(uv)] += std::uint32_t(bounded_left(residual(context, 2 * std::size_t(uv) + k, predicted[k])));
  }
}

/// Of the triangles that have a new one.
CodingOrder order_of_new(const EvolvingSegment& segment, const std::vector<int>& places) {
  std::vector<Triangle> triangles;
  std::ranges::copy_if(segment.corner_uvs, std::back_inserter(triangles), [&](const Triangle& corners) {
    return std::ranges::any_of(corners, [&](int uv) { return uv >= 0 && places[std::size_t(uv)] == new_place; });
  });
  return {triangles, int(segment.uvs.size())};
}

std::vector<std::int64_t> whole_uvs(const std::vector<Vector2>& uvs, int kind, double step) {
  std::vector<std::int64_t> values;
  for (const Vector2& uv : uvs)
    for (const double x : uv) values.push_back(whole_uv(x, kind, step));
  return values;
}

}  // namespace

std::vector<Vector2> rounded_uvs(std::vector<Vector2> uvs, double step) {
  const bool have_steps = std::ranges::all_of(
      uvs, [step](const Vector2& uv) { return has_steps(uv[0], step) && has_steps(uv[1], step); });
  if (have_steps)
    for (Vector2& uv : uvs)
      for (double& x : uv) x = real_uv(whole_uv(x, uv_steps, step), uv_steps, step);
  return uvs;
}

std::vector<int> uvs_before(const std::vector<Vector2>& uvs, const std::vector<Vector2>& before) {
  using Bits = std::pair<std::int64_t, std::int64_t>;
  struct Hash {
    std::size_t operator()(const Bits& bits) const {
      return std::size_t(std::uint64_t(bits.first) * 0x9E3779B97F4A7C15U ^ std::uint64_t(bits.second));
    }
  };
  const auto bits_of = [](const Vector2& uv) { return Bits{ordered(uv[0]), ordered(uv[1])}; };
  std::unordered_map<Bits, int, Hash> known;
  for (std::size_t i = 0; i < before.size(); ++i) known.emplace(bits_of(before[i]), int(i));
  std::vector<int> places;
  std::size_t expected = 0;
  for (const Vector2& uv : uvs) {
    int place = new_place;
    if (expected < before.size() && bits_of(before[expected]) == bits_of(uv))
      place = int(expected);
    else if (const auto found = known.find(bits_of(uv)); found != known.end())
      place = found->second;
    if (place != new_place) expected = std::size_t(place) + 1;
    places.push_back(place);
  }
  return places;
}

void put_uvs(SymbolWriter& to, int head_stream, int first_stream, const EvolvingSegment& segment,
             const std::vector<int>& places, double step) {
  bool have_steps = true, are_floats = true;
  for (std::size_t i = 0; i < places.size(); ++i)
    for (const double x : segment.uvs[i]) {
      have_steps = have_steps && has_steps(x, step);
      are_floats = are_floats && is_float_value(x);
    }
  const int kind = step > 0 && have_steps ? uv_steps : are_floats ? float_bits : double_bits;
  to.put(head_stream, std::uint64_t(kind));
  to.put_signed(head_stream, kind == uv_steps ? std::ilogb(step) : 0);
  std::vector<std::int64_t> values = whole_uvs(segment.uvs, kind, step);
  if (std::ranges::find(places, new_place) == places.end()) return;
  const CodingOrder order = order_of_new(segment, places);
  std::int64_t best = 0;
  double best_bits = std::numeric_limits<double>::infinity();
  for (const std::int64_t weight : {0, 16, 32, 48, 64}) {
    double bits = 0;
    code_uvs(values, order, places, weight, [&](int, std::size_t i, std::int64_t predicted) {
      const std::int64_t left = minus(values[i], predicted);
      bits += std::log2(1 + double(folded(left)));
      return left;
    });
    if (bits >= best_bits) continue;
    best_bits = bits;
    best = weight;
  }
  to.put(head_stream, std::uint64_t(best));
  code_uvs(values, order, places, best, [&](int context, std::size_t i, std::int64_t predicted) {
    const std::int64_t left = minus(values[i], predicted);
    to.put_signed(first_stream + context, left);
    return left;
  });
}

void get_uvs(SymbolReader& from, int head_stream, int first_stream, EvolvingSegment& segment,
             const std::vector<int>& places) {
  const auto kind = int(from.index(head_stream, 3));
  const std::int64_t exponent = from.get_signed(head_stream);
  if (std::abs(exponent) > 1000) from.fail("has texture coordinates in no sensible step");
  const double step = std::exp2(double(exponent));
  if (std::ranges::find(places, new_place) == places.end()) return;
  const auto weight = std::int64_t(from.index(head_stream, 65));
  std::vector<std::int64_t> values(2 * segment.uvs.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    if (places[i / 2] != new_place) {
      const double known = segment.uvs[i / 2][Eigen::Index(i % 2)];
      if ((kind == uv_steps && !has_steps(known, step)) || (kind == float_bits && !is_float_value(known)))
        from.fail("has texture coordinates that are not in its steps");
      values[i] = whole_uv(known, kind, step);
    }
  const CodingOrder order = order_of_new(segment, places);
  code_uvs(values, order, places, weight, [&](int context, std::size_t i, std::int64_t predicted) {
    const std::int64_t left = from.get_signed(first_stream + context);
    values[i] = plus(predicted, left);
    segment.uvs[i / 2][Eigen::Index(i % 2)] = real_uv(values[i], kind, step);
    return left;
  });
}

}  // namespace mq

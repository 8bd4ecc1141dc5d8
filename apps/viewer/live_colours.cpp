#include "live_colours.h"

#include <algorithm>
#include <cmath>

#include "mq/base/parallel.h"
#include "mq/io/model.h"

namespace mq::view {

/// Asks `replace` itself which unknown a picture shows where: charts that share texels have more of them than there
/// are texels.
LiveColours::LiveColours(const ModelSignal& domain, std::shared_ptr<TextureSet> pictures)
    : pictures_(std::move(pictures)) {
  constexpr int part = 1 << 12;  // both parts of a number are whole in single precision
  Signal numbers(domain.space().size(), 2);
  for (int k = 0; k < domain.space().size(); ++k) numbers.row(k) << (k + 1) / part, (k + 1) % part;
  Model numbered;
  domain.replace(numbers, Depth::f32, numbered);
  for (std::size_t t = 0; t < numbered.textures.size(); ++t) {
    const Image<float>& picture = numbered.textures[t].pixels;
    for (int y = 0; y < picture.height(); ++y)
      for (int x = 0; x < picture.width(); ++x) {
        const auto found = picture.pixel(x, y);
        const int number = int(found[0]) * part + int(found[1]);
        if (number == 0) continue;
        texels_.places.push_back({int(t), x, y});
        unknown_.push_back(number - 1);
      }
  }
}

double LiveColours::most(const Vector& distance) const {
  struct Most {
    double value = 0;
    Most operator+(const Most& other) const { return {std::max(value, other.value)}; }
  };
  return parallel_sum(std::ssize(unknown_), Most{}, [&](std::int64_t begin, std::int64_t end) {
           Most found;
           for (auto k = begin; k < end; ++k)
             if (const double d = distance[unknown_[std::size_t(k)]]; std::isfinite(d))
               found.value = std::max(found.value, d);
           return found;
         }).value;
}

void LiveColours::show(const Vector& distance, const DistanceColours& scale, Colours colours) {
  if (colours == Colours::exactly || !(scale.most > 0)) {
    const Signal exact = distance_colours(distance, scale);
    const auto lock = pictures_->lock();
    pictures_->change(texels_, [&](std::int64_t k, int c) { return exact(unknown_[std::size_t(k)], c); });
    return;
  }
  constexpr double per_line_width = 40;
  const int size =
      scale.line_width > 0 ? int(std::clamp(per_line_width * scale.most / scale.line_width, 4096.0, 131072.0)) : 4096;
  std::vector<std::array<float, 3>> table(std::size_t(size) + 2);
  parallel_for(size + 1, [&](std::int64_t i) { table[std::size_t(i)] = distance_colour(double(i) * scale.most / size, scale); });
  table.back() = distance_colour(std::nan(""), scale);
  const double steps = size / scale.most;
  place_.resize(unknown_.size());
  parallel_for(std::ssize(unknown_), [&](std::int64_t k) {
    const double d = distance[unknown_[std::size_t(k)]];
    place_[std::size_t(k)] = d <= scale.most ? int(d * steps + 0.5) : std::isfinite(d) ? size : size + 1;
  });
  const auto lock = pictures_->lock();
  pictures_->change(texels_, [&](std::int64_t k, int c) {
    return table[std::size_t(place_[std::size_t(k)])][std::size_t(c)];
  });
}

}  // namespace mq::view

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"
#include "mq/io/flow_file.h"
#include "mq/io/image_file.h"
#include "mq/model/detail/pair_checks.h"
#include "mq/model/signal_pair.h"

namespace mq {
namespace {

void multiply_by_alpha(Image<float>& picture) {
  if (!has_alpha(picture.channels())) return;
  const int alpha = picture.channels() - 1;
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x)
      for (int c = 0; c < alpha; ++c) picture(x, y, c) *= picture(x, y, alpha);
}

void divide_by_alpha(Image<float>& picture) {
  if (!has_alpha(picture.channels())) return;
  const int alpha = picture.channels() - 1;
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x)
      for (int c = 0; c < alpha; ++c)
        if (picture(x, y, alpha) > 0) picture(x, y, c) /= picture(x, y, alpha);
}

bool is_constant(const Image<float>& picture) {
  const std::span<const float> values = picture.values();
  const std::size_t channels = std::size_t(picture.channels());
  std::vector<float> low(values.begin(),
                         values.begin() + std::ptrdiff_t(std::min(channels, values.size())));
  std::vector<float> high = low;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t c = i % channels;
    low[c] = std::min(low[c], values[i]);
    high[c] = std::max(high[c], values[i]);
  }
  for (std::size_t c = 0; c < low.size(); ++c)
    if (high[c] - low[c] > least_range * std::max(std::abs(low[c]), std::abs(high[c])))
      return false;
  return true;
}

}  // namespace

PicturePair::PicturePair(const std::filesystem::path& first, const std::filesystem::path& second,
                         const ValueSpace& values, Messages& messages, const Progress& progress)
    : values_(values),
      model_(read_picture(first, ImageTriangles::two, progress.step("first", 0.5))) {
  const Texture& one = model_.textures.front();
  const Texture other = read_upright(second, progress.step("second", 0.5));
  for (const Texture* texture : {&one, &other})
    for (const std::string& note : texture->notes) messages.remark(note);
  require_alike(other, second.string(), one, first.string());
  first_ = decoded(one, values_);
  second_ = decoded(other, values_);
  multiply_by_alpha(first_);
  multiply_by_alpha(second_);
}

Likeness PicturePair::likeness() const {
  return {is_constant(first_), is_constant(second_), first_ == second_};
}

Image<float> PicturePair::read_field(const std::filesystem::path& path) const {
  Image<float> field = read_flow(path);
  if (field.width() != first_.width() || field.height() != first_.height())
    throw IoError(fmt::format(
        "{}: has {} x {} pixels, and the pictures have {} x {}: a field of these is wanted",
        path.string(), field.width(), field.height(), first_.width(), first_.height()));
  if (std::ranges::none_of(field.values(), [](float value) { return std::isfinite(value); }))
    throw IoError(path.string() + ": says of no pixel where it goes: all are marked as unknown");
  return field;
}

ImageFlow PicturePair::align(const ImageFlowOptions& options, const Progress& progress) const {
  ImageFlow flow;
  about(model_, [&] { flow = image_flow(first_, second_, options, progress); });
  return flow;
}

ImageFlow PicturePair::follow(const Image<float>& field, const ImageFlowOptions& options,
                              const Progress& progress) const {
  ImageFlow flow;
  about(model_, [&] { flow = known_flow(first_, second_, field, options, progress); });
  return flow;
}

Texture PicturePair::stored(const Image<float>& picture) const {
  Texture texture = model_.textures.front();
  texture.path.clear();
  Image<float> divided = picture;
  divide_by_alpha(divided);
  texture.pixels = encoded(divided, texture, values_);
  return texture;
}

Model PicturePair::with(const Image<float>& picture) const {
  Model model;
  model.path = model_.path;
  model.mesh = model_.mesh;
  model.textures = {stored(picture)};
  return model;
}

}  // namespace mq

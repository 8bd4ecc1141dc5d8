#include "mq/model/part_values.h"

#include <fmt/format.h>

#include <numeric>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/model/detail/same_row.h"
#include "mq/model/detail/texel_values.h"

namespace mq {
namespace {

std::vector<int> own_of(const TexelPart& part, int texture) {
  std::vector<int> own;
  for (const int i : part.own())
    if (part.places()[std::size_t(i)].texture == texture) own.push_back(i);
  return own;
}

}  // namespace

void take_values(const TexelPart& part, int texture, const TextureSize& size, const Texture& picture,
                 const ValueSpace& space, Signal& values) {
  const std::string file = picture.path.string();
  const int channels = picture.pixels.channels(), wanted = int(values.cols());
  require(picture.pixels.width() == size.width && picture.pixels.height() == size.height,
          fmt::format("{}: is {} x {}, and its head said {} x {}: it changed meanwhile", file, picture.pixels.width(),
                      picture.pixels.height(), size.width, size.height));
  require(channels == wanted || lacks_alpha(channels, wanted),
          fmt::format("{}: has {} and another texture of the model {}: textures of one model are processed together "
                      "and must agree; convert one of them",
                      file, counted(channels, "channel"), wanted));
  const std::vector<int> own = own_of(part, texture);
  take_values(own, [&](int i) { return part.places()[std::size_t(i)]; }, picture, space, values);
  for (const int i : own) {
    if (values.row(i).allFinite()) continue;
    const Texels::Place& at = part.places()[std::size_t(i)];
    throw IoError(fmt::format("{}: pixel (column {}, row {}) is infinite or no number, and a chart uses it; repair the "
                              "picture",
                              file, at.x, at.y));
  }
}

TexelValues changed_values(const TexelPart& part, int texture, const Signal& before, const Signal& after) {
  std::vector<int> own = own_of(part, texture);
  std::erase_if(own, [&](int i) { return same_row(before, after, i); });
  TexelValues changed;
  changed.values.resize(std::ssize(own), after.cols());
  for (std::size_t n = 0; n < own.size(); ++n) {
    changed.places.push_back(part.places()[std::size_t(own[n])]);
    changed.values.row(Eigen::Index(n)) = after.row(own[n]);
  }
  return changed;
}

void put_values(const TexelValues& changed, const ValueSpace& space, Texture& picture) {
  std::vector<int> all(changed.places.size());
  std::iota(all.begin(), all.end(), 0);
  put_values(all, [&](int n) { return changed.places[std::size_t(n)]; }, changed.values, space, picture);
}

}  // namespace mq

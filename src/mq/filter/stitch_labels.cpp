// Which photograph each unknown comes from: as pictures say, or as photographs show it best.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/filter/stitch.h"
#include "mq/image/colour.h"

namespace mq {
std::span<const float> nearest_pixel(const Texels::Place& texel, const TextureSize& texture, const Image<float>& picture) {
  require(!picture.empty(), "a label picture has no pixels");
  const auto nearest = [](int i, int from, int to) {
    return std::min(to - 1, int(std::int64_t(2 * i + 1) * to / (2 * std::int64_t(from))));
  };
  return picture.pixel(nearest(texel.x, texture.width, picture.width()),
                       nearest(texel.y, texture.height, picture.height()));
}

std::vector<int> labels_of_pictures(const Texels& texels, std::span<const TextureSize> textures,
                                    std::span<const Image<float>> pictures,
                                    const std::optional<std::vector<float>>& unseen_colour) {
  require(pictures.size() == textures.size(),
          fmt::format("{} for {}: give one each", counted(std::ssize(pictures), "label picture"),
                      counted(std::ssize(textures), "texture")));
  std::map<std::vector<float>, int> label_of;
  std::vector<int> labels;
  labels.reserve(std::size_t(texels.size()));
  std::vector<float> colour, last;
  int last_label = unseen;
  for (const Texels::Place& at : texels.places) {
    const auto pixel = nearest_pixel(at, textures[std::size_t(at.texture)], pictures[std::size_t(at.texture)]);
    colour.assign(pixel.begin(), pixel.end());
    if (labels.empty() || colour != last) {
      const int colours = colour_channels(int(colour.size()));
      const bool transparent = colours < int(colour.size()) && colour.back() == 0;
      colour.resize(std::size_t(colours));
      const bool is_unseen =
          transparent || (unseen_colour && unseen_colour->size() == colour.size() &&
                          std::ranges::equal(colour, *unseen_colour, [](float a, float b) {
                            return std::abs(a - b) < 5e-6F;
                          }));
      last_label =
          is_unseen ? unseen : label_of.try_emplace(colour, int(label_of.size())).first->second;
      last.assign(pixel.begin(), pixel.end());
    }
    labels.push_back(last_label);
  }
  return labels;
}

std::vector<int> numbers_of_pictures(const Texels& texels, std::span<const TextureSize> textures,
                                     std::span<const Image<float>> pictures,
                                     std::span<const double> steps) {
  require(pictures.size() == textures.size() && steps.size() == textures.size(),
          fmt::format("{} for {}: give one each", counted(std::ssize(pictures), "label picture"),
                      counted(std::ssize(textures), "texture")));
  std::vector<int> numbers;
  numbers.reserve(std::size_t(texels.size()));
  for (const Texels::Place& at : texels.places) {
    const auto pixel = nearest_pixel(at, textures[std::size_t(at.texture)], pictures[std::size_t(at.texture)]);
    const bool transparent =
        colour_channels(int(pixel.size())) < int(pixel.size()) && pixel.back() == 0;
    numbers.push_back(transparent ? unseen : int(std::lround(pixel[0] * steps[at.texture])));
  }
  return numbers;
}

Composite best_of(std::span<const Partial> partials, std::span<const int> wanted) {
  require(!partials.empty(), "stitching needs one partial signal at least");
  const Eigen::Index n = partials.front().values.rows();
  for (const Partial& partial : partials) {
    require(partial.values.rows() == n && partial.values.cols() == partials.front().values.cols() &&
                std::ssize(partial.confidence) == n,
            "partial signals must have equally many rows and channels, and a confidence per row");
    for (Eigen::Index i = 0; i < n; ++i) {
      const double confidence = partial.confidence[i];
      if (confidence >= 0 && std::isfinite(confidence) &&
          (confidence == 0 || partial.values.row(i).allFinite()))
        continue;
      throw InvalidInput(
          fmt::format("a partial signal has confidence {} at unknown {}: it must not "
                      "be negative, and the values there finite",
                      confidence, i));
    }
  }
  require(wanted.empty() || std::ssize(wanted) == n, "one wanted photograph per unknown is needed");
  for (const int number : wanted)
    require(number >= unseen && number < std::ssize(partials),
            fmt::format("found photograph {}, wanted a number from 0 to {}", number,
                        partials.size() - 1));
  std::vector<int> labels(std::size_t(n), unseen);
  for (Eigen::Index i = 0; i < n; ++i) {
    double best = 0;
    for (std::size_t k = 0; k < partials.size(); ++k)
      if (partials[k].confidence[i] > best) best = partials[k].confidence[i], labels[i] = int(k);
    if (!wanted.empty() && wanted[i] != unseen && partials[wanted[i]].confidence[i] > 0) labels[i] = wanted[i];
  }
  return composite_of(partials, std::move(labels));
}

Composite composite_of(std::span<const Partial> partials, std::vector<int> labels) {
  const Eigen::Index n = std::ssize(labels);
  Composite composite{Signal::Zero(n, partials.front().values.cols()), std::move(labels)};
  Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(composite.values.cols());
  double count = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (composite.labels[i] == unseen) continue;
    composite.values.row(i) = partials[composite.labels[i]].values.row(i);
    sum += composite.values.row(i), count += 1;
  }
  if (count > 0)
    for (Eigen::Index i = 0; i < n; ++i)
      if (composite.labels[i] == unseen) composite.values.row(i) = sum / count;
  return composite;
}

}  // namespace mq

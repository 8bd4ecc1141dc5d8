#include "partials.h"

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/filter/modulation.h"
#include "mq/image/colour.h"

namespace mq::app {
namespace {

/// Pictures of one partial texture: files [first, first + count).
std::vector<Texture> read_pictures(const std::vector<std::string>& files, std::size_t first,
                                   const Scene& scene) {
  std::vector<Texture> textures;
  for (std::size_t i = 0; i < scene.texture_sizes.size(); ++i) {
    textures.push_back(read_texture(files[first + i]));
    const Image<float>& picture = textures.back().pixels;
    const TextureSize& size = scene.texture_sizes[i];
    require(
        picture.width() == size.width && picture.height() == size.height,
        fmt::format("{}: --partial: is {} × {}, and the texture {} × {}: bring it to that size",
                    files[first + i], picture.width(), picture.height(), size.width, size.height));
  }
  return textures;
}

/// Takes the last channel out of a picture.
Image<float> split_alpha(Texture& texture) {
  Image<float>& pixels = texture.pixels;
  Image<float> alpha(pixels.width(), pixels.height(), 1);
  Image<float> rest(pixels.width(), pixels.height(), pixels.channels() - 1);
  for (int y = 0; y < pixels.height(); ++y)
    for (int x = 0; x < pixels.width(); ++x) {
      alpha(x, y) = pixels.pixel(x, y).back();
      std::copy_n(pixels.pixel(x, y).begin(), rest.channels(), rest.pixel(x, y).begin());
    }
  pixels = std::move(rest);
  return alpha;
}

bool has_alpha(const Texture& texture) {
  return colour_channels(texture.pixels.channels()) < texture.pixels.channels();
}

}  // namespace

void add_partial_options(OptionTable& table) {
  using Type = Option::Type;
  table.add({.name = "partial",
             .type = Type::path,
             .count = Option::Count::many,
             .group = "Regions",
             .help = "a photograph as a texture of its own, of the texture's size",
             .details =
                 "Each texel is taken from the one that shows it best. With several textures "
                 "the first photograph's pictures of all of them come first."});
  table.add({.name = "confidence",
             .type = Type::path,
             .count = Option::Count::many,
             .group = "Regions",
             .help = "for each of them how well it shows each texel: black not at all",
             .details = "Without it, by their alpha channels."});
}

bool has_partials(const OptionValues& options) { return !options.texts("partial").empty(); }

std::vector<Partial> read_partials(Run& run, const Scene& scene, const TextureTarget& target) {
  const std::vector<std::string> files = run.options().texts("partial");
  const std::vector<std::string> confidences = run.options().texts("confidence");
  const std::size_t count = scene.texture_sizes.size();
  require(files.size() % count == 0,
          fmt::format("--partial: {} has {}, and {} given: give each photograph a picture for each",
                      scene.model.path.string(), counted(std::int64_t(count), "texture"),
                      files.size()));
  require(confidences.empty() || confidences.size() == files.size(),
          fmt::format(
              "--confidence: found {} for {} of --partial: give one for each, in their order",
              counted(std::ssize(confidences), "picture"), counted(std::ssize(files), "picture")));
  std::vector<Partial> partials;
  for (std::size_t first = 0; first < files.size(); first += count) {
    std::vector<Texture> textures = read_pictures(files, first, scene);
    std::vector<Image<float>> shown;
    for (std::size_t i = 0; i < count; ++i) {
      require(!confidences.empty() || has_alpha(textures[i]),
              files[first + i] +
                  ": --partial: has no alpha channel to tell what it shows; give "
                  "--confidence pictures");
      Image<float> alpha;
      const bool surplus = textures[i].pixels.channels() == target.channels() + 1;
      if (has_alpha(textures[i]) && (confidences.empty() || surplus))
        alpha = split_alpha(textures[i]);
      shown.push_back(confidences.empty() ? alpha : read_texture(confidences[first + i]).pixels);
    }
    const Texels& texels = target.domain().space().texels();
    partials.push_back(
        {target.values_of(textures), mask_of_pictures(texels, scene.texture_sizes, shown)});
  }
  return partials;
}

}  // namespace mq::app

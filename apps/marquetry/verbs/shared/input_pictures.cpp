#include "verbs/shared/input_pictures.h"

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/io/image_file.h"

namespace mq::app {

void require_size(const std::string& file, int width, int height, const TexturedModel& scene,
                  std::size_t i) {
  const TextureSize& size = scene.texture_sizes[i];
  require(width == size.width && height == size.height,
          fmt::format("{}: is {} x {}, and the texture {} x {}: scale it", file, width, height,
                      size.width, size.height));
}

void check_pictures(const OptionValues& options, const TexturedModel& scene, const InputPictures& wanted) {
  const std::vector<std::string> files = options.texts(wanted.option);
  const std::size_t given = files.size(), count = scene.texture_sizes.size();
  const bool many = wanted.count == InputPictures::Count::many_sets;
  require(
      given == 0 || count == 0 || given == count || (many && given % count == 0),
      fmt::format("--{}: {} has {}, and {} given: give one for each, in their order", wanted.option,
                  scene.model.path.string(), counted(std::int64_t(count), "texture"),
                  given == 1 ? "one is" : std::to_string(given) + " are"));
  for (std::size_t i = 0; i < given; ++i) {
    const PictureInfo info = picture_info(files[i]);
    if (count > 0 && wanted.size == InputPictures::Size::of_the_texture)
      require_size(files[i], info.width, info.height, scene, i % count);
  }
}

}  // namespace mq::app

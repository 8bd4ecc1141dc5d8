#pragma once
/// Pictures that options name beside the model's own: masks, labels, guides, photographs.

#include <string>

#include "mq/base/options.h"
#include "options/model_options.h"

namespace mq::app {

/// What is wanted of the pictures of one option.
struct InputPictures {
  std::string option;
  enum class Count { one_set, many_sets } count = Count::one_set;  ///< of one for each texture
  enum class Size { any, of_the_texture } size = Size::any;
};

/// Refuses, before any work and in dry runs as well, pictures of which there are not as many as
/// wanted, whose heads cannot be read or whose size is another. Where the scene has no textures
/// only the heads are looked at. Throws `InvalidInput` or `IoError`.
void check_pictures(const OptionValues& options, const TexturedModel& scene, const InputPictures& wanted);

/// Throws `InvalidInput` naming the file where a picture has not the size of the scene's texture i.
void require_size(const std::string& file, int width, int height, const TexturedModel& scene,
                  std::size_t i);

}  // namespace mq::app

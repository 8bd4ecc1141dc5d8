// Sharpens the texture of a model on its surface, over all seams:
//
//     01_filter bust.obj bust.png sharp.png
#include <cstdio>
#include <exception>
#include <vector>

#include "mq/mq.h"

int main(int argc, char** argv) try {
  if (argc != 4) {
    std::fprintf(stderr, "marquetry %s; usage: 01_filter MESH TEXTURE OUTPUT\n", mq::version);
    return 2;
  }
  mq::Model model = mq::read_model(argv[1], {.textures = {argv[2]}});
  const mq::Surface surface = mq::make_surface(model.mesh);
  mq::Image<float>& pixels = model.textures.at(0).pixels;
  const mq::Atlas atlas = mq::make_atlas(surface, {{pixels.width(), pixels.height()}});

  const mq::TexelSpace space(surface, atlas);
  const mq::Signal colours = space.gather({&pixels, 1});
  const mq::Filtered sharp = mq::sharpen(space, colours, mq::parse_length("3tx"), 2);
  space.scatter(sharp.signal, {&pixels, 1});

  mq::write_texture(argv[3], model.textures[0]);
  std::printf("%d texels, marquetry %s\n", space.size(), mq::version);
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}

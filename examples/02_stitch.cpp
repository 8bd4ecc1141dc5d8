// Takes the steps between charts out of a texture whose charts are photographs that do not match:
//
//     02_stitch bust.obj bust.png stitched.png
#include <cstdio>
#include <exception>
#include <vector>

#include "mq/mq.h"

int main(int argc, char** argv) try {
  if (argc != 4) {
    std::fprintf(stderr, "usage: 02_stitch MESH TEXTURE OUTPUT\n");
    return 2;
  }
  mq::Model model = mq::read_model(argv[1], {.textures = {argv[2]}});
  const mq::Surface surface = mq::make_surface(model.mesh);
  mq::Image<float>& pixels = model.textures.at(0).pixels;
  const mq::Atlas atlas = mq::make_atlas(surface, {{pixels.width(), pixels.height()}});

  const mq::TexelSpace space(surface, atlas);
  const std::vector<int>& regions = space.texels().chart;  // gradients inside count, steps between them do not
  const mq::Signal colours = space.gather({&pixels, 1});
  const double weight = 1e4 * space.scale().area;  // gradients count, and hardly the values
  const mq::Stitcher stitcher(space, weight, regions);
  space.scatter(stitcher.solve(colours, stitcher.change(colours)).signal, {&pixels, 1});

  mq::write_texture(argv[3], model.textures[0]);
  const mq::BorderJump before = mq::border_jump(stitcher.stiffness(), colours, regions);
  const mq::BorderJump after =
      mq::border_jump(stitcher.stiffness(), space.gather({&pixels, 1}), regions);
  std::printf("differences between texels across borders of charts: %.3f, then %.3f; within charts: %.3f\n",
              before.across, after.across, after.within);
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}

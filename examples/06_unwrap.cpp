// Unwraps a mesh into a texture atlas, writes it with its new texture coordinates and draws the charts:
//
//     06_unwrap bust.obj unwrapped.obj charts.png
#include <cstdio>
#include <exception>
#include <vector>

#include "mq/mq.h"

int main(int argc, char** argv) try {
  if (argc != 4) {
    std::fprintf(stderr, "usage: 06_unwrap MESH MODEL_OUT PICTURE_OUT\n");
    return 2;
  }
  mq::Model model = mq::read_model(argv[1], {.pictures = mq::ReadModelOptions::Pictures::skip});
  const mq::UnwrapOptions options{.width = 512, .height = 512};
  const mq::Unwrapped unwrapped = mq::unwrap(mq::make_surface(model.mesh), options);
  model.mesh.uvs = unwrapped.uvs;
  model.mesh.corner_uvs = unwrapped.corner_uvs;
  model.mesh.textures.clear();
  model.textures.clear();
  model.document = nullptr;  // the file it came from has other texture coordinates
  mq::write_model(argv[2], model);

  const mq::Surface surface = mq::make_surface(model.mesh);
  const mq::Atlas atlas = mq::make_atlas(surface, {{options.width, options.height}});
  mq::UvLayoutOptions layout{.side = 512};
  layout.fill = mq::UvLayoutOptions::Fill::charts;
  mq::RenderOptions picture{.width = 512, .height = 512};
  picture.paint = mq::RenderOptions::Paint::charts;
  mq::write_image(argv[3],
                  mq::contact_sheet({{mq::Renderer(surface, &atlas).draw({}, picture), "charts"},
                                     {mq::draw_uv_layout(surface, atlas, nullptr, layout), "atlas"}}));
  std::printf("%d charts, %.1f %% of the texture\n", unwrapped.figures.charts,
              100 * unwrapped.figures.stretch.occupancy);
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}

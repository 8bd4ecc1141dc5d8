// Draws the distance along a surface from one of its vertices, with lines of equal distance:
//
//     03_geodesic bust.obj 0 distance.png
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <vector>

#include "mq/mq.h"

int main(int argc, char** argv) try {
  if (argc != 4) {
    std::fprintf(stderr, "usage: 03_geodesic MESH VERTEX OUTPUT\n");
    return 2;
  }
  const mq::Model model = mq::read_model(argv[1], {.pictures = mq::ReadModelOptions::Pictures::skip});
  const mq::Surface surface = mq::make_surface(model.mesh);

  const mq::VertexSpace space(surface);
  const mq::GeodesicDistance distances(space);
  const mq::Vector distance = distances.from({{.unknown = std::atoi(argv[2])}}).distance;

  const double most = distance.maxCoeff();
  const std::vector<float> values(distance.begin(), distance.end());
  mq::RenderOptions options;
  options.paint = mq::RenderOptions::Paint::vertex_numbers;
  options.scale = {.high = most, .isolines = 24};
  options.legend_title = "distance";
  mq::write_image(argv[3], mq::Renderer(surface).draw({.vertex_values = values}, options));
  std::printf("%d vertices, the farthest at %.4f\n", space.size(), most);
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}

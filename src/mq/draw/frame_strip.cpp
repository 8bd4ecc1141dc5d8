#include "mq/draw/frame_strip.h"

#include <cmath>

#include "mq/mesh/closest_point.h"
#include "mq/mesh/geometry.h"

namespace mq {

std::array<Image<float>, 3> draw_strip_frame(const StripFrame& frame, const StripOptions& options,
                                             const Progress& progress) {
  const Box box = bounding_box(frame.captured);
  RenderOptions how{.view = options.view, .width = options.side, .height = options.side};
  how.view.target = (box.low + box.high) / 2;
  how.view.extent = options.extent;
  how.samples = 2;
  how.legend = RenderOptions::Legend::hide;
  const Surface captured = make_surface(frame.captured, {.kind = WeldOptions::Kind::none});
  const Surface followed = make_surface(frame.followed, {.kind = WeldOptions::Kind::none});
  std::array<Image<float>, 3> pictures;

  const bool coloured = !frame.captured_colours.empty();
  how.paint = coloured ? RenderOptions::Paint::vertex_colours : RenderOptions::Paint::clay;
  pictures[0] = Renderer(captured).draw({.vertex_values = frame.captured_colours}, how,
                                        progress.step("captured", 0.3));
  const Renderer renderer(followed);
  how.paint = RenderOptions::Paint::vertex_colours;
  pictures[1] =
      renderer.draw({.vertex_values = frame.followed_colours}, how, progress.step("followed", 0.3));
  std::vector<float> distances;
  for (const ClosestPoint& p : ClosestPointFinder(frame.captured)(frame.followed.positions))
    distances.push_back(float(std::sqrt(p.squared_distance)));
  how.paint = RenderOptions::Paint::vertex_numbers;
  how.scale = {.low = 0, .high = options.most};
  pictures[2] = renderer.draw({.vertex_values = distances}, how, progress.step("distances", 0.4));
  return pictures;
}

std::vector<float> colours_of_places(const Mesh& mesh) {
  const Box box = bounding_box(mesh);
  const Vector3 size = (box.high - box.low).cwiseMax(1e-300);
  std::vector<float> colours;
  colours.reserve(3 * mesh.positions.size());
  for (const Vector3& p : mesh.positions)
    for (int k = 0; k < 3; ++k)
      colours.push_back(float(0.15 + 0.8 * (p[k] - box.low[k]) / size[k]));
  return colours;
}

}  // namespace mq

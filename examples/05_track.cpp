// Follows a body that bends with one mesh, though every frame of it is meshed anew; draws the mesh in
// the colours of the first frame, which stay where they are on the body:
//
//     05_track tracked.png
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "mq/mq.h"

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::fprintf(stderr, "usage: 05_track OUTPUT\n");
    return 2;
  }
  const mq::MovingOptions motion{.period = 24, .triangles = 4000};
  const mq::MovingFrame first = mq::make_moving_frame("bending", 0, motion);
  mq::Mesh tracked = first.mesh;
  std::vector<float> colours;
  for (const mq::Vector3& colour : first.colors)
    for (int c = 0; c < 3; ++c) colours.push_back(float(colour[c]));
  mq::RenderOptions options{.width = 360, .height = 360};
  options.paint = mq::RenderOptions::Paint::vertex_colours;
  options.wires = mq::RenderOptions::Lines::show;

  mq::SurfaceTracker tracker(tracked);
  std::vector<mq::Vector3> previous;
  std::vector<mq::Tile> pictures;
  for (int frame = 0; frame <= 6; ++frame) {
    const mq::TrackTarget target(mq::make_moving_frame("bending", frame, motion).mesh);
    const mq::TrackedFrame found = tracker.follow(tracked.positions, previous, target);
    previous = frame == 0 ? std::vector<mq::Vector3>() : tracked.positions;
    tracked.positions = found.positions;
    std::printf("frame %d: mean distance %.3f %% of the diagonal\n", frame, 100 * found.distance.mean);
    if (frame % 2 != 0) continue;
    const mq::Surface surface = mq::make_surface(tracked);
    pictures.push_back({mq::Renderer(surface).draw({.vertex_values = colours}, options),
                        "frame " + std::to_string(frame)});
  }
  mq::write_image(argv[1], mq::contact_sheet(pictures));
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}

// Draws where everything in one picture is in the next, by optical flow; and the picture between them:
//
//     04_flow first.png second.png flow.png
#include <cstdio>
#include <exception>
#include <vector>

#include "mq/mq.h"

int main(int argc, char** argv) try {
  if (argc != 4) {
    std::fprintf(stderr, "usage: 04_flow FIRST SECOND OUTPUT\n");
    return 2;
  }
  const mq::Image<float> first = mq::read_texture(argv[1]).pixels, second = mq::read_texture(argv[2]).pixels;
  const mq::ImageFlow flow = mq::image_flow(first, second);
  const mq::Image<float> moved = mq::forward_displacement(flow);
  const mq::Image<float> between = mq::interpolated(flow, first, second, 0.5);

  const double longest = mq::longest(moved);
  mq::write_image(argv[3], mq::contact_sheet({{first, "first"},
                                              {between, "halfway, by flow"},
                                              {second, "second"},
                                              {mq::flow_picture_with_wheel(moved, longest), "flow"}},
                                             {.columns = 2}));
  std::printf("the longest way is %.1f pixels; difference %.4f of the blend, %.4f along the flow\n",
              longest, flow.error.front(), flow.error.back());
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}

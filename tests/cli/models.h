#pragma once
/// Small models as files.

#include <string>

#include "cli/program.h"
#include "mq/io/model.h"

namespace mq::test {

/// A flat strip of two squares, each a chart of its own: one seam in the middle.
inline const char* const strip_obj =
    "mtllib strip.mtl\nusemtl strip\n"
    "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\n"
    "vt 0.05 0.1\nvt 0.45 0.1\nvt 0.45 0.9\nvt 0.05 0.9\n"
    "vt 0.55 0.1\nvt 0.95 0.1\nvt 0.95 0.9\nvt 0.55 0.9\n"
    "f 1/1 2/2 5/3 4/4\nf 2/5 3/6 6/7 5/8\n";

/// A square with texture coordinates, a few texels across in the texture that is assumed where there is
/// none.
inline const char* const bare_obj =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n"
    "vt 0.1 0.1\nvt 0.14 0.1\nvt 0.1 0.14\nvt 0.14 0.14\n"
    "f 1/1 2/2 3/3\nf 2/2 4/4 3/3\n";

/// The strip with the last triangle turned over in the texture.
inline const char* const folded_obj =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n"
    "vt 0.1 0.1\nvt 0.9 0.1\nvt 0.1 0.9\nvt 0.2 0.2\n"
    "f 1/1 2/2 3/3\nf 2/2 4/4 3/3\n";

/// A picture with something at every texel: waves, and noise from a small formula.
inline Image<float> busy_picture(int width, int height, int channels = 3) {
  Image<float> image(width, height, channels);
  unsigned state = 1;
  for (float& value : image.values()) {
    state = state * 1664525u + 1013904223u;
    value = float(64 + (state >> 25)) / 255.0F;
  }
  return image;
}

/// strip.obj, strip.mtl and strip.png in `folder`.
inline void write_strip(const Folder& folder, int width = 64, int height = 48,
                        Depth depth = Depth::u8) {
  write_bytes(folder / "strip.obj", strip_obj);
  write_bytes(folder / "strip.mtl", "newmtl strip\nmap_Kd strip.png\n");
  write_image(folder / "strip.png", busy_picture(width, height), depth);
}

/// A fan around one vertex with a colour at each: grey 100, the middle 200.
inline const char* const coloured_ply =
    "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n"
    "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
    "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0 200 200 200\n1 0 0 100 100 100\n0 1 0 100 100 100\n-1 0 0 100 100 100\n"
    "0 -1 0 100 100 100\n3 0 1 2\n3 0 2 3\n3 0 3 4\n3 0 4 1\n";

}  // namespace mq::test

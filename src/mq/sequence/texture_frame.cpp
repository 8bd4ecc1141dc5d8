// Sample (i, j) of a texture with s samples per texel lies at ((i + ½)/s, (j + ½)/s) texels from
// its upper left corner. Each belongs to the triangle that it is in, else to the nearest one closer
// than a texel, where the point nearest to it counts.

#include "mq/sequence/texture_frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/image/spread.h"
#include "mq/mesh/geometry.h"
#include "mq/sequence/texel_owners.h"

namespace mq {

TextureFrame resample_texture(const Mesh& surface, const Mesh& captured, const ColourAt& colour,
                              const TextureFrameOptions& options, const Progress& progress) {
  require(surface.has_uvs(), "the surface has no texture coordinates to resample into");
  require(options.width >= 1 && options.height >= 1 && options.samples >= 1 && options.samples <= 8,
          fmt::format("a texture of {} × {} texels with {} × {} samples each: wanted at least one "
                      "texel, and 1 to 8 samples",
                      options.width, options.height, options.samples, options.samples));
  const TexelOwners raster(surface, options.width, options.height, options.samples);
  progress.at(0.1);
  const ClosestPointFinder closest(captured);
  const double most = options.most_distance * bounding_box(captured).diagonal();
  const double least_cosine = std::cos(options.most_angle * std::numbers::pi / 180);

  TextureFrame frame;
  frame.picture = Image<float>(options.width, options.height, 3);
  Image<char> known(options.width, options.height, 1), inside(options.width, options.height, 1);
  const int s = options.samples;
  parallel_for(
      options.height,
      [&](std::int64_t y) {
        progress.check();
        for (int x = 0; x < options.width; ++x) {
          Eigen::Array3d sum = Eigen::Array3d::Zero();
          int seen = 0;
          for (int row = int(y) * s; row < int(y) * s + s; ++row)
            for (int column = x * s; column < x * s + s; ++column) {
              const TexelOwners::Owner& owner = raster.owner(column, row);
              if (owner.triangle < 0) continue;
              if (owner.distance == 0) inside(x, int(y)) = 1;
              const Vector3 b =
                  nearest_in_triangle(raster.corners(owner.triangle), raster.place(column, row));
              Vector3 p = Vector3::Zero();
              for (int k = 0; k < 3; ++k) p += b[k] * surface.position(owner.triangle, k);
              const ClosestPoint found = closest(p);
              if (found.squared_distance > most * most ||
                  triangle_normal(surface, owner.triangle).dot(triangle_normal(captured, found.triangle)) <
                      least_cosine)
                continue;
              const std::array<float, 3> value = colour(found);
              sum += Eigen::Array3d(value[0], value[1], value[2]);
              ++seen;
            }
          if (seen == 0) continue;
          known(x, int(y)) = 1;
          for (int k = 0; k < 3; ++k) frame.picture(x, int(y), k) = float(sum[k] / seen);
        }
      },
      8);
  for (int y = 0; y < options.height; ++y)
    for (int x = 0; x < options.width; ++x) {
      frame.texels += inside(x, y);
      frame.unseen += inside(x, y) && !known(x, y);
    }
  progress.at(0.95);
  spread(known, std::numeric_limits<double>::infinity(), frame.picture);
  frame.inside = std::move(inside);
  return frame;
}

}  // namespace mq

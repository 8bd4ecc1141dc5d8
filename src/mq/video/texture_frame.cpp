// Sample (i, j) of a texture with s samples per texel lies at ((i + ½)/s, (j + ½)/s) texels from
// its upper left corner. Each belongs to the triangle that it is in, else to the nearest one closer
// than a texel, where the point nearest to it counts.

#include "mq/video/texture_frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/fem/multigrid_solver.h"
#include "mq/fem/texel_space.h"
#include "mq/fem/vertex_space.h"
#include "mq/image/spread.h"
#include "mq/mesh/weld.h"
#include "mq/filter/fill_unseen.h"
#include "mq/video/texel_owners.h"

namespace mq {

namespace {

/// The texture as a space of signals.
struct TextureSpace {
  TextureSpace(const Mesh& mesh, int width, int height)
      : surface(make_surface(mesh, {.kind = WeldOptions::Kind::none})),
        atlas(make_atlas(surface, {{.width = width, .height = height}})) {}

  Surface surface;
  Atlas atlas;
};

/// Fills what is not known and an unknown of the texture's space, and makes it known; returns how
/// many texels inside of charts that were.
std::int64_t fill_holes(const TexelSpace& space, const Image<char>& inside, Image<char>& known,
                        Image<float>& picture) {
  const std::vector<Texels::Place>& places = space.texels().places;
  std::vector<char> is_known(places.size());
  for (std::size_t t = 0; t < places.size(); ++t) is_known[t] = known(places[t].x, places[t].y);
  space.scatter(fill_unseen(space, is_known, space.gather({&picture, 1})), {&picture, 1});
  std::int64_t filled = 0;
  for (const Texels::Place& place : places) {
    filled += inside(place.x, place.y) && !known(place.x, place.y);
    known(place.x, place.y) = 1;
  }
  return filled;
}

/// Takes out the steps between regions of equal labels, of which there is one for each pixel.
void take_out_steps(const TexelSpace& space, const Image<int>& label, double alpha,
                    TextureFrame& frame) {
  const Texels& texels = space.texels();
  std::vector<int> labels;
  for (const Texels::Place& at : texels.places) labels.push_back(label(at.x, at.y));
  const Signal psi = space.gather({&frame.picture, 1});
  const Stitcher stitcher(space, alpha * space.scale().area, labels, space.multigrid());
  frame.before = border_jump(stitcher.stiffness(), psi, labels);
  const Signal stitched = stitcher.solve(psi, stitcher.change(psi)).signal;
  frame.after = border_jump(stitcher.stiffness(), stitched, labels);
  space.scatter(stitched, {&frame.picture, 1});
}

/// Gives pixels whose label is negative that of the nearest one where it is not.
void spread_labels(Image<int>& label) {
  Image<char> known(label.width(), label.height(), 1);
  for (int y = 0; y < label.height(); ++y)
    for (int x = 0; x < label.width(); ++x) known(x, y) = label(x, y) >= 0;
  const Image<int> nearest = nearest_known(known), given = label;
  for (int y = 0; y < label.height(); ++y)
    for (int x = 0; x < label.width(); ++x) {
      const int from = nearest(x, y);
      label(x, y) = from < 0 ? 0 : given(from % label.width(), from / label.width());
    }
}

}  // namespace

TextureFrame resample_texture(const Mesh& surface, const Mesh& captured, const ColourAt& colour,
                              const TextureFrameOptions& options, const Progress& progress) {
  require(surface.has_uvs(), "the surface has no texture coordinates to resample into");
  require(options.width >= 1 && options.height >= 1 && options.samples >= 1 && options.samples <= 8,
          fmt::format("a texture of {} × {} texels with {} × {} samples each: wanted at least one "
                      "texel, and 1 to 8 samples",
                      options.width, options.height, options.samples, options.samples));
  const TexelOwners raster(surface, options.width, options.height, options.samples);
  progress.at(0.1);
  const FacingPoints points(surface, captured, options.points);

  TextureFrame frame;
  frame.accuracy = points.accuracy();
  frame.picture = Image<float>(options.width, options.height, 3);
  Image<char> known(options.width, options.height, 1), inside(options.width, options.height, 1);
  const bool stitched = !options.captured_charts.empty();
  require(!stitched || std::ssize(options.captured_charts) == captured.triangle_count(),
          fmt::format("charts of {} captured triangles: wanted one for each of {}",
                      options.captured_charts.size(), captured.triangle_count()));
  Image<int> label(stitched ? options.width : 0, stitched ? options.height : 0, 1);
  std::ranges::fill(label.values(), -1);
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
              const ClosestPoint found = points(owner.triangle, b);
              if (found.triangle < 0) continue;
              if (stitched && label(x, int(y)) < 0)
                label(x, int(y)) = options.captured_charts[found.triangle];
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
  progress.at(0.8);
  spread(known, std::numeric_limits<double>::infinity(), frame.picture);
  if (stitched) spread_labels(label);
  if ((frame.unseen > 0 || stitched) && frame.unseen < frame.texels) {
    const TextureSpace texture(surface, options.width, options.height);
    if (stitched || !refused(texture.atlas.defects)) {
      const TexelSpace space(texture.surface, texture.atlas);
      if (frame.unseen > 0) frame.filled = fill_holes(space, inside, known, frame.picture);
      if (stitched) take_out_steps(space, label, options.alpha, frame);
      spread(known, std::numeric_limits<double>::infinity(), frame.picture);
    }
  }
  frame.inside = std::move(inside);
  return frame;
}

VertexColours resample_vertices(const Mesh& surface, const Mesh& captured, const ColourAt& colour,
                                const FacingPointsOptions& options) {
  const FacingPoints points(surface, captured, options);
  VertexColours result;
  result.accuracy = points.accuracy();
  result.colours = Signal::Constant(surface.vertex_count(), 3, 0.5);
  std::vector<std::array<int, 2>> corner(surface.vertex_count(), {-1, 0});
  for (int t = 0; t < surface.triangle_count(); ++t)
    for (int k = 0; k < 3; ++k) corner[surface.triangles[t][k]] = {t, k};
  std::vector<char> seen(surface.vertex_count(), 0);
  parallel_for(
      surface.vertex_count(),
      [&](std::int64_t v) {
        if (corner[v][0] < 0) return;
        const ClosestPoint found = points(corner[v][0], Vector3::Unit(corner[v][1]));
        if (found.triangle < 0) return;
        const std::array<float, 3> value = colour(found);
        for (int k = 0; k < 3; ++k) result.colours(v, k) = value[k];
        seen[v] = 1;
      },
      64);
  result.unseen = std::ranges::count(seen, 0);
  if (result.unseen == 0 || result.unseen == std::ssize(seen)) return result;
  // In the surface vertices where several fans meet are several.
  const Surface sound = make_surface(surface, {.kind = WeldOptions::Kind::none});
  const std::vector<int>& source = sound.source_from_vertex;
  Signal psi(std::ssize(source), 3);
  std::vector<char> known(source.size());
  for (std::size_t v = 0; v < source.size(); ++v) {
    psi.row(Eigen::Index(v)) = result.colours.row(source[v]);
    known[v] = seen[source[v]];
  }
  psi = fill_unseen(VertexSpace(sound), known, psi);
  for (std::size_t v = 0; v < source.size(); ++v)
    if (!known[v]) result.colours.row(source[v]) = psi.row(Eigen::Index(v));
  return result;
}

}  // namespace mq

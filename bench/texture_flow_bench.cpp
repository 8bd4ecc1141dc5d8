// Optical flow of textures: known motions found again, in the texels and on triangles cut to their size.
//
//     texture_flow_bench [SIDE [TEXELS...]]   a torus in four charts, a texture of SIDE² (1024), turned by so many texels
//                                             (1, 4, 16): endpoint errors, and seconds of processor time of all threads

#include <fmt/format.h>

#include <cstdlib>
#include <ctime>
#include <vector>

#include <Eigen/Geometry>

#include "fem/cut_squares.h"
#include "mq/flow/cut_texture_flow.h"
#include "mq/flow/texture_flow.h"
#include "mq/sample/noise.h"

namespace mq {
namespace {

double processor_seconds() { return double(std::clock()) / CLOCKS_PER_SEC; }

/// Positions in space as a signal: where a path goes is what is looked up of them.
Signal places_of(const TexelSpace& space) {
  Signal places(space.size(), 3);
  for (int i = 0; i < space.size(); ++i) places.row(i) = space.texels().position(i);
  return places;
}

Signal turned(const Signal& places, double angle) {
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(angle, Vector3::UnitZ()).toRotationMatrix();
  return places * turn.transpose();
}

Signal colours(const Signal& places) {
  const Noise noise(7);
  Signal values(places.rows(), 3);
  for (Eigen::Index i = 0; i < places.rows(); ++i)
    for (int c = 0; c < 3; ++c)
      values(i, c) = noise(Vector3(12 * places.row(i).transpose() + Vector3(31.4, 7.3, 3.7) * c));
  return values;
}

void compare(int side, const std::vector<double>& motions) {
  const auto cut = fixtures::turned(fixtures::odd_angle);
  const Mesh mesh = fixtures::cut_torus({.cells = 96, .parts = 2, .jitter = 0, .scale = cut.scale, .angle = cut.angle,
                                         .shift = cut.shift});
  const auto model = fixtures::textured(mesh, {{side, side}});
  const TexelSpace space(model->surface, model->atlas);
  const double texel = space.scale().texel_spacing;
  const Signal places = places_of(space), source = colours(places);
  fmt::print("{} texels\n\n| turned by, texels | how | endpoint error, texels | seconds |\n|---|---|---|---|\n", space.size());
  for (const double texels : motions) {
    const double angle = texels * texel;
    const Signal target = colours(turned(places, -angle)), truth = turned(places, angle);
    MeshFlowOptions options;
    options.detail = {};
    options.largest = {std::max(8.0, 2 * texels) * texel, Length::Unit::model};
    const auto row = [&](const char* how, const auto& flow, double seconds) {
      const Signal ends = flow.warp_pair(places, places, 0).target;
      fmt::print("| {:g} | {} | {:.3f} | {:.1f} |\n", texels, how, (ends - truth).rowwise().norm().mean() / texel, seconds);
    };
    double begun = processor_seconds();
    const TextureFlow in_texels(model->surface, model->atlas, space, source, target, options);
    row("texels", in_texels, processor_seconds() - begun);
    begun = processor_seconds();
    const CutTextureFlow on_cut(model->surface, model->atlas, space, source, target, options, 2);
    row("triangles cut to 2 texels", on_cut, processor_seconds() - begun);
  }
}

}  // namespace
}  // namespace mq

int main(int count, char** arguments) {
  std::vector<double> motions;
  for (int k = 2; k < count; ++k) motions.push_back(std::atof(arguments[k]));
  if (motions.empty()) motions = {1, 4, 16};
  mq::compare(count > 1 ? std::atoi(arguments[1]) : 1024, motions);
}

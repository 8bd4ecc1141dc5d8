// Optical flow of textures: known motions found again, in the texels and on triangles cut to their size.
//
//     texture_flow_bench [SIDE [TEXELS...]]
//
// A torus in four charts, a sphere and a bust, textures of SIDE² (1024), all that is on them moved around the vertical by
// so many texels in the mean (1, 4, 16): endpoint errors, and seconds of processor time of all threads.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include <Eigen/Geometry>

#include "fem/cut_squares.h"
#include "flow/moved_signals.h"
#include "mq/flow/cut_texture_flow.h"
#include "mq/flow/texture_flow.h"
#include "mq/linear/block_multigrid.h"
#include "mq/mesh/geometry.h"
#include "mq/sample/sample.h"
#include "mq/trace/atlas_flow.h"

namespace mq {
namespace {

double processor_seconds() { return double(std::clock()) / CLOCKS_PER_SEC; }

/// Noise as fine on everything, by its area.
Signal colours(const Signal& places, double area) {
  const double scale = 53 / std::sqrt(area);
  Signal values(places.rows(), 3);
  for (Eigen::Index i = 0; i < places.rows(); ++i) values.row(i) = fixtures::colour_at(scale * places.row(i).transpose());
  return values;
}

/// A model, its texels, and a field along which colours move: as a rotation about the vertical would, in each plane, smoothed.
struct Moving {
  Moving(const Mesh& mesh, int side)
      : model(fixtures::textured(mesh, {{side, side}})),
        space(model->surface, model->atlas),
        domain(model->surface, model->atlas, space),
        vectors(model->surface, model->atlas, space),
        starts(domain.starts().places) {
    TangentField turn(std::size_t(model->surface.triangle_count()));
    for (int t = 0; t < model->surface.triangle_count(); ++t) {
      const Mesh& m = model->surface.mesh;
      const Vector3 normal = triangle_normal(m, t),
                    X = Vector3::UnitZ().cross((m.position(t, 0) + m.position(t, 1) + m.position(t, 2)) / 3);
      turn[std::size_t(t)] = X - normal * normal.dot(X);
    }
    field = smoothed(vectors.from_triangles(turn));
    double sum = 0;
    for (int i = 0; i < space.size(); ++i) sum += field.segment<2>(2 * std::int64_t(i)).norm();
    field *= space.scale().texel_spacing * space.size() / sum;
  }

  /// (M + ℓ²L)⁻¹·M·X, ℓ a tenth of √area: on what is not round, rotations are no motions of the surface, but fold it.
  Vector smoothed(const Vector& X) const {
    const double area = space.scale().area;
    BlockMultigrid multigrid(vectors.transfers(1, 0.01 * area));
    multigrid.set_matrix(vectors.regularised_system(1, 0.01 * area));
    Vector result = X;
    multigrid.solve(scalar_matrix(vectors.system(1, 0)) * X, result);
    return result;
  }

  /// Where texels are so long later, in space; the field is one texel long in the mean.
  Signal after(double time) const {
    const auto velocities = vectors.velocities((time < 0 ? -1.0 : 1.0) * field);
    const auto ends = AtlasFlow::along(domain, velocities).trace(starts, std::abs(time)).ends;
    Signal places(space.size(), 3);
    for (int i = 0; i < space.size(); ++i) places.row(i) = domain.position(ends[std::size_t(i)]);
    return places;
  }

  std::unique_ptr<fixtures::Textured> model;
  TexelSpace space;
  TraceAtlas domain;
  TexelVectorSpace vectors;
  std::vector<ChartPlace> starts;
  Vector field;
};

Mesh torus_in_four_charts() {
  const auto cut = fixtures::turned(fixtures::odd_angle);
  return fixtures::cut_torus({.cells = 96, .parts = 2, .jitter = 0, .scale = cut.scale, .angle = cut.angle,
                              .shift = cut.shift});
}

void compare(const std::string& name, int side, const std::vector<double>& motions) {
  const Moving moving(name == "torus" ? torus_in_four_charts() : make_sample(name, {.texture_size = side}).mesh, side);
  const TexelSpace& space = moving.space;
  const auto& [surface, atlas] = std::tie(moving.model->surface, moving.model->atlas);
  const double texel = space.scale().texel_spacing, area = space.scale().area;
  const Signal source = colours(moving.after(0), area);
  fmt::print("{}, {} texels\n\n", name, space.size());
  fmt::print("| moved by, texels | how | mean error, texels | half below | 95 % below | seconds |\n|---|---|---|---|---|---|\n");
  for (const double texels : motions) {
    const Signal target = colours(moving.after(-texels), area), truth = moving.after(texels),
                 places = moving.after(0);
    MeshFlowOptions options;
    options.detail = {};
    options.largest = {std::max(8.0, 2 * texels) * texel, Length::Unit::model};
    const auto row = [&](const char* how, const auto& flow, double seconds) {
      Vector errors = (flow.warp_pair(places, places, 0).target - truth).rowwise().norm() / texel;
      std::sort(errors.begin(), errors.end());
      const auto below = [&](double share) { return errors[std::int64_t(share * double(errors.size() - 1))]; };
      fmt::print("| {:g} | {} | {:.3f} | {:.3f} | {:.3f} | {:.1f} |\n", texels, how, errors.mean(), below(0.5),
                 below(0.95), seconds);
    };
    double begun = processor_seconds();
    const TextureFlow in_texels(surface, atlas, space, source, target, options);
    row("texels", in_texels, processor_seconds() - begun);
    begun = processor_seconds();
    const CutTextureFlow on_cut(surface, atlas, space, source, target, options, 2);
    row("triangles cut to 2 texels", on_cut, processor_seconds() - begun);
  }
}

}  // namespace
}  // namespace mq

int main(int count, char** arguments) {
  std::vector<double> motions;
  for (int k = 2; k < count; ++k) motions.push_back(std::atof(arguments[k]));
  if (motions.empty()) motions = {1, 4, 16};
  for (const char* name : {"torus", "sphere", "bust"})
    mq::compare(name, count > 1 ? std::atoi(arguments[1]) : 1024, motions);
}

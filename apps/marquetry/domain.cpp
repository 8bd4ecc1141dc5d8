#include "domain.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "mq/atlas/coverage.h"
#include "mq/atlas/texel_grid.h"
#include "mq/base/error.h"
#include "mq/baseline/reference_solver.h"
#include "mq/fem/multigrid_solver.h"
#include "mq/fem/vertex_multigrid.h"

namespace mq::app {
namespace {

template <class SolverOptions>
SolverOptions stopping(const WhenToStop& when) {
  SolverOptions options;
  options.tolerance = when.tolerance;
  options.max_cycles = when.cycles.value_or(options.max_cycles);
  return options;
}

/// Texels of which the picture shows one of several values.
Defects shared_texels(const TexelCopies& copies, const std::vector<TextureSize>& pictures) {
  std::vector<std::int64_t> ids;
  const TexelGrid grid(pictures);
  for (const Texels::Place& at : copies.shared()) ids.push_back(grid.texel(at.texture, at.x, at.y));
  Defects defects;
  add_defect(
      defects, "shared_texels", Defect::Severity::warning, "texel", ids,
      "texels that stand for several places of the surface (ids counted row by row): each "
      "place was worked out by itself, and the picture can show one of them, that of the chart "
      "which covers the texel's centre; a wider gutter or a larger texture parts them");
  return defects;
}

double larger(double largest, double value) {
  return std::isfinite(value) ? std::max(largest, value) : largest;
}

}  // namespace

SurfaceScale Domain::scale() const {
  SurfaceScale scale = space().scale();
  if (!(scale.texel_spacing > 0)) scale.texel_spacing = std::sqrt(scale.area / space().size());
  return scale;
}

TexelDomain::TexelDomain(Run& run, const Scene& scene, const TexelSpaceOptions& options,
                         const Progress& progress, SharedTexels shared)
    : scene_(scene) {
  Progress rest = progress;
  if (shared == SharedTexels::one_for_each) {
    apart_ = separate_overlaps(scene.surface, *scene.atlas, progress.step("lay charts apart", 0.2));
    rest = progress.step("texels", 0.8);
  }
  space_.emplace(scene.surface, atlas(), options, rest);
  if (apart_) copies_.emplace(scene.surface, *apart_, *space_);
  const Defects defects =
      copies_ ? shared_texels(*copies_, scene.texture_sizes) : space_->defects();
  run.found(defects);
  run.warn(defects);
}

std::vector<int> TexelDomain::unknowns_at(const Texels::Place& texel) const {
  if (copies_) return copies_->meant(texel);
  const auto raster = [](const Texels::Place& p) { return std::tuple(p.texture, p.y, p.x); };
  const std::vector<Texels::Place>& places = space_->texels().places;
  const auto at = std::ranges::lower_bound(places, raster(texel), {}, raster);
  if (at == places.end() || raster(*at) != raster(texel)) return {};
  return {int(at - places.begin())};
}

void TexelDomain::put(const Signal& values, std::span<Image<float>> pictures) const {
  if (copies_)
    copies_->scatter(values, pictures);
  else
    space_->scatter(values, pictures);
}

std::vector<Vector3> TexelDomain::places() const {
  std::vector<Vector3> places;
  places.reserve(std::size_t(space_->size()));
  for (int i = 0; i < space_->size(); ++i) places.push_back(space_->texels().position(i));
  return places;
}

std::vector<int> TexelDomain::boundary() const {
  return boundary_unknowns(scene_.surface, atlas(), *space_);
}

/// At the centres of texels that triangles cover, at the corners of triangles, along boundaries.
double TexelDomain::largest_shown(const Vector& values) const {
  double largest = 0;
  const std::vector<Coverage> coverage = texel_coverage(scene_.surface, atlas());
  const Texels& texels = space_->texels();
  for (int i = 0; i < texels.size(); ++i) {
    const Texels::Place& at = texels.places[std::size_t(i)];
    if (coverage[std::size_t(at.texture)].triangle(at.x, at.y) >= 0)
      largest = larger(largest, values[i]);
  }
  const auto look_at = [&](int triangle, const Vector3& barycentric) {
    double sum = 0;
    for (const TexelWeight& w : space_->basis_at(triangle, barycentric))
      sum += w.weight * values[w.texel];
    largest = larger(largest, sum);
  };
  for (int t = 0; t < scene_.surface.triangle_count(); ++t)
    for (int k = 0; k < 3 && atlas().chart[t] >= 0 && !scene_.surface.degenerate[t]; ++k)
      look_at(t, Vector3::Unit(k));
  for (const BoundaryPoint& p :
       boundary_points(scene_.surface, atlas(), space_->scale().texel_spacing / 2))
    look_at(p.triangle, p.barycentric);
  return largest;
}

double VertexDomain::largest_shown(const Vector& values) const {
  double largest = 0;
  for (const double value : values) largest = larger(largest, value);
  return largest;
}

SolverFactory TexelDomain::multigrid(const WhenToStop& when) const {
  return multigrid_solver(space_->texels(), stopping<MultigridOptions>(when));
}

SolverFactory TexelDomain::reference(const WhenToStop& when) const {
  return reference_solver(space_->texels(), stopping<ReferenceOptions>(when));
}

SolverFactory VertexDomain::multigrid(const WhenToStop& when) const {
  return vertex_multigrid_solver(scene_.surface.mesh.positions, stopping<MultigridOptions>(when));
}

SolverFactory VertexDomain::reference(const WhenToStop&) const {
  throw Unsupported("--solver reference is for textures; use direct or multigrid at vertices");
}

}  // namespace mq::app

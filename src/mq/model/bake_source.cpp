#include "mq/model/detail/bake_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/base/parallel.h"
#include "mq/mesh/geometry.h"
#include "mq/model/detail/tangent_texels.h"

namespace mq {
namespace {

/// Whether the source's textures hold vectors.
bool shows_vectors(const TexturedModel& source) {
  const std::vector<Texture>& textures = source.model.textures;
  return source.surface.mesh.has_uvs() && !textures.empty() &&
         textures.front().pixels.channels() >= 2 &&
         textures.front().meaning == TextureMeaning::normals;
}

NormalMapShares shares_of(const TexturedModel& source) {
  if (source.atlas) return normal_map_shares(source, texel_coverage(source.surface, *source.atlas));
  std::vector<TextureSize> sizes;
  for (const Texture& texture : source.model.textures)
    sizes.push_back({texture.pixels.width(), texture.pixels.height(), texture.wrap});
  return normal_map_shares(source,
                           texel_coverage(source.surface, make_atlas(source.surface, sizes)));
}

void require_vectors(const TexturedModel& source, const NormalMapShares& shares) {
  const bool has_z = source.model.textures.front().pixels.channels() >= 3 && !shares.without_z;
  require(has_z, fmt::format(
                     "{}: holds x and y alone (BC5): write z = √(1 − x² − y²) as its third channel",
                     texture_file(source.model, 0)));
}

void require_charts_apart(const TexturedModel& target) {
  require(!charts_overlap(texel_coverage(target.surface, *target.atlas)),
          fmt::format(
              "{}: its charts lie on top of each other, so that one texel would be another normal "
              "in each of them: give it charts of their own (unwrap), or bake another slot ({})",
              target.model.path.string(), option_name("slot")));
}

}  // namespace

BakeSource::BakeSource(const TexturedModel& source, const Mesh& mesh, const TexturedModel& target,
                       const ModelSignal& signal, const BakeOptions& options)
    : source_(source), mesh_(mesh) {
  const bool of_shape = options.shown == BakeOptions::Shown::shading_normals;
  if (of_shape || shows_vectors(source)) find_normals(target, signal, options);
  if (of_shape)
    spacing_ = std::sqrt(total_area(mesh) / std::max(1, mesh.vertex_count()));
  else
    colours_.emplace(source.model, mesh, normals_ ? ValueSpace{} : options.values, options);
}

void BakeSource::find_normals(const TexturedModel& target, const ModelSignal& signal,
                              const BakeOptions& options) {
  NormalAxes axes = NormalAxes::tangent;
  if (options.shown == BakeOptions::Shown::pictures) {
    const NormalMapShares shares = shares_of(source_);
    require_vectors(source_, shares);
    axes = found_axes(source_, options.values.axes, shares);
    if (axes == NormalAxes::object && !options.to_tangent_space) return;
  }
  if (!signal.texel_space())
    throw Unsupported(
        source_.model.path.string() +
        ": its normals are baked in tangent space, which vertices have not: bake them to a "
        "texture");
  require_charts_apart(target);
  const bool is_down = axes == NormalAxes::tangent_down && !options.to_tangent_space;
  std::shared_ptr<const ShadingFrames> of_source;
  if (axes != NormalAxes::object) of_source = std::make_shared<const ShadingFrames>(source_, axes);
  normals_ = std::make_shared<const BakedNormals>(
      std::move(of_source), std::make_shared<const ShadingFrames>(
                                target, is_down ? NormalAxes::tangent_down : NormalAxes::tangent));
}

/// n where the map of the source says `stored`; its shading normal is `shading`.
Vector3 BakeSource::shown_normal(const SurfacePoint& point, std::span<const double> stored,
                                 const Vector3& shading) const {
  const Vector3 mapped(2 * stored[0] - 1, 2 * stored[1] - 1, 2 * stored[2] - 1);
  if (!normals_->source) return mapped.norm() > 0 ? Vector3(mapped.normalized()) : shading;
  if (is_flat(mapped, half_vector_step(colours_->depth()))) return shading;
  return normals_->source->at(point).to_model(mapped);
}

bool BakeSource::at(const SurfacePoint& on_source, const SurfacePoint& on_target,
                    std::span<double> values) const {
  if (colours_ && !colours_->at(on_source, values)) return false;
  if (!normals_) return true;
  SurfacePoint point = on_source;  // of the mesh as its frames have it
  const auto t = std::size_t(point.triangle);
  if (mesh_.triangles[t] != source_.model.mesh.triangles[t])
    std::swap(point.barycentric[1], point.barycentric[2]);
  const Vector3 of_target = normals_->target->at(on_target).normal.normalized();
  Vector3 shading = of_target;
  if (normals_->source) shading = normals_->source->at(point).normal.normalized();
  Vector3 n = colours_ ? shown_normal(point, values, shading) : shading;
  if (shading.dot(of_target) < 0) n = -n;
  const Vector3 added = n - of_target;
  for (int c = 0; c < 3; ++c) values[std::size_t(c)] = added[c];
  return true;
}

Signal coded_normals(const BakedNormals& normals, const Signal& values, const TexelSpace& space,
                     const TexturedModel& target) {
  const TangentTexels texels(normals.target,
                             texel_places(target.surface, *target.atlas, space.texels(),
                                          texel_coverage(target.surface, *target.atlas)));
  Signal coded = values;
  parallel_for(values.rows(), [&](std::int64_t k) {
    const Vector3 mapped = texels.mapped(int(k), values.row(k).head<3>().transpose());
    coded.row(k).head<3>() = ((mapped.array() + 1) / 2).matrix().transpose();
  });
  return coded;
}

}  // namespace mq

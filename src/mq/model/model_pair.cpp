#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/fem/flat_triangle.h"
#include "mq/model/detail/pair_checks.h"
#include "mq/model/signal_pair.h"

namespace mq {
namespace {

bool is_constant(const Signal& signal) {
  if (signal.rows() == 0) return true;
  const Eigen::RowVectorXd low = signal.colwise().minCoeff(), high = signal.colwise().maxCoeff();
  return ((high - low).array() <= least_range * low.array().abs().max(high.array().abs())).all();
}

}  // namespace

ModelPair::ModelPair(const TexturedModel& model, std::vector<Texture> second,
                     const ValueSpace& values, Messages& messages, const Progress& progress)
    : model_(model) {
  const std::vector<Texture>& own = model.model.textures;
  require(second.size() == own.size(),
          fmt::format("{} for {} of the model: one for each is wanted",
                      counted(std::ssize(second), "picture"),
                      counted(std::ssize(own), "texture")));
  for (std::size_t i = 0; i < second.size(); ++i)
    require_alike(second[i], second[i].path.string(), own[i], texture_file(model.model, i));
  auto target =
      std::make_unique<TextureSignal>(model, TextureSignalOptions{.values = values}, messages,
                                      progress);
  first_ = target->values();
  second_ = target->values_of(second);
  for (Texture& texture : second) second_pictures_.push_back(std::move(texture.pixels));
  target_ = std::move(target);
}

ModelPair::ModelPair(const TexturedModel& model, const Model& second, Messages& messages)
    : model_(model) {
  const Model& first = model.model;
  const std::string file = second.path.string(), name = first.path.string();
  require(first.colors.channels > 0, name + ": has no colours at its vertices to align");
  auto target = std::make_unique<VertexColourSignal>(model);
  require(second.mesh.vertex_count() == first.mesh.vertex_count() &&
              second.colors.channels == first.colors.channels,
          fmt::format("{}: has {} with {} of colour, and {} has {} with {}: the same vertices in "
                      "the same order are wanted",
                      file, counted(second.mesh.vertex_count(), "vertex"),
                      counted(second.colors.channels, "channel"), name,
                      counted(first.mesh.vertex_count(), "vertex"),
                      counted(first.colors.channels, "channel")));
  for (std::size_t i = 0; i < second.colors.values.size(); ++i)
    require(std::isfinite(second.colors.values[i]),
            fmt::format("{}: a colour of vertex {} (counted from 0) is {}; it must be finite", file,
                        i / std::size_t(second.colors.channels), second.colors.values[i]));
  if (second.mesh.triangles != first.mesh.triangles)
    messages.warning(fmt::format(
        "{}: its triangles are not those of {}: colours are compared vertex by vertex, in "
        "the order of the files",
        file, name));
  first_ = target->values();
  second_ = target->values_of(second.colors);
  second_colors_ = second.colors;
  target_ = std::move(target);
}

Likeness ModelPair::likeness() const {
  return {is_constant(first_), is_constant(second_), first_ == second_};
}

double ModelPair::quick_edge(double longest_edge) const {
  double texels = 0;  // also of charts that lie upon each other
  for (const Chart& chart : model_.atlas->charts) texels += chart.texel_area;
  double vertices = expected_vertices(int(std::min(texels, 2e9)), longest_edge);
  if (!(vertices > quick_vertices / 4)) return longest_edge;
  // Narrow triangles make more: counted on a cut that is as much coarser as makes it cheap.
  const double coarser = std::sqrt(std::max(1.0, 16 * vertices / quick_vertices));
  const TexelSpace& space = *target_->texel_space();
  const RefinedTexture sparse(model_.surface, *model_.atlas, space, coarser * longest_edge);
  const int added = sparse.fine().surface.mesh.vertex_count() - model_.surface.mesh.vertex_count();
  vertices = std::max(vertices, added * coarser * coarser);
  return vertices > quick_vertices ? longest_edge * std::sqrt(vertices / quick_vertices)
                                   : longest_edge;
}

ModelPairFlow ModelPair::align(const ModelFlowOptions& options, const Progress& progress) const {
  ModelPairFlow found(*this);
  about(model_.model, [&] {
    if (at_vertices()) {
      found.flow_ = mesh_flow(model_.surface, first_, second_, options, progress.step("align", 0.95));
      found.mesh_ =
          std::make_unique<TraceMesh>(model_.surface, progress.step("order triangles", 0.05));
      return;
    }
    const TexelSpace& space = *target_->texel_space();
    if (!options.longest_edge) {
      found.textures_ = std::make_unique<TextureFlow>(model_.surface, *model_.atlas, space, first_, second_, options,
                                                      progress);
      return;
    }
    MeshFlowOptions on_cut = options;
    // The cut mesh that flow works on has no texels.
    for (Length* length : {&on_cut.largest, &on_cut.smallest, &on_cut.detail})
      if (length->unit == Length::Unit::texels)
        *length = {length->value * target_->space().scale().texel_spacing, Length::Unit::model};
    found.cut_ = std::make_unique<CutTextureFlow>(model_.surface, *model_.atlas, space, first_, second_, on_cut,
                                                  *options.longest_edge, progress);
  });
  return found;
}

/// What the surface shows of these values.
void ModelPair::put_shown(const Signal& values, Model& into) const {
  // Where both pictures agree with the signal before, `put` changes nothing: all of the first's.
  Model shown = model_.model;
  target_->put(first_, values, shown);
  if (at_vertices()) {
    const std::vector<int>& unknowns = model_.surface.vertex_from_source;
    const int channels = into.colors.channels;
    for (std::size_t v = 0; v < unknowns.size(); ++v)
      if (unknowns[v] >= 0)
        std::copy_n(&shown.colors.values[v * channels], channels,
                    &into.colors.values[v * channels]);
    return;
  }
  for (const Texels::Place& place : target_->texel_space()->texels().places) {
    const auto from = shown.textures[std::size_t(place.texture)].pixels.pixel(place.x, place.y);
    std::ranges::copy(
        from, into.textures[std::size_t(place.texture)].pixels.pixel(place.x, place.y).begin());
  }
}

Model ModelPair::with(const Signal& values, double t) const {
  Model model = model_.model;
  const auto mix = [t](std::span<float> first, std::span<const float> second) {
    for (std::size_t i = 0; i < first.size(); ++i)
      first[i] = t == 1 ? second[i] : float(first[i] + t * (double(second[i]) - first[i]));
  };
  if (t > 0 && at_vertices()) mix(model.colors.values, second_colors_.values);
  for (std::size_t i = 0; i < second_pictures_.size() && t > 0; ++i)
    mix(model.textures[i].pixels.values(), second_pictures_[i].values());
  if (t < 1) put_shown(values, model);
  return model;
}

int ModelPairFlow::vertices() const {
  return cut_ ? cut_->vertices() : pair_->target().space().size();
}

WarpedPair ModelPairFlow::warp_pair(double t, const Progress& progress) const {
  if (textures_) return textures_->warp_pair(pair_->first(), pair_->second(), t, progress);
  if (cut_) return cut_->warp_pair(pair_->first(), pair_->second(), t, progress);
  return mq::warp_pair(*mesh_, flow_.field, pair_->first(), pair_->second(), t, progress);
}

Signal ModelPairFlow::between(double t, const Progress& progress) const {
  if (t == 0) return pair_->first();
  if (t == 1) return pair_->second();
  const WarpedPair warped = warp_pair(t, progress);
  return warped.source + t * (warped.target - warped.source);
}

TangentField ModelPairFlow::field() const {
  return textures_ ? textures_->field()
         : cut_    ? cut_->field()
                   : field_in_space(pair_->model().surface, flow_.field);
}

}  // namespace mq

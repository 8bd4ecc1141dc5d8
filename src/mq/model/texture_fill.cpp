#include "mq/model/texture_fill.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "mq/base/error.h"
#include "mq/filter/stitch.h"

namespace mq {
namespace {

const Atlas& atlas_of(const TexturedModel& model) {
  require(model.atlas.has_value(),
          model.model.path.string() + ": has no texture coordinates"
              ", so no charts to fill around; the verb unwrap makes some");
  return *model.atlas;
}

const FillOptions& checked(const FillOptions& options) {
  require(options.weight >= 0 && options.distance >= 0,
          fmt::format("a fill of weight {} to a distance of {} was asked for: neither may be negative",
                      options.weight, options.distance));
  return options;
}

TextureSignalOptions signal_options(const TexturedModel& model, const FillOptions& options) {
  return {.values = options.values, .space = soft_seams(*model.atlas, options.weight),
          .depth = options.depth};
}

}  // namespace

TextureFill::TextureFill(const TexturedModel& model, const FillOptions& options, Messages& messages,
                         const Progress& progress)
    : options_(checked(options)),
      coverage_(texel_coverage(model.surface, atlas_of(model), progress.step("cover", 0.1))),
      signal_(model, signal_options(model, options), messages, progress.step("space", 0.9)),
      border_(mq::border_texels(signal_.space(), coverage_)) {}

std::int64_t TextureFill::border_texels() const { return std::ranges::count(border_, 1); }

TextureFill::Solution TextureFill::solve(const Progress& progress) const {
  Solution solution{.before = signal_.values(), .after = {}, .report = {}};
  Filtered found =
      continue_at_borders(signal_.space(), solution.before, border_, economical_solver(), progress);
  solution.after = std::move(found.signal);
  solution.report = std::move(found.report);
  return solution;
}

std::int64_t TextureFill::put(const Solution& solution, Model& model) const {
  signal_.put(solution.before, solution.after, model);
  std::int64_t outside = 0;
  for (std::size_t k = 0; k < model.textures.size(); ++k)
    outside += spread_past_borders(signal_.space(), int(k), coverage_[k], options_.distance,
                                   model.textures[k].pixels);
  return outside;
}

void spread_past_charts(std::span<const Texels::Place> texels, TexturedModel& model) {
  const std::vector<Coverage> coverage = texel_coverage(model.surface, *model.atlas);
  std::vector<std::vector<Texels::Place>> borders(coverage.size());
  for (const Texels::Place& at : texels)
    if (coverage[std::size_t(at.texture)].count(at.x, at.y) == 0) borders[std::size_t(at.texture)].push_back(at);
  for (std::size_t i = 0; i < model.model.textures.size(); ++i)
    spread_past_borders(borders[i], coverage[i], std::numeric_limits<double>::infinity(), model.model.textures[i].pixels);
}

void spread_past_unseen(const std::vector<int>& labels, const TexelSpace& space, const TexturedModel& model,
                        Model& changed) {
  std::vector<char> filled;
  for (const int label : labels) filled.push_back(label == unseen);
  if (std::ranges::count(filled, 1) == 0) return;
  const std::vector<Coverage> coverage = texel_coverage(model.surface, *model.atlas);
  for (std::size_t i = 0; i < changed.textures.size(); ++i)
    spread_past_borders_of(filled, space, int(i), coverage[i], changed.textures[i].pixels);
}

}  // namespace mq

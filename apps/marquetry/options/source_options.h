#pragma once
/// Where distances begin: --from and --from-mask.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "options/signal_options.h"
#include "mq/filter/geodesic.h"
#include "mq/mesh/closest_point.h"
#include "mq/model/model_sources.h"

namespace mq::app {

void add_source_options(OptionTable& table);

/// One --from, found on the surface before anything is assembled.
struct SourcePlace {
  std::string text;  ///< as given
  std::optional<SurfacePoint> on_surface = {};
  std::optional<Texels::Place> texel = {};
  int vertex = -1;  ///< of the surface, where neither of the two is there
};

/// What --from says. Throws `InvalidInput` with what was found and the remedy where it says
/// something that is not on the surface; whether a chart uses a texel only `sources_at` can tell.
/// Warns of places far from it. `closest` is of the scene's surface; null: one is made where it is
/// wanted.
std::vector<SourcePlace> source_places(Run& run, const TexturedModel& scene,
                                       const ClosestPointFinder* closest = nullptr);

/// Throws `InvalidInput`: no chart uses the texel that is named so.
[[noreturn]] void refuse_texel(const TexturedModel& scene, const std::string& text);

/// The same and --from-mask, as unknowns of the domain.
std::vector<GeodesicSource> sources_at(const Run& run, const TexturedModel& scene, const ModelSignal& domain,
                                       std::span<const SourcePlace> places);

}  // namespace mq::app

#pragma once
/// Where distances begin, found by the processes that have the texels there.

#include "copies.h"
#include "mq/model/textured_model.h"
#include "numbering.h"
#include "options/source_options.h"

namespace mq::shared {

/// The model and its part here, by an atlas that shares no texels.
struct SourceSpace {
  const Processes& processes;
  const TexturedModel& scene;
  const Atlas& atlas;
  const TexelPart& part;
  const Numbering& numbering;
  const SharedCopies& copies;
};

/// One at a point, known to all processes.
struct PointSource {
  std::int64_t number = 0;  ///< of its texel
  double distance = 0;
  double at[3] = {};
};

struct SharedSources {
  std::vector<PointSource> points;
  std::vector<int> marked;  ///< own unknowns that masks show
  std::int64_t count = 0;   ///< of all processes
};

/// What `sources_at` finds on one machine. As long as the part has a space. Every process must call it.
SharedSources shared_sources(const app::Run& run, const SourceSpace& space, std::span<const app::SourcePlace> places);

/// The own unknowns among these and those around points, as `grown_sources` finds them. `heat` and `positions` are of
/// the part's space. Every process must call it.
std::vector<GeodesicSource> grown_here(const SourceSpace& space, const SharedSources& sources, const SparseMatrix& heat,
                                       std::span<const Vector3> positions);

/// Those alone, nothing around points.
std::vector<GeodesicSource> sources_here(const SourceSpace& space, const SharedSources& sources);

}  // namespace mq::shared

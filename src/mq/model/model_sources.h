#pragma once
/// Where distances on a model begin, as unknowns of its signal.

#include <span>
#include <vector>

#include "mq/filter/geodesic.h"
#include "mq/image/image.h"
#include "mq/mesh/surface_point.h"
#include "mq/model/model_signal.h"

namespace mq {

/// The unknowns around a point of the surface, at their straight distances from it.
std::vector<GeodesicSource> sources_at_point(const TexturedModel& model, const ModelSignal& signal,
                                             const SurfacePoint& point);

/// The same of a space of texels.
std::vector<GeodesicSource> sources_at_point(const Mesh& mesh, const TexelSpace& texels, const SurfacePoint& point);

/// Those of a texel of the pictures; none where no chart reads it.
std::vector<GeodesicSource> sources_at_texel(const ModelSignal& signal, const Texels::Place& texel);

/// Those of the texels that pictures, one for each texture and of its size, show brighter than half in
/// their first channel.
std::vector<GeodesicSource> sources_in_masks(const ModelSignal& signal,
                                             std::span<const Image<float>> masks);

}  // namespace mq

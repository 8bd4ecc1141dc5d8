#pragma once
/// What of a model is stitched: its colours, and which photograph each texel comes from.
///
///     const StitchRegions regions = regions_of_labels(model, signal,
///     {{read_texture("labels.png")}}, {}, messages); const Stitcher stitcher(signal.space(),
///     weight, regions.labels); signal.put(regions.values, stitcher.stitch(regions.values,
///     regions.partials).signal, model.model);

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "mq/filter/stitch.h"
#include "mq/model/messages.h"
#include "mq/model/model_signal.h"

namespace mq {

struct StitchRegions {
  Signal values;                       ///< per unknown
  std::vector<int> labels;             ///< its region, or `unseen`
  std::vector<Partial> partials = {};  ///< photographs that it was put together of, if it was

  std::int64_t count() const;         ///< regions that are seen
  std::int64_t count_unseen() const;  ///< unknowns
  bool is_stitchable() const { return count() > 1 || (count() == 1 && count_unseen() > 0); }
};

/// Throws `InvalidInput` naming the picture where colours that are to be told apart were kept as JPEG.
void require_exact(const Texture& labels);

/// Throws `InvalidInput` naming the picture where there are more regions than photographs make: it is a picture of
/// something else.
void require_labels(const std::filesystem::path& picture, std::int64_t regions);

/// The model's own colours, and the regions that `labels` paint, one picture for each of its
/// textures
/// (`labels_of_pictures`). None: every chart is a region. `unseen_colour` is the label of what no
/// photograph shows, as the pictures store it (0 to 255 in 8 bits): one value, or one for each
/// colour channel. Remarks on pictures of another size than the texture's. Throws `InvalidInput`
/// naming the picture where it was kept as JPEG, in which colours are not exact, or has other
/// channels.
StitchRegions regions_of_labels(const TexturedModel& model, const TextureSignal& signal,
                                std::span<const Texture> labels,
                                const std::optional<std::vector<double>>& unseen_colour,
                                Messages& messages);

/// Colours of photographs: of each the part that `wanted` gives it, elsewhere what shows it best
/// (`best_of`).
StitchRegions regions_of_photographs(std::vector<Partial> photographs,
                                     std::span<const int> wanted = {});

/// The number of the photograph that each unknown is wanted of, painted as the first channel of one
/// picture for each texture; `unseen` where they are transparent. Throws `InvalidInput` naming the
/// picture where it does not keep whole numbers exactly, or has one of `count` or more.
std::vector<int> wanted_photographs(const TextureSignal& signal,
                                    std::span<const TextureSize> textures,
                                    std::span<const Texture> labels, int count);

}  // namespace mq

#pragma once
/// Where a verb works how strongly: --mask and --spot.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "mq/filter/modulation.h"
#include "options/signal_options.h"
#include "shell/results.h"

namespace mq::app {

/// Adds --mask and --spot.
void add_mask_options(OptionTable& table, const std::string& group);

/// Refuses files of --mask that cannot be read, before any work. Throws `InvalidInput` or `IoError`.
void check_mask(Run& run, const TexturedModel& scene);

/// The mask that the options describe, one number from −1 to 1 per unknown of the target; nothing
/// where they describe none. Throws `InvalidInput` or `IoError` naming the file and the remedy.
std::optional<std::vector<double>> asked_mask(Run& run, const TexturedModel& scene, const ModelSignal& target,
                                              const Progress& progress);

/// A picture of --mask for a texture of this size.
struct MaskPicture {
  Image<float> pixels;
  std::vector<std::string> remarks;  ///< on its values and size
};
MaskPicture read_mask(const std::string& file, const TextureSize& size);

/// Where a texel that --spot names lies; nothing where no chart uses it.
using PlaceOfTexel = std::function<std::optional<Vector3>(const Texels::Place& texel)>;

/// The spots of --spot. Throws `InvalidInput` for a texel that no chart uses.
std::vector<Spot> asked_spots(const OptionValues& options, const TexturedModel& scene, const SurfaceScale& scale,
                              const PlaceOfTexel& place_of_texel);

/// That a spot changed nothing.
std::string spot_without_effect(const Spot& spot, const TexturedModel& scene);

/// For the report: the mask's mean, the share of unknowns where it is not 0, and where it is below.
Json mask_json(double mean, double share, double below);

}  // namespace mq::app

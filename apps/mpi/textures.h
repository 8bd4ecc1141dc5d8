#pragma once
/// The textures of one model among processes: each has the values of its own texels, and writes some of the pictures.

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "mq/fem/texel_part.h"
#include "mq/model/outputs.h"
#include "mq/model/part_values.h"
#include "mq/model/textured_model.h"
#include "numbering.h"
#include "processes.h"
#include "shell/run.h"

namespace mq::shared {

/// What is refused because it is not shared yet: a sentence to end a message with.
std::string not_yet(const std::string& verb);

/// The model without its pictures, and where the changed ones go. `check` refuses options, before anything is read.
TexturedModel read_scene(app::Run& run, const Processes& processes, const std::string& verb,
                         std::optional<Outputs>& outputs, const std::function<void(const OptionValues&)>& check);

/// The texels of this process.
std::unique_ptr<TexelPart> part_of(app::Run& run, const Processes& processes, const TexturedModel& scene,
                                   const TexelSpaceOptions& how = {});

/// The same of another atlas of its surface, in which charts are laid apart.
std::unique_ptr<TexelPart> part_of(app::Run& run, const Processes& processes, const TexturedModel& scene,
                                   const Atlas& atlas, const TexelSpaceOptions& how = {});

/// The weight that `asked` gives for this scale. Throws `InvalidInput` in all processes for one whose constants
/// `ScreenedPoisson` would treat by themselves.
double checked_weight(const Processes& processes, const std::string& verb, const TexturedModel& scene,
                      const std::function<double(const SurfaceScale&)>& asked);

/// The values of the part's own texels, a row per unknown of its space; no picture is kept.
Signal read_values(app::Run& run, const Processes& processes, const TexturedModel& scene, const TexelPart& part);

/// The numbering of all texels; fills in the halo of these values. Every process must call it.
std::unique_ptr<Numbering> numbered(const Processes& processes, const TexelPart& part, Signal& values);

/// How many of the own texels are marked (1), of all processes. Every process must call it.
std::int64_t count_own(const Processes& processes, const TexelPart& part, const std::vector<char>& marks);

/// Own rows of a signal that has a row per unknown of the part's space.
Signal own_rows(const TexelPart& part, const Signal& all);

/// Such a signal with the changes of its own rows added; those of the halo stay.
Signal with_own_changes(const TexelPart& part, Signal all, const Signal& change);

/// Which process writes the picture of each texture: that with most of its texels. Every process must call it.
std::vector<int> writers(const Processes& processes, const TexelPart& part, std::size_t textures);

/// What is still to be done with a picture where it is written, by number of its texture.
using FinishPicture = std::function<void(std::size_t texture, Texture& picture)>;

/// What became of the values, rows of the part's space, is reported of all processes, gathered where most texels of a
/// picture are, and written there; and of each process it is said what it had to do with.
void write_result(app::Run& run, const Processes& processes, const TexturedModel& scene, const TexelPart& part,
                  const Outputs& outputs, const Signal& before, const Signal& after, const FinishPicture& finish = {});

/// Pictures of values alone, in place of the model's: of each texture what this process has of it is gathered where most
/// of its texels are, and written there, black where nothing is. Every process must call it.
void write_new_pictures(app::Run& run, const Processes& processes, const TexturedModel& scene, const TexelPart& part,
                        const Outputs& outputs, int channels, Depth depth,
                        const std::function<TexelValues(int texture)>& of_texture);

/// How far a filter of this weight reaches.
void report_weight(app::Run& run, const TexturedModel& scene, double weight);

}  // namespace mq::shared

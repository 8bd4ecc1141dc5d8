#pragma once
/// The textures of one model among processes: each has the values of its own texels, and writes some of the pictures.

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "mq/fem/texel_part.h"
#include "mq/model/outputs.h"
#include "mq/model/textured_model.h"
#include "processes.h"
#include "shell/run.h"

namespace mq::shared {

/// What is refused because it is not shared yet: a sentence to end a message with.
std::string not_yet(const std::string& verb);

/// The model without its pictures, and where the changed ones go. `check` refuses options, before anything is read.
TexturedModel read_scene(app::Run& run, const Processes& processes, const std::string& verb,
                         std::optional<Outputs>& outputs, const std::function<void(const OptionValues&)>& check);

/// The texels of this process.
std::unique_ptr<TexelPart> part_of(app::Run& run, const Processes& processes, const TexturedModel& scene);

/// Throws `InvalidInput` in all processes for a weight whose constants `ScreenedPoisson` would treat by themselves.
double checked_weight(const Processes& processes, const std::string& verb, double weight, const SurfaceScale& scale);

/// The values of the part's own texels, a row per unknown of its space; no picture is kept.
Signal read_values(app::Run& run, const Processes& processes, const TexturedModel& scene, const TexelPart& part);

/// Own rows of a signal that has a row per unknown of the part's space.
Signal own_rows(const TexelPart& part, const Signal& all);

/// What became of the values is gathered where most texels of a picture are, and written there.
void write_pictures(app::Run& run, const Processes& processes, const TexturedModel& scene, const TexelPart& part,
                    const Outputs& outputs, const Signal& before, const Signal& after);

/// What the verb reports of the change, of all processes; rows are their own.
void report_change(app::Run& run, const Processes& processes, const Signal& before, const Signal& after, double weight,
                   double area);

/// Of each process what it had to do with.
void report_processes(app::Run& run, const Processes& processes, const TexturedModel& scene, const TexelPart& part);

}  // namespace mq::shared

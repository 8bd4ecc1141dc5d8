#include "verbs/shared/denoise_options.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "options/signal_options.h"
#include "shell/arguments.h"
#include "shell/results.h"

namespace mq::app {

namespace {
constexpr const char* by_edges = "Smoothing up to edges";
}

void add_noise_strength_option(OptionTable& table) {
  table.add({.name = "strength",
             .type = Option::Type::number,
             .default_value = "100",
             .unit = "%",
             .least = 1,
             .most = 1000,
             .group = "Denoise",
             .help = "how much of the noise is taken off: 50 half of it",
             .details = "Above 100 noise is taken for so much stronger than was measured: 200 where some of it is left."});
}

void add_edge_option(OptionTable& table) {
  table.add({.name = "edge",
             .letter = 'e',
             .type = Option::Type::number,
             .least = 0,
             .most = 1e30,
             .group = by_edges,
             .help = "change of the values from texel to texel at which they spread half as well",
             .details = "Of all channels together, in the values of --space. Without it by the noise that "
                        "is measured. 0: its own edges do not count, only those of guides."});
}

void add_steps_option(OptionTable& table) {
  table.add({.name = "steps",
             .type = Option::Type::integer,
             .default_value = as_typed(DenoiseOptions{}.steps),
             .least = 1,
             .most = 1000,
             .group = by_edges,
             .help = "solutions, each with the edges of the one before, after a first slight one"});
}

double asked_noise_strength(const OptionValues& options) {
  return options.has("strength") ? options.number("strength") / 100 : 1;
}

DenoiseOptions asked_edges(const OptionValues& options, const SurfaceScale& scale, double spacing) {
  const bool spread_given = options.given("alpha") || options.given("length");
  DenoiseOptions wanted{
      .weight = spread_given ? spread_weight(options, scale) : std::pow(usual_denoise_length.value * spacing, 2),
      .strength = asked_noise_strength(options),
      .steps = int(options.integer("steps"))};
  if (options.has("edge")) {
    const double edge = options.number("edge");
    wanted.edge = edge > 0 ? edge : std::numeric_limits<double>::infinity();
  }
  return wanted;
}

void say_edge(Run& run, const DenoiseOptions& wanted, double edge) {
  run.result["length"] = std::sqrt(wanted.weight);
  run.result["edge"] = number_json(edge);
  if (wanted.edge) return;
  if (edge > 0)
    run.print(fmt::format("edges kept above {:.3g} from texel to texel, as the noise was measured (--edge)\n", edge));
  else
    say_that_it_is_clean(run);
}

/// Clean textures are, and those of which a quarter and more is constant.
void say_that_it_is_clean(Run& run) {
  run.terminal().remark("there is no noise that can be measured, so nothing was changed; where you see some, --edge "
                        "0.01 smooths up to edges of that height");
}

}  // namespace mq::app

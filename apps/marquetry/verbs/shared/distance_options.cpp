#include "verbs/shared/distance_options.h"

#include <cmath>

#include "mq/draw/false_colour.h"
#include "mq/filter/geodesic.h"
#include "mq/io/file_names.h"
#include "mq/io/held_files.h"
#include "shell/arguments.h"

namespace mq::app {

void add_distance_options(OptionTable& table) {
  using Type = Option::Type;
  table.add({.name = "time",
             .type = Type::number,
             .default_value = as_typed(GeodesicOptions{}.time),
             .least = 1,
             .most = 1e6,
             .group = "Distance",
             .help = "how long heat spreads, in squared texels",
             .details = "Longer is smoother and rounds off the lines where shortest paths meet. Where texels are more than "
                        "twice as long as wide, their longer side counts: half its square."});
  table.add({.name = "metric",
             .type = Type::choice,
             .default_value = "surface",
             .choices = {"surface", "texture"},
             .group = "Distance",
             .help = "lengths are those on the surface, or those in the texture, to compare with",
             .details = "texture: as if the charts were flat and sewn together, with as much area as the surface."});
  table.add({.name = "show",
             .type = Type::choice,
             .default_value = "automatic",
             .choices = {"automatic", "numbers", "colours"},
             .group = "Distance",
             .help = "distances as numbers or as colours with lines of equal distance",
             .details = "automatic: numbers in .exr and .tif, and in memory, in model units; colours elsewhere."});
  table.add({.name = "isolines",
             .type = Type::integer,
             .default_value = as_typed(DistanceColours{}.lines),
             .least = 0,
             .most = 10000,
             .group = "Distance",
             .help = "lines of equal distance, evenly spaced, in colours"});
}

bool by_texture(const OptionValues& options) { return options.text("metric") == "texture"; }

bool writes_numbers(const OptionValues& options, const std::filesystem::path& path) {
  const std::string show = options.text("show");
  if (show != "automatic") return show == "numbers";
  return holds_numbers(path) || names_held(path);
}

Signal distances_as_numbers(const Vector& distance, int channels) {
  Signal values(distance.size(), channels);
  for (Eigen::Index i = 0; i < distance.size(); ++i) {
    const double d = std::isfinite(distance[i]) ? distance[i] : -1;
    values.row(i).setConstant(d);
  }
  return values;
}

Signal distances_as_colours(const OptionValues& options, const Vector& distance, double most, double texel_spacing) {
  return distance_colours(
      distance, {.most = most, .lines = int(options.integer("isolines")), .line_width = 1.5 * texel_spacing});
}

}  // namespace mq::app

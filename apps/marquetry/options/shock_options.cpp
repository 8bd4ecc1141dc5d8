#include "options/shock_options.h"

#include <string>

namespace mq::app {

ShockTime asked_time(const OptionValues& options) {
  if (options.has("absolute-time"))
    return {ShockTime::Unit::absolute, options.number("absolute-time")};
  if (options.has("time")) return {ShockTime::Unit::relative, options.number("time")};
  return options.flag("geometry") ? ShockTime{ShockTime::Unit::relative, usual_shock_time_of_shapes}
                                  : ShockRequest{}.time;
}

namespace {

std::optional<Length> asked_length(const OptionValues& options, const char* name) {
  if (!options.has(name)) return {};
  return parse_length(options.text(name));
}

}  // namespace

ShockRequest shock_request(const OptionValues& options) {
  using Kind = ShockSolverChoice::Kind;
  const std::string solver = options.text("solver");
  return {.time = asked_time(options),
          .smooth = asked_length(options, "smooth"),
          .smooth_potential = asked_length(options, "smooth-potential"),
          .solver = {.kind = solver == "direct"      ? Kind::direct
                             : solver == "multigrid" ? Kind::multigrid
                                                     : Kind::automatic,
                     .tolerance = options.number("tolerance")},
          .smooth_normals = parse_length(options.text("smooth-normals")),
          .fit_alpha = options.number("fit-weight"),
          .fit_steps = int(options.integer("fit-steps"))};
}

}  // namespace mq::app

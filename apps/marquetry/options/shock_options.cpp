#include "options/shock_options.h"

#include <string>

namespace mq::app {

ShockTime asked_time(const OptionValues& options) {
  if (options.has("absolute-time"))
    return {ShockTime::Unit::absolute, options.number("absolute-time")};
  return {ShockTime::Unit::relative, options.number("time")};
}

ShockRequest shock_request(const OptionValues& options) {
  using Kind = ShockSolverChoice::Kind;
  const std::string solver = options.text("solver");
  return {.time = asked_time(options),
          .smooth = parse_length(options.text("smooth")),
          .smooth_potential = parse_length(options.text("smooth-potential")),
          .solver = {.kind = solver == "direct"      ? Kind::direct
                             : solver == "multigrid" ? Kind::multigrid
                                                     : Kind::automatic,
                     .tolerance = options.number("tolerance")},
          .smooth_normals = parse_length(options.text("smooth-normals")),
          .fit_alpha = options.number("fit-weight"),
          .fit_steps = int(options.integer("fit-steps"))};
}

}  // namespace mq::app

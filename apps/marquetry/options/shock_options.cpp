#include "options/shock_options.h"

#include <string>
#include "mq/linear/direct_solver.h"

namespace mq::app {
namespace {

/// Above so many vertices iterations take less time and memory than a factorisation.
constexpr int most_for_direct = 30'000;

}  // namespace

ShockTime asked_time(const OptionValues& options) {
  if (options.has("absolute-time"))
    return {ShockTime::Unit::absolute, options.number("absolute-time")};
  return {ShockTime::Unit::relative, options.number("time")};
}

ShockWeights asked_weights(const OptionValues& options, const SurfaceScale& scale) {
  const auto weight = [&](const std::string& name) {
    return weight_from_length(parse_length(options.text(name)), scale);
  };
  return {.signal = weight("smooth"), .potential = weight("smooth-potential")};
}

VertexSolver vertex_solver(const OptionValues& options) {
  const std::string name = options.text("solver");
  const double tolerance = options.number("tolerance");
  return [name, tolerance](std::span<const Vector3> places) {
    if (name == "direct" || (name == "automatic" && std::ssize(places) <= most_for_direct))
      return direct_solver();
    MultigridOptions when;
    when.tolerance = tolerance;
    return vertex_multigrid_solver(places, when);
  };
}

double asked_longest_edge(const OptionValues& options, int texels) {
  return options.has("longest-edge") ? options.number("longest-edge") : usual_longest_edge(texels);
}

}  // namespace mq::app

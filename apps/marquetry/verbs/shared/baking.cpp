#include "verbs/shared/baking.h"

#include <fmt/format.h>

#include <algorithm>

#include "mq/base/words.h"
#include "options/signal_options.h"
#include "options/solver_options.h"
#include "shell/results.h"
#include "verbs/shared/seam_report.h"

namespace mq::app {
namespace {

void report_bake(Run& run, const BakedSignal& baked) {
  const bool is_mean = baked.kind == BakedSignal::Kind::mean;
  run.result["unknowns"] = baked.values.rows();
  run.result["channels"] = baked.values.cols();
  run.result["samples"] = baked.samples;
  run.result["points"] = baked.points;
  run.result["on_same_triangles"] = baked.same;
  run.result["unseen"] = baked.unseen;
  run.result["accuracy"] = baked.accuracy;
  run.result["values"] = is_mean ? "means" : "fitted";
  run.solve = solve_json(baked.fit);
  const double unseen =
      100.0 * double(baked.unseen) / double(std::max<Eigen::Index>(1, baked.values.rows()));
  run.print(fmt::format(
      "{} of {}, {} × {} samples for each{}\n", is_mean ? "means" : "the best fit",
      counted(baked.values.rows(), "unknown"), baked.samples, baked.samples,
      baked.unseen == 0 ? ""
                        : fmt::format("; {:.2f} % lie on nothing of the source, and were filled "
                                      "over the surface",
                                      unseen)));
  constexpr double many = 5;
  if (unseen > many)
    run.terminal().warning(fmt::format(
        "{:.1f} % of the target lie on nothing of the source: --within and --angle say how "
        "far off and how turned it may be",
        unseen));
}

}  // namespace

void bake_onto(Run& run, const TexturedModel& source, TexturedModel& target, BakeTo to,
               const BakeOptions& options, double share) {
  std::unique_ptr<ModelSignal> signal;
  about(target.model, [&] {
    const Step step(run, "assemble", 0.3 * share);
    if (to == BakeTo::vertices)
      signal = std::make_unique<VertexColourSignal>(target);
    else
      signal = make_texture_signal(run, target, baking_options(target, options.values), step);
  });
  BakedSignal baked;
  {
    const Step step(run, "bake", 0.7 * share);
    baked = bake(source, target, *signal, options, run.terminal(), step);
  }
  report_bake(run, baked);
  put_baked(baked, *signal, options.values, target);
  if (to == BakeTo::textures)
    run.result["seams"] = {{"source", source.atlas ? seams_json(source) : Json()},
                           {"target", seams_json(target)}};
}

}  // namespace mq::app

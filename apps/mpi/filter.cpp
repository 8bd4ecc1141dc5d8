// mpirun -n N marquetry-mpi filter MESH [TEXTURE...] -o FOLDER/ --strength S: the filter of marquetry, its texels
// parted among processes.
//
// Every process reads the mesh, and of the pictures those in which texels belong to it, one after another. It makes the
// rows of its own texels from its part of the space (fem/texel_part.h), (M + w·S)·δ = w·S_{β−1}·ψ as
// `ScreenedPoisson` states it, for all of β and, where halos are limited, for its part of texture beside it;
// conjugate gradients run over all; what becomes of a picture is gathered where most of its texels are, and written there.
#include <algorithm>
#include <cmath>
#include <optional>

#include "equation.h"
#include "mask.h"
#include "mq/base/release.h"
#include "mq/filter/halo_limit.h"
#include "mq/filter/luminance.h"
#include "options/mask_options.h"
#include "options/model_options.h"
#include "options/signal_options.h"
#include "shell/run.h"
#include "textures.h"
#include "verbs.h"
#include "verbs/shared/filter_strength.h"

namespace mq::shared {
namespace {

using app::Exit;
using app::Run;
using app::Step;

/// What is filtered: a row of `values` and a modulation per unknown of the part's space.
struct Wanted {
  Run& run;
  const Processes& processes;
  const Numbering& numbering;
  TexelPart& part;
  const Signal& values;
  std::vector<double> beta;
  double weight;
};

/// w·S_{β−1}·ψ of the own texels.
Signal change_of_gradients(const Wanted& wanted, const std::vector<double>& beta) {
  Signal B(0, wanted.values.cols());
  wanted.processes.together([&] {
    if (wanted.part.empty()) return;
    std::vector<double> change(beta);
    for (double& b : change) b -= 1;
    B = wanted.weight * own_rows(wanted.part, wanted.part.space().stiffness_times(wanted.values, change));
  });
  return B;
}

bool is_anywhere(const Processes& processes, bool here) { return processes.largest(here ? 1 : 0) > 0; }

/// As the equation has it, halos and all.
Signal filtered(const Wanted& wanted, const std::vector<double>& beta) {
  const Signal B = change_of_gradients(wanted, beta);
  const Signal change =
      SharedEquation(wanted.run, wanted.processes, wanted.numbering, wanted.part, wanted.weight).solve(B);
  return with_own_changes(wanted.part, wanted.values, change);
}

/// What `solve_without_halos` does.
Signal filtered_without_halos(const Wanted& wanted, const HaloOptions& options) {
  const Processes& processes = wanted.processes;
  if (!is_anywhere(processes, sharpens(wanted.beta)))
    return filtered(wanted, wanted.beta);
  std::optional<HaloLimit> limit;
  std::vector<double> all = wanted.beta, texture = wanted.beta;
  const Step step(wanted.run, "look around", 0.1);
  SparseMatrix couplings;
  processes.together([&] {
    if (!wanted.part.empty()) couplings = wanted.part.space().system(0, 1, step.progress().step("couplings", 0.5));
  });
  processes.talking([&] {
    const SharedUnknowns shared = shared_unknowns(processes, wanted.part, wanted.numbering);
    limit.emplace(couplings, wanted.values, options, shared, step.progress().step("ranges", 0.5));
    release(couplings);
    all = limit->of_detail(wanted.beta), texture = limit->of_texture(all);
  });
  if (!is_anywhere(processes, all != texture)) return filtered(wanted, all);
  const int channels = int(wanted.values.cols());
  Signal B(std::ssize(wanted.part.own()), 2 * channels);
  B << change_of_gradients(wanted, all), change_of_gradients(wanted, texture);
  const Signal change =
      SharedEquation(wanted.run, processes, wanted.numbering, wanted.part, wanted.weight).solve(B);
  Signal after = wanted.values;
  for (std::size_t n = 0; n < wanted.part.own().size(); ++n) {
    const int i = wanted.part.own()[n];
    for (int c = 0; c < channels; ++c)
      after(i, c) = limit->sharpened(i, c, wanted.values(i, c), change(Eigen::Index(n), c),
                                     change(Eigen::Index(n), channels + c));
  }
  return after;
}

Exit filter(Run& run) {
  const OptionValues& options = run.options();
  const Processes processes;
  std::optional<Outputs> outputs;
  const TexturedModel scene = read_scene(run, processes, "filter", outputs, app::require_strength);
  processes.together([&] { shared::check_mask(run, scene); });
  if (run.dry_run()) return Exit::done;

  const std::unique_ptr<TexelPart> part = part_of(run, processes, scene);
  const double weight = checked_weight(processes, "filter", scene, [&](const SurfaceScale& scale) {
    return app::asked_weight(options, scale);
  });

  Signal psi = read_values(run, processes, scene, *part);
  HaloOptions halo;
  const double largest = processes.largest(app::largest_value(psi));
  processes.together([&] { halo = app::asked_halos(options, scene.model, largest); });
  const bool luminance_alone = app::by_luminance(options, scene.model);
  Signal Y;
  if (luminance_alone) Y = luminance(psi);
  Signal& worked = luminance_alone ? Y : psi;
  Signal after;
  {
    const std::unique_ptr<Numbering> numbering = numbered(processes, *part, worked);
    const Wanted wanted{run,    processes, *numbering, *part,
                        worked, asked_modulation(run, processes, scene, *part, *numbering), weight};
    after = std::isinf(halo.fraction) ? filtered(wanted, wanted.beta) : filtered_without_halos(wanted, halo);
  }
  if (luminance_alone) after = with_luminance(psi, Y, after);
  report_weight(run, scene, weight);
  run.result["halo"] = app::number_json(halo.fraction);
  run.result["threshold"] = halo.threshold;
  write_result(run, processes, scene, *part, *outputs, psi, after);
  return Exit::done;
}

}  // namespace

app::Verb filter_verb() {
  OptionTable table("filter", "Smooth or sharpen textures on the surface, across their seams, by several processes.");
  describe_program(table);
  table.example("castle.obj --strength -100% --radius 8tx -o out/", "smooth all tiles of a castle");
  app::add_model_options(table);
  app::add_output_option(table);
  app::add_strength_options(table);
  app::add_luminance_option(table);
  app::add_halo_option(table, "Filter");
  app::add_threshold_option(table);
  app::add_mask_options(table, "Filter");
  app::add_spread_options(table, {1e-3, Length::Unit::alpha}, "Filter",
                          "how far it reaches: weight of gradients on the surface scaled to unit area");
  table.exclusive({"strength", "beta"});
  table.exclusive({"radius", "alpha", "length"});
  table.exclusive({"strength", "alpha"});
  add_shared_solver_options(table, "multigrid", {"bddc"});
  app::add_space_option(table);
  app::add_depth_option(table);
  for (const char* name : {"field", "geometry", "normals", "normal-space", "vertices", "frames", "by-curvature",
                           "smooth-normals", "fit-weight", "fit-steps", "compress"})
    table.elsewhere(name, not_yet("filter"));
  return {table, filter};
}

}  // namespace mq::shared

// mpirun -n N marquetry-mpi filter MESH [TEXTURE...] -o FOLDER/ --strength S: the filter of marquetry, its texels
// parted among processes.
//
// Every process reads the mesh, and of the pictures those in which texels belong to it, one after another. It makes the
// rows of its own texels from its part of the space (fem/texel_part.h), (M + w·S)·δ = w·(β − 1)·S·ψ as
// `ScreenedPoisson` states it; conjugate gradients run over all; what becomes of a picture is gathered where most of
// its texels are, and written there.
#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "equation.h"
#include "mq/base/error.h"
#include "mq/filter/luminance.h"
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

void require_known(const OptionValues& options) {
  app::require_strength(options);
  require(app::asked_beta(options) <= 1 || (options.has("halo") && std::isinf(options.number("halo"))),
          "--halo: sharpening that limits halos is not shared among processes yet: give --halo inf (edges get "
          "fringes), smooth (--strength below 0), or use marquetry filter on one machine");
}

/// w·(β − 1)·S·ψ of the own texels.
Signal right_hand_side(const Processes& processes, const TexelPart& part, double factor, const Signal& psi) {
  Signal B(0, psi.cols());
  processes.together([&] {
    if (part.empty()) return;
    B = part.space().stiffness_rows(part.own(), psi);
    B *= factor;
  });
  return B;
}

Exit filter(Run& run) {
  const Processes processes;
  std::optional<Outputs> outputs;
  const TexturedModel scene = read_scene(run, processes, "filter", outputs, require_known);
  if (run.dry_run()) return Exit::done;

  const std::unique_ptr<TexelPart> part = part_of(run, processes, scene);
  const double weight = checked_weight(processes, "filter", scene, [&](const SurfaceScale& scale) {
    return app::asked_weight(run.options(), scale);
  });

  Signal psi = read_values(run, processes, scene, *part);
  const bool luminance_alone = app::by_luminance(run.options(), scene.model);
  Signal Y;
  if (luminance_alone) Y = luminance(psi);
  Signal& worked = luminance_alone ? Y : psi;
  Signal change;
  {
    const std::unique_ptr<Numbering> numbering = numbered(processes, *part, worked);
    const Signal B = right_hand_side(processes, *part, weight * (app::asked_beta(run.options()) - 1), worked);
    change = SharedEquation(run, processes, *numbering, *part, weight).solve(B);
  }
  Signal after = worked;
  for (std::size_t n = 0; n < part->own().size(); ++n) after.row(part->own()[n]) += change.row(Eigen::Index(n));
  if (luminance_alone) after = with_luminance(psi, Y, after);
  report_weight(run, scene, weight);
  write_result(run, processes, scene, *part, *outputs, psi, after);
  return Exit::done;
}

}  // namespace

app::Verb filter_verb() {
  OptionTable table("filter", "Smooth or sharpen textures on the surface, across their seams, by several processes.");
  table.of_program("marquetry-mpi");
  table.example("castle.obj --strength -100% --radius 8tx -o out/", "smooth all tiles of a castle");
  app::add_model_options(table);
  app::add_output_option(table);
  app::add_strength_options(table);
  app::add_luminance_option(table);
  app::add_halo_option(table, "Filter");
  app::add_spread_options(table, {1e-3, Length::Unit::alpha}, "Filter",
                          "how far it reaches: weight of gradients on the surface scaled to unit area");
  table.exclusive({"strength", "beta"});
  table.exclusive({"radius", "alpha", "length"});
  table.exclusive({"strength", "alpha"});
  add_shared_solver_options(table);
  app::add_space_option(table);
  app::add_depth_option(table);
  for (const char* name : {"mask", "spot", "field", "geometry", "normals", "normal-space", "vertices", "frames",
                           "threshold", "by-curvature", "smooth-normals", "fit-weight", "fit-steps", "compress"})
    table.elsewhere(name, not_yet("filter"));
  return {table, filter};
}

}  // namespace mq::shared

// mpirun -n N marquetry-mpi denoise MESH [TEXTURE...] -o FOLDER/: smoothing up to edges, the texels parted among processes.
//
//     (M + w Σ c_e S_e)·δ = −w Σ c_e S_e·ψ,    c_e = 1 / (1 + (h̄ |∇φ|_e / edge)²),  φ as the step before left it
//
// as `denoise` states it. An element lies in every part that has a texel of it; the edge is measured in those of which a
// process owns the first texel, so that each counts once.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>

#include "equation.h"
#include "mq/base/release.h"
#include "mq/filter/denoise.h"
#include "mq/linear/conjugate_gradients.h"
#include "options/model_options.h"
#include "options/signal_options.h"
#include "shell/run.h"
#include "textures.h"
#include "verbs.h"
#include "verbs/shared/denoise_options.h"

namespace mq::shared {
namespace {

using app::Exit;
using app::Run;
using app::Step;

/// What all steps work on.
struct Noisy {
  Run& run;
  const Processes& processes;
  const Numbering& numbering;
  TexelPart& part;
  double spacing;
  const Signal& psi;
};

/// ψ with the changes of the own rows, the halo filled.
Signal changed(const Noisy& noisy, const Signal& change) {
  Signal result = with_own_changes(noisy.part, noisy.psi, change);
  noisy.processes.talking([&] { noisy.numbering.fill_halo(result); });
  return result;
}

/// The first step of `denoise`, by the same iterations.
Signal slightly_smoothed(const Noisy& noisy, double weight) {
  const Step step(noisy.run, "look for edges", 0.1);
  const double first = denoising::first_weight(weight, noisy.spacing);
  SparseMatrix A;
  Signal B(0, noisy.psi.cols());
  Vector diagonal(0);
  noisy.processes.together([&] {
    if (noisy.part.empty()) return;
    A = noisy.part.space().regularised_system(1, first, step);
    B = noisy.part.space().stiffness_rows(noisy.part.own(), noisy.psi);
    B *= -first;
    const Vector all = A.diagonal();
    diagonal = all(noisy.part.own());
  });
  Signal change = Signal::Zero(B.rows(), B.cols());
  noisy.processes.talking([&] {
    const SharedMatrix matrix(A, noisy.processes, noisy.part, noisy.numbering);
    release(A);
    if (noisy.processes.largest(B.size() > 0 ? B.cwiseAbs().maxCoeff() : 0) == 0) return;
    conjugate_gradients(
        shared_system(matrix, noisy.processes), B, change,
        [&](const Signal& R, Signal& Z) { Z = R.array().colwise() / diagonal.array(); }, denoising::first_stop());
  });
  return changed(noisy, change);
}

/// The norm of the gradient of every own element that holds some of the surface.
std::vector<float> own_gradients(const TexelPart& part, const Signal& smoothed) {
  const std::vector<int> first = part.space().first_texels();
  const int self = part.owner()[std::size_t(part.own().front())];
  std::vector<char> own(first.size(), 0);
  for (std::size_t e = 0; e < first.size(); ++e) own[e] = first[e] >= 0 && part.owner()[std::size_t(first[e])] == self;
  return denoising::surface_gradients(part.space(), smoothed, own);
}

/// The value of this rank, from 0, among those of all processes, none below 0: by halves, as bits of such numbers are in
/// their order.
float of_rank(const Processes& processes, const std::vector<float>& values, double rank) {
  std::uint32_t bits = 0;
  for (std::uint32_t bit = 1U << 30; bit != 0; bit >>= 1) {
    const std::uint32_t next = bits | bit;
    double below = 0;
    for (const float value : values) below += std::bit_cast<std::uint32_t>(value) < next;
    processes.sum({&below, 1});
    if (below <= rank) bits = next;
  }
  return std::bit_cast<float>(bits);
}

/// `measured_edge` of all processes.
double shared_edge(const Noisy& noisy, const Signal& smoothed) {
  std::vector<float> norms;
  noisy.processes.together([&] {
    if (!noisy.part.empty()) norms = own_gradients(noisy.part, smoothed);
  });
  double count = double(norms.size());
  noisy.processes.sum({&count, 1});
  if (count == 0) return 0;
  const double largest = noisy.processes.largest(norms.empty() ? 0 : double(*std::ranges::max_element(norms)));
  const float quartile = of_rank(noisy.processes, norms, std::floor(count / 4));
  return denoising::edge_from(quartile, float(largest), noisy.spacing);
}

/// What becomes of the part's space.
enum class Space { kept, let_go };

/// One step: the change of the own rows with the edges of φ.
Signal smoothed_up_to_edges(const Noisy& noisy, const Signal& phi, double weight, double edge, Space after) {
  std::vector<float> conductivity;
  Signal B(0, noisy.psi.cols());
  noisy.processes.together([&] {
    if (noisy.part.empty()) return;
    const TexelSpace& space = noisy.part.space();
    conductivity.assign(std::size_t(space.element_count()), 1.0F);
    if (std::isfinite(edge))
      denoising::stop_at_edges(space.gradient_norms(phi), noisy.spacing, edge, conductivity);
    B = -weight * own_rows(noisy.part, space.weighted_stiffness_times(noisy.psi, conductivity));
  });
  SharedEquation equation(noisy.run, noisy.processes, noisy.numbering, noisy.part,
                          [&](const TexelSpace& space, const Progress& progress) {
                            SparseMatrix A = space.weighted_system(1, weight, conductivity, progress);
                            conductivity = {};
                            if (after == Space::let_go) noisy.part.let_go_of_space();
                            return A;
                          });
  return equation.solve(B);
}

/// The change of all own rows.
Signal noise_taken_off(const Noisy& noisy, const DenoiseOptions& wanted) {
  const bool own_edges = !wanted.edge || std::isfinite(*wanted.edge);
  Signal phi = own_edges ? slightly_smoothed(noisy, wanted.weight) : noisy.psi;
  const double edge = wanted.edge ? *wanted.edge : std::max(1.0, wanted.strength) * shared_edge(noisy, phi);
  app::say_edge(noisy.run, wanted, edge);
  Signal change = Signal::Zero(std::ssize(noisy.part.own()), noisy.psi.cols());
  if (edge == 0) return change;
  const int steps = own_edges ? wanted.steps : 1;
  for (int k = 0; k < steps; ++k) {
    change = smoothed_up_to_edges(noisy, phi, wanted.weight, edge, k + 1 == steps ? Space::let_go : Space::kept);
    if (k + 1 < steps) phi = changed(noisy, change);
  }
  if (wanted.strength < 1) change *= wanted.strength;
  return change;
}

Exit denoise(Run& run) {
  const Processes processes;
  std::optional<Outputs> outputs;
  const TexturedModel scene = read_scene(run, processes, "denoise", outputs, [](const OptionValues&) {});
  if (run.dry_run()) return Exit::done;

  const std::unique_ptr<TexelPart> part = part_of(run, processes, scene);
  Signal psi = read_values(run, processes, scene, *part);
  const std::unique_ptr<Numbering> numbering = numbered(processes, *part, psi);
  double spacing = 0;
  DenoiseOptions wanted;
  checked_weight(processes, "denoise", scene, [&](const SurfaceScale& scale) {
    spacing = denoising::spacing(scale, numbering->total());
    wanted = app::asked_edges(run.options(), scale, spacing);
    return wanted.weight;
  });
  const Signal change = noise_taken_off({run, processes, *numbering, *part, spacing, psi}, wanted);
  const Signal after = with_own_changes(*part, psi, change);
  run.result["method"] = "edges";
  write_result(run, processes, scene, *part, *outputs, psi, after);
  return Exit::done;
}

}  // namespace

app::Verb denoise_verb() {
  OptionTable table("denoise", "Take noise off textures by smoothing that stops at edges, by several processes.");
  describe_program(table);
  table.example("castle.obj -o out/", "noise off all tiles of a castle");
  app::add_model_options(table);
  app::add_output_option(table);
  app::add_noise_strength_option(table);
  app::add_spread_options(table, usual_denoise_length, "Smoothing up to edges",
                          "how far values spread where no edge is: on the surface scaled to unit area");
  app::add_edge_option(table);
  app::add_steps_option(table);
  add_shared_solver_options(table);
  app::add_space_option(table);
  app::add_depth_option(table);
  table.exclusive({"strength", "edge"});
  table.elsewhere("method", "marquetry-mpi smooths up to edges, as marquetry denoise --method edges does; that one has "
                            "patches too, on one machine");
  for (const char* name : {"guide", "guide-edge", "normals", "normal-space", "vertices", "frames", "compress"})
    table.elsewhere(name, not_yet("denoise"));
  return {table, denoise};
}

}  // namespace mq::shared

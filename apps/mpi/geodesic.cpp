// mpirun -n N marquetry-mpi geodesic MESH [TEXTURE...] -o FOLDER/ --from PLACE: distances along the surface, the texels
// parted among processes.
//
// The steps are those of `GeodesicDistance` (filter/geodesic_steps.h): fronts, heat and what is continued to boundaries
// are swept by each process in its own texels, with a halo that is exchanged; S·φ = b has the screen that
// `ScreenedPoisson` gives it; the constant of a component is summed up over all processes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "components.h"
#include "equation.h"
#include "geodesic_sources.h"
#include "mq/base/error.h"
#include "mq/fem/field_metric.h"
#include "mq/filter/geodesic_steps.h"
#include "mq/filter/vanishing_screen.h"
#include "options/model_options.h"
#include "options/signal_options.h"
#include "shell/run.h"
#include "textures.h"
#include "verbs.h"
#include "verbs/shared/distance_options.h"
#include "verbs/shared/input_pictures.h"

namespace mq::shared {
namespace {

using app::Exit;
using app::Run;
using app::Step;

/// What is left once the heat has spread: rows are the process's own texels.
struct Prepared {
  Signal w, b;                          ///< a first guess of distances, and b − S·w
  Vector screen;                        ///< what the diagonal of S gets
  std::vector<GeodesicSource> sources;  ///< by row
  std::vector<int> component;
  std::optional<SharedComponents> components;
  ShownPlaces shown;
};

void require_known(const OptionValues& options) {
  require(!options.texts("from").empty() || !options.texts("from-mask").empty(),
          "--from: say where distances begin: --from x,y,z, --from texel,column,row or --from-mask PICTURE");
  require(options.text("solver") != "multigrid",
          "--solver multigrid: does not solve for distances yet, as constants are nearly free there: leave it out, or "
          "give boomeramg or gamg");
  require(!options.flag("vertices"), "--vertices: " + not_yet("geodesic"));
}

/// Those of the halo as their owners have them.
std::vector<Vector3> positions_of(const TexelPart& part, const Numbering& numbering) {
  Signal values(Eigen::Index(part.places().size()), 3);
  std::vector<Vector3> positions;
  if (!part.empty()) positions = part.space().positions();
  for (std::size_t i = 0; i < positions.size(); ++i) values.row(Eigen::Index(i)) = positions[i].transpose();
  numbering.fill_halo(values);
  for (std::size_t i = 0; i < positions.size(); ++i) positions[i] = values.row(Eigen::Index(i)).transpose();
  return positions;
}

/// How many times the screen of one process S gets here, so that preconditioners have more of constants than rounding.
/// Of what is solved for, some per cent of distances, it changes an eigenfunction of eigenvalue λ by 10⁻⁵/(λ · area).
constexpr double screen_factor = 1e3;

/// Per own row what makes S definite, of which M + t·S and M, lumped, are given.
Vector vanishing(const TexelPart& part, const SharedComponents& components, const SparseMatrix& heat,
                 const Vector& mass, double t) {
  Signal here = Signal::Zero(components.count(), 2);
  const Vector diagonal = heat.diagonal();
  for (const int i : part.own()) {
    const int c = components.component()[std::size_t(i)];
    here(c, 0) += mass[i];
    here(c, 1) += (diagonal[i] - mass[i]) / t;
  }
  const Signal all = components.sums(here);
  Vector screen(std::ssize(part.own()));
  for (std::size_t n = 0; n < part.own().size(); ++n) {
    const int i = part.own()[n], c = components.component()[std::size_t(i)];
    screen[Eigen::Index(n)] = screen_factor * vanishing_screen(mass[i] / all(c, 0), all(c, 1));
  }
  return screen;
}

/// Everything up to the Poisson equation.
Prepared spread_heat(Run& run, const SourceSpace& space, const SharedSources& sources) {
  const TexelPart& part = space.part;
  const double spacing = space.atlas.texel_spacing();
  const GeodesicOptions options{.time = run.options().number("time")};
  Prepared found;
  SparseMatrix heat;
  Vector mass;
  std::vector<int> boundary;
  const Step step(run, "spread heat", 0.3);
  space.processes.together([&] {
    if (part.empty()) return;
    heat = part.space().regularised_system(0, 1, step.progress().step("assemble", 0.3));
    mass = part.space().lumped_mass();
    boundary = part.boundary();
    found.shown = part.shown();
  });
  found.components.emplace(space.processes, part, space.numbering, heat);
  space.processes.talking([&] {
    const std::vector<Vector3> positions = positions_of(part, space.numbering);
    const SharedUnknowns shared = shared_unknowns(space.processes, part, space.numbering);
    const double length = std::sqrt(options.time) * heat_spacing(spacing, heat, mass, shared);
    make_heat_matrix(mass, length * length, heat);
    found.screen = vanishing(part, *found.components, heat, mass, length * length);
    found.sources = app::by_texture(run.options()) ? sources_here(space, sources)
                                                   : grown_here(space, sources, heat, positions);
    const HeatDistances spread =
        heat_distances({length, spacing, heat, positions, boundary}, found.sources, options,
                       step.progress().step("sweeps", 0.6), shared);
    run.result["sources"] = sources.count;
    run.result["diffusion_length"] = length;
    run.result["sweeps"] = spread.sweeps;
    run.result["missed"] = spread.change;
    if (spread.change > 0.01)
      run.terminal().warning(fmt::format("the spread of heat still misses its equation by {:.1g} after {} sweeps: "
                                         "distances may be wrong; --time 16 helps where charts are much stretched",
                                         spread.change, spread.sweeps));
    found.w = own_rows(part, spread.w);
    found.b = Signal(std::ssize(part.own()), 1);
    if (!part.empty())
      found.b = own_rows(part, unit_gradient_moments(part.space(), spread.w)) -
                part.space().stiffness_rows(part.own(), spread.w);
  });
  for (const int i : part.own()) found.component.push_back(found.components->component()[std::size_t(i)]);
  for (GeodesicSource& source : found.sources)
    source.unknown = int(std::ranges::lower_bound(part.own(), source.unknown) - part.own().begin());
  return found;
}

/// φ of the own texels: w and what the Poisson equation adds, its constants as sources have them.
Vector solve(Run& run, const SourceSpace& space, TexelPart& part, const Prepared& prepared) {
  SharedEquation equation(run, space.processes, space.numbering, part,
                          [&](const TexelSpace& texels, const Progress& progress) {
                            SparseMatrix S = texels.regularised_system(0, 1, progress);
                            for (std::size_t n = 0; n < part.own().size(); ++n)
                              S.coeffRef(part.own()[n], part.own()[n]) += prepared.screen[Eigen::Index(n)];
                            part.let_go_of_space();
                            return S;
                          });
  Vector distance = (prepared.w + equation.solve(prepared.b)).col(0);
  double unreached = 0;
  space.processes.talking([&] {
    const Signal here =
        missed_at_sources(prepared.sources, prepared.component, prepared.components->count(), distance);
    unreached = meet_sources(prepared.sources, prepared.component, prepared.components->sums(here), distance);
    space.processes.sum({&unreached, 1});
  });
  run.result["unreached"] = std::int64_t(unreached);
  if (unreached > 0)
    run.terminal().remark(fmt::format("{} of {} unknowns are on parts of the surface without a source: -1 as numbers, "
                                      "grey as colours",
                                      std::int64_t(unreached), space.numbering.total()));
  return distance;
}

/// The largest that the surface shows, of all processes.
double largest_shown(const SourceSpace& space, const ShownPlaces& shown, const Vector& distance) {
  Vector all = Vector::Zero(Eigen::Index(space.part.places().size()));
  for (std::size_t n = 0; n < space.part.own().size(); ++n) all[space.part.own()[n]] = distance[Eigen::Index(n)];
  double most = 0;
  space.processes.talking([&] {
    space.numbering.fill_halo({all.data(), std::size_t(all.size())}, 1);
    most = space.processes.largest(shown.largest(all));
  });
  return most;
}

void write(Run& run, const SourceSpace& space, const Outputs& outputs, const Signal& values, Depth depth) {
  const int channels = int(values.cols());
  write_new_pictures(run, space.processes, space.scene, space.part, outputs, channels, depth, [&](int texture) {
    TexelValues texels;
    std::vector<int> rows;
    for (int n = 0; n < int(space.part.own().size()); ++n) {
      if (space.part.places()[std::size_t(space.part.own()[std::size_t(n)])].texture != texture) continue;
      if (!space.copies.is_shown(n)) continue;
      rows.push_back(n);
      texels.places.push_back(space.copies.home(n));
    }
    texels.values.resize(std::ssize(rows), channels);
    for (std::size_t k = 0; k < rows.size(); ++k) texels.values.row(Eigen::Index(k)) = values.row(rows[k]);
    return texels;
  });
}

Exit geodesic(Run& run) {
  const Processes processes;
  const OptionValues& options = run.options();
  std::optional<Outputs> outputs;
  const TexturedModel scene = read_scene(run, processes, "geodesic", outputs, require_known);
  std::vector<app::SourcePlace> places;
  std::optional<SeparatedAtlas> apart;
  TexelSpaceOptions how;
  processes.together([&] {
    app::check_pictures(options, scene,
                        {"from-mask", app::InputPictures::Count::one_set, app::InputPictures::Size::of_the_texture});
    places = app::source_places(run, scene);
    if (run.dry_run()) return;
    const Step step(run, "lay charts apart", 0.05);
    apart = separate_overlaps(scene.surface, *scene.atlas, step);
    if (app::by_texture(options)) how.metrics = texel_metrics_of_plane(*scene.atlas);
  });
  if (run.dry_run()) return Exit::done;

  const Atlas& atlas = apart ? apart->atlas : *scene.atlas;
  const std::unique_ptr<TexelPart> part = part_of(run, processes, scene, atlas, how);
  std::optional<Numbering> numbering;
  processes.talking([&] { numbering.emplace(processes, *part); });
  const SharedCopies copies(processes, scene.surface, apart, *part);
  if (copies.shared_texels() > 0)
    run.terminal().warning(fmt::format("{} texels that stand for several places of the surface: the picture shows one "
                                       "of them",
                                       copies.shared_texels()));
  const SourceSpace space{processes, scene, atlas, *part, *numbering, copies};
  Prepared prepared = spread_heat(run, space, shared_sources(run, space, places));
  const Vector distance = solve(run, space, *part, prepared);
  const double most = largest_shown(space, prepared.shown, distance);
  run.result["max"] = most;
  run.print(fmt::format("largest distance: {:g}\n", most));
  if (app::writes_numbers(options, outputs->paths().front()))
    write(run, space, *outputs, app::distances_as_numbers(distance, 1), Depth::f32);
  else
    write(run, space, *outputs, app::distances_as_colours(options, distance, most, atlas.texel_spacing()), Depth::u8);
  return Exit::done;
}

}  // namespace

app::Verb geodesic_verb() {
  OptionTable table("geodesic",
                    "Measure distances along the surface, across the seams of the texture, from one place or many, by "
                    "several processes.");
  describe_program(table);
  table.example("castle.obj --from 0,0.3,1 -o out/", "distances from the point of the surface nearest to there");
  app::add_model_options(table);
  app::add_output_option(table);
  app::add_source_options(table);
  app::add_distance_options(table);
  add_shared_solver_options(table, "boomeramg");
  app::add_vertices_option(table, "distances at vertices: refused, as marquetry geodesic measures them on one machine");
  for (const char* name : {"frames", "shard", "compress"}) table.elsewhere(name, not_yet("geodesic"));
  return {table, geodesic};
}

}  // namespace mq::shared

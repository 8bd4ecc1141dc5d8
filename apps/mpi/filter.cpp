// mpirun -n N marquetry-mpi filter MESH [TEXTURE...] -o FOLDER/ --strength S: the filter of marquetry, its texels
// parted among processes.
//
// Every process reads the mesh, and of the pictures those in which texels belong to it, one after another. It makes the
// rows of its own texels from its part of the space (fem/texel_part.h); conjugate gradients run over all; what
// becomes of a picture is gathered where most of its texels are, and written there.
#include "filter.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "mq/base/error.h"
#include "mq/base/infinity.h"
#include "mq/filter/luminance.h"
#include "mq/io/image_file.h"
#include "mq/io/slots.h"
#include "mq/model/outputs.h"
#include "mq/model/part_values.h"
#include "options/model_options.h"
#include "options/signal_options.h"
#include "options/solver_options.h"
#include "preconditioners.h"
#include "shell/arguments.h"
#include "shell/results.h"
#include "shell/run.h"
#include "verbs/shared/filter_strength.h"

namespace mq::shared {
namespace {

using app::Exit;
using app::Json;
using app::Run;
using app::Step;

constexpr const char* not_yet = "marquetry-mpi does not do that yet: marquetry filter does, on one machine";

/// Up to this weight, in areas, constants are as well determined as all else (see `ScreenedPoisson`).
constexpr double largest_weight = 0.01;

constexpr int usual_cycles = 200;

/// Finer than that of one process, so that pictures of any number of processes differ by less than 1e-6.
constexpr double usual_tolerance = 1e-7;

Solver asked_solver(const OptionValues& options) {
  const std::string name = options.text("solver");
  return name == "boomeramg" ? Solver::boomeramg : name == "gamg" ? Solver::gamg : Solver::multigrid;
}

void require_known(const OptionValues& options) {
  app::require_strength(options);
  require(app::asked_beta(options) <= 1 || (options.has("halo") && std::isinf(options.number("halo"))),
          "--halo: sharpening that limits halos is not shared among processes yet: give --halo inf (edges get "
          "fringes), smooth (--strength below 0), or use marquetry filter on one machine");
}

/// The model without its pictures, and where the changed ones go.
TexturedModel read_scene(Run& run, const Processes& processes, std::optional<Outputs>& outputs) {
  TexturedModel scene;
  processes.together([&] {
    require_known(run.options());
    scene = app::read_usable_model(run, MissingPictures::by_head, 0.05);
    const std::string file = scene.model.path.string();
    require(!scene.is_picture, file + ": is a picture; marquetry filter takes it, on one machine");
    require(scene.atlas.has_value(), file + ": has no texture coordinates, so no textures to filter; marquetry filter "
                                            "takes colours at vertices, on one machine");
    require(meaning_of_slot(scene.model.slot) != TextureMeaning::normals,
            fmt::format("{}: its pictures for {} are normals: {}", file, scene.model.slot, not_yet));
    outputs.emplace(run.options().text("output"), scene.model, Outputs::Kind::pictures);
    require(!outputs->is_model(),
            "--output: pictures are written, each by a process of its own: name a folder, such as out/, or with one "
            "texture a picture");
  });
  processes.in_turns([&] { run.will_write(outputs->paths(), outputs->folders()); });
  return scene;
}

Texture read_picture_of(const Run& run, const Texture& texture, const Progress& progress) {
  const OptionValues& options = run.options();
  const std::string layer = options.has("layer") ? options.text("layer") : "";
  Texture picture = read_texture(texture.path, progress, NotFinite::keep, layer);
  picture.meaning = texture.meaning;
  picture.name = texture.name;
  return picture;
}

/// The values of the part's own texels, a row per unknown of its space; no picture is kept.
Signal read_values(Run& run, const Processes& processes, const TexturedModel& scene, const TexelPart& part) {
  const Step step(run, "read pictures", 0.15);
  const std::vector<Texture>& textures = scene.model.textures;
  int channels = 0;
  processes.together([&] {
    for (const Texture& texture : textures)
      channels = std::max(channels, int(picture_info(texture.path).channels.size()));
  });
  Signal values = Signal::Zero(Eigen::Index(part.places().size()), channels);
  processes.together([&] {
    for (std::size_t i = 0; i < textures.size(); ++i) {
      if (!part.has_texture(int(i))) continue;
      const Texture picture =
          read_picture_of(run, textures[i], step.progress().step(textures[i].name, 1 / double(textures.size())));
      take_values(part, int(i), scene.texture_sizes[i], picture, app::value_space(run.options()), values);
    }
  });
  return values;
}

/// The largest resident set this process had.
std::int64_t peak_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return std::int64_t(usage.ru_maxrss) * 1024;
}

/// Own rows of a signal that has a row per unknown of the part's space.
Signal own_rows(const TexelPart& part, const Signal& all) {
  Signal own(std::ssize(part.own()), all.cols());
  for (std::size_t n = 0; n < part.own().size(); ++n) own.row(Eigen::Index(n)) = all.row(part.own()[n]);
  return own;
}

/// The system of the whole model: (M + w·S)·δ = w·(β − 1)·S·ψ, as `ScreenedPoisson` states it.
struct System {
  std::unique_ptr<Numbering> numbering;
  std::unique_ptr<SharedMatrix> matrix;
  Texels texels;
  Signal B;
};

System make_system(Run& run, const Processes& processes, TexelPart& part, double weight, Signal& psi) {
  const Step step(run, "assemble", 0.2);
  System system;
  processes.talking([&] {
    system.numbering = std::make_unique<Numbering>(processes, part);
    system.numbering->fill_halo(psi);
  });
  SparseMatrix A;
  processes.together([&] {
    const double beta = app::asked_beta(run.options());
    if (part.empty()) {
      system.B.resize(0, psi.cols());
      return;
    }
    system.B = part.space().stiffness_rows(part.own(), psi);
    system.B *= (beta - 1) * weight;
    A = part.space().regularised_system(1, weight, step);
    system.texels = part.space().texels();
    part.let_go_of_space();
  });
  processes.talking([&] { system.matrix = std::make_unique<SharedMatrix>(A, processes, part, *system.numbering); });
  return system;
}

/// δ of the own texels. Lets go of where they lie once that has been used.
Signal solve(Run& run, const Processes& processes, System& system, const TexelPart& part) {
  Signal X = Signal::Zero(system.B.rows(), system.B.cols());
  const double largest = processes.largest(system.B.size() > 0 ? system.B.cwiseAbs().maxCoeff() : 0);
  if (largest == 0) {
    run.solve = app::solve_json(nothing_to_solve());
    return X;
  }
  const StoppingRule stop = app::stopping_rule(run.options());
  SolveReport report;
  std::unique_ptr<SharedPreconditioner> preconditioner;
  {
    const Step step(run, "prepare", 0.2);
    processes.talking([&] {
      preconditioner = make_preconditioner(asked_solver(run.options()), processes, *system.matrix, *system.numbering,
                                           part, system.texels);
    });
    system.texels = {};
  }
  const Step step(run, "solve", 0.3);
  processes.talking([&] {
    const SharedSystem shared{
        .multiply = [&](const Signal& of, Signal& product) { system.matrix->multiply(of, product); },
        .sum = [&](std::span<double> values) { processes.sum(values); },
        .largest = [&](std::span<double> values) { processes.largest(values); }};
    report = conjugate_gradients(shared, system.B, X,
                                 [&](const Signal& R, Signal& Z) { preconditioner->apply(R, Z); },
                                 {.tolerance = stop.tolerance,
                                  .max_cycles = stop.max_cycles.value_or(usual_cycles),
                                  .stop = ConjugateGradientOptions::Stop::residual_error});
  });
  report.method = preconditioner->name();
  run.solve = app::solve_json(report);
  if (!report.converged) run.terminal().warning(reached(report));
  return X;
}

/// A texel that changed, as it is sent to the process that writes its picture.
struct SentTexel {
  int texture, x, y;
};

/// Per texture the process that writes it: with most texels of it.
std::vector<int> writers(const Processes& processes, const TexelPart& part, std::size_t textures) {
  const auto count = std::size_t(processes.count());
  std::vector<double> texels(textures * count, 0);
  for (const int i : part.own())
    texels[std::size_t(part.places()[std::size_t(i)].texture) * count + std::size_t(processes.rank())] += 1;
  processes.sum(texels);
  std::vector<int> writer;
  for (std::size_t k = 0; k < textures; ++k) {
    const auto first = texels.begin() + std::ptrdiff_t(k * count);
    const auto most = std::max_element(first, first + std::ptrdiff_t(count));
    writer.push_back(int(most - first));
  }
  return writer;
}

/// What is to be put into each picture that this process writes.
std::vector<TexelValues> gather_changes(const Processes& processes, const TexelPart& part,
                                        const std::vector<int>& writer, const Signal& before, const Signal& after) {
  const auto count = std::size_t(processes.count());
  const auto channels = std::size_t(after.cols());
  std::vector<std::vector<SentTexel>> texels(count);
  std::vector<std::vector<float>> values(count);
  for (std::size_t k = 0; k < writer.size(); ++k) {
    const TexelValues changed = changed_values(part, int(k), before, after);
    for (std::size_t n = 0; n < changed.places.size(); ++n) {
      const Texels::Place& at = changed.places[n];
      texels[std::size_t(writer[k])].push_back({int(k), at.x, at.y});
      for (std::size_t c = 0; c < channels; ++c)
        values[std::size_t(writer[k])].push_back(float(changed.values(Eigen::Index(n), Eigen::Index(c))));
    }
  }
  const auto from = processes.exchange(texels);
  const auto their_values = processes.exchange(values);
  std::vector<TexelValues> all(writer.size());
  std::vector<Eigen::Index> rows(writer.size(), 0);
  for (const auto& part_of : from)
    for (const SentTexel& texel : part_of) ++rows[std::size_t(texel.texture)];
  for (std::size_t k = 0; k < all.size(); ++k) all[k].values.resize(rows[k], Eigen::Index(channels));
  for (std::size_t p = 0; p < count; ++p)
    for (std::size_t n = 0; n < from[p].size(); ++n) {
      TexelValues& to = all[std::size_t(from[p][n].texture)];
      const auto row = Eigen::Index(to.places.size());
      to.places.push_back({from[p][n].texture, from[p][n].x, from[p][n].y});
      for (std::size_t c = 0; c < channels; ++c)
        to.values(row, Eigen::Index(c)) = double(their_values[p][n * channels + c]);
    }
  return all;
}

void write_pictures(Run& run, const Processes& processes, const TexturedModel& scene, const TexelPart& part,
                    const Outputs& outputs, const Signal& before, const Signal& after) {
  const Step step(run, "write", 0.1);
  const std::vector<Texture>& textures = scene.model.textures;
  const std::vector<int> writer = writers(processes, part, textures.size());
  std::vector<TexelValues> changes;
  processes.talking([&] { changes = gather_changes(processes, part, writer, before, after); });
  std::string notes;
  processes.together([&] {
    for (std::size_t i = 0; i < textures.size(); ++i) {
      if (writer[i] != processes.rank()) continue;
      Texture picture = read_picture_of(run, textures[i], {});
      put_values(changes[i], app::value_space(run.options()), picture);
      changes[i] = {};
      if (const auto depth = app::asked_depth(run.options())) picture.format.depth = *depth;
      for (const std::string& note : write_texture(outputs.paths()[i], picture)) notes += note + "\n";
      step.progress().at(double(i + 1) / double(textures.size()));
    }
  });
  for (const std::string& of_one : processes.gather(notes))
    for (std::size_t at = 0, end; (end = of_one.find('\n', at)) != std::string::npos; at = end + 1)
      run.terminal().remark(of_one.substr(at, end - at));
  app::say_written(run, outputs.paths());
}

/// What `marquetry filter` reports of the change, of all processes.
void report_change(Run& run, const Processes& processes, const Signal& before, const Signal& after, double weight,
                   double area) {
  const Json own = app::change_json(before, after, app::value_space(run.options()).space);
  const double values = double(before.size());
  double sums[] = {double(before.rows()), values, std::pow(own["rms_change"].get<double>(), 2) * values,
                   own["below_0"].get<double>(), own["above_1"].get<double>()};
  processes.sum(sums);
  const double count = std::max(1.0, sums[1]);
  run.result["unknowns"] = std::int64_t(sums[0]);
  run.result["channels"] = before.cols();
  run.result["rms_change"] = std::sqrt(sums[2] / count);
  run.result["largest_change"] = processes.largest(own["largest_change"].get<double>());
  run.result["below_0"] = std::int64_t(sums[3]);
  run.result["above_1"] = std::int64_t(sums[4]);
  run.result["beyond_percent"] = 100 * (sums[3] + sums[4]) / count;
  run.result["alpha"] = app::number_json(weight / area);
  run.result["length"] = app::number_json(std::sqrt(weight));
}

/// Of each process what it had to do with.
void report_processes(Run& run, const Processes& processes, const TexturedModel& scene, const TexelPart& part) {
  int pictures = 0;
  for (std::size_t i = 0; i < scene.model.textures.size(); ++i) pictures += part.has_texture(int(i));
  const Json own{{"texels", part.own().size()},
                 {"halo", part.places().size() - part.own().size()},
                 {"pictures", pictures},
                 {"peak_bytes", peak_bytes()}};
  run.result["processes"] = Json::array();
  for (const std::string& one : processes.gather(own.dump())) run.result["processes"].push_back(Json::parse(one));
}

Exit filter(Run& run) {
  const Processes processes;
  std::optional<Outputs> outputs;
  const TexturedModel scene = read_scene(run, processes, outputs);
  if (run.dry_run()) return Exit::done;

  std::unique_ptr<TexelPart> part;
  processes.together([&] {
    const Step step(run, "part", 0.1);
    about(scene.model, [&] {
      const Seams seams(scene.surface, *scene.atlas);
      const TexelBlocks blocks(scene.surface, *scene.atlas, seams, block_side(*scene.atlas, processes.count()));
      const BlockOwners owners{blocks, parted(blocks, processes.count())};
      part = std::make_unique<TexelPart>(scene.surface, *scene.atlas, seams, owners, processes.rank(), step);
    });
  });
  const SurfaceScale scale{scene.atlas->surface_area, scene.atlas->texel_spacing()};
  double weight = 0;
  processes.together([&] {
    weight = app::asked_weight(run.options(), scale);
    require(weight <= largest_weight * scale.area,
            fmt::format("the weight is {:g} of the area, which is a length of {:.0f} % of its root; marquetry-mpi "
                        "takes up to {:g} (--alpha {:g}): use marquetry filter, on one machine and with smaller textures, "
                        "for what is that smooth",
                        weight / scale.area, 100 * std::sqrt(weight / scale.area), largest_weight, largest_weight));
  });

  Signal psi = read_values(run, processes, scene, *part);
  const bool luminance_alone = app::by_luminance(run.options(), scene.model);
  Signal Y;
  if (luminance_alone) Y = luminance(psi);
  Signal& worked = luminance_alone ? Y : psi;
  Signal change;
  {
    System system = make_system(run, processes, *part, weight, worked);
    change = solve(run, processes, system, *part);
  }
  Signal after = worked;
  for (std::size_t n = 0; n < part->own().size(); ++n) after.row(part->own()[n]) += change.row(Eigen::Index(n));
  if (luminance_alone) after = with_luminance(psi, Y, after);
  report_change(run, processes, own_rows(*part, psi), own_rows(*part, after), weight, scale.area);
  write_pictures(run, processes, scene, *part, *outputs, psi, after);
  report_processes(run, processes, scene, *part);
  return Exit::done;
}

}  // namespace

app::Verb filter_verb() {
  using Type = Option::Type;
  OptionTable table("filter", "Smooth or sharpen textures on the surface, across their seams, by several processes.");
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
  table.add({.name = "solver",
             .type = Type::choice,
             .default_value = "multigrid",
             .choices = {"multigrid", "boomeramg", "gamg"},
             .metavar = "HOW",
             .group = "Solver",
             .help = "what iterations are preconditioned by",
             .details = "multigrid: the cycle of marquetry in every process, and a coarse level that all share. "
                        "boomeramg, gamg: the algebraic multigrids of hypre and PETSc, to compare with."});
  app::add_stopping_options(table, app::as_typed(usual_tolerance),
                            fmt::format("Else they give up after {}, with a warning.", usual_cycles));
  app::add_space_option(table);
  app::add_depth_option(table);
  for (const char* name : {"mask", "spot", "field", "geometry", "normals", "normal-space", "vertices", "frames",
                           "threshold", "by-curvature", "smooth-normals", "fit-weight", "fit-steps", "compress"})
    table.elsewhere(name, not_yet);
  return {table, filter};
}

}  // namespace mq::shared

// marquetry spectrum MESH --basis BASIS -k N: the vector fields that change least on the surface.
//
// The library finds eigenvalues and fields; here they are printed, written as files that `lic`
// takes, and drawn with what `lic` does by default.
#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <memory>

#include "mq/base/error.h"
#include "mq/fem/texel_field_spectrum.h"
#include "mq/io/file_names.h"
#include "mq/io/vector_field.h"
#include "mq/model/field_files.h"
#include "options/signal_options.h"
#include "shell/arguments.h"
#include "shell/results.h"
#include "shell/verb.h"

namespace mq::app {
namespace {

namespace fs = std::filesystem;

FieldSpectrumOptions asked_spectrum(const OptionValues& options) {
  const std::string basis = options.text("basis"), dual = options.text("dual");
  require(basis == "triangle" || dual == "circumcentric",
          fmt::format("--dual is for --basis triangle; {} has none to choose", basis));
  require(basis == "whitney" || options.text("mass") == "exact",
          fmt::format("--mass is for --basis whitney; {} has none to choose", basis));
  return {.basis = basis == "triangle"   ? FieldBasis::triangle
                   : basis == "gradient" ? FieldBasis::gradient
                   : basis == "whitney"  ? FieldBasis::whitney
                                         : FieldBasis::vertex,
          .count = int(options.integer("count")),
          .centre = dual == "barycentric"     ? DualCentre::barycentre
                    : dual == "circumcentric" ? DualCentre::circumcentre
                                              : DualCentre::circumcentre_as_printed,
          .mass = options.text("mass") == "exact" ? WhitneyMass::exact : WhitneyMass::one_point};
}

std::vector<FieldFile> asked_files(const OptionValues& options, const TexturedModel& scene) {
  using Lines = FieldFilesOptions::Lines;
  if (!options.has("output")) return {};
  const fs::path folder = options.text("output");
  require(
      !names_model(folder) && !names_picture(folder),
      fmt::format("--output: found '{}', wanted a folder: a file for each field is written there",
                  folder.string()));
  FieldFilesOptions files{.folder = options.text("output"),
                          .name = options.text("basis"),
                          .count = int(options.integer("count"))};
  if (options.flag("lines"))
    files.lines = works_at_vertices(options, scene) ? Lines::vertices : Lines::textures;
  return field_files(scene.model, files);
}

std::vector<fs::path> paths_of(const std::vector<FieldFile>& files) {
  std::vector<fs::path> paths;
  for (const FieldFile& file : files) std::ranges::copy(file.paths(), std::back_inserter(paths));
  return paths;
}

void report(Run& run, const FieldSpectrum& spectrum, double area) {
  Json values = Json::array(), scaled = Json::array();
  std::string text = fmt::format("{:>6} {:>14} {:>14}\n", "", "eigenvalue", "at area 1");
  int zeros = 0;
  for (Eigen::Index k = 0; k < spectrum.values.size(); ++k) {
    const double value = spectrum.values[k];
    values.push_back(value);
    scaled.push_back(value * area);
    const bool zero = is_zero_eigenvalue(value, area);
    zeros += zero;
    text += fmt::format("{:>6} {:>14.6g} {:>14.6g}\n", k + 1, zero ? 0 : value,
                        zero ? 0 : value * area);
  }
  run.result["unknowns"] = spectrum.unknowns;
  run.result["edges_flipped"] = spectrum.flips;
  run.result["eigenvalues"] = values;
  run.result["eigenvalues_at_area_1"] = scaled;
  run.result["zeros"] = zeros;
  run.result["negative_weights"] = spectrum.negative_weights;
  run.result["massless_fields"] = spectrum.massless;
  if (const auto count = spectrum.negative_weights; count > 0)
    run.terminal().warning(
        fmt::format("{} not Delaunay, so that the dual as printed gives them negative weights: the form is no "
                    "smoothness of all fields, and values are not to be trusted; --dual circumcentric works on "
                    "Delaunay triangles",
                    count == 1 ? "1 edge is" : fmt::format("{} edges are", count)));
  if (const auto count = spectrum.massless; count > 0)
    run.terminal().warning(
        fmt::format("{} about the middles of all triangles and {} no mass in one point each, so the eigenvalue is "
                    "infinite: left out; --mass exact counts them",
                    count == 1 ? "1 field rotates" : fmt::format("{} fields rotate", count),
                    count == 1 ? "has" : "have"));
  run.print(text);
}

void write_fields(Run& run, const TexturedModel& scene, const FieldSpectrum& spectrum,
                  const std::vector<FieldFile>& files) {
  std::unique_ptr<ModelSignal> domain;
  std::unique_ptr<FieldLines> drawing;
  if (files.front().lines) {
    const Step step(run, "assemble", 0.1);
    domain = make_field_signal(run, scene, step);
    about(scene.model, [&] {
      drawing = std::make_unique<FieldLines>(
          *domain, FieldLinesOptions{.seed = std::uint64_t(run.options().integer("seed"))});
    });
  }
  const Step step(run, "write", 0.4);
  for (std::size_t k = 0; k < files.size(); ++k) {
    const Progress one =
        step.progress().step(fmt::format("field {}", k + 1), 1.0 / double(files.size()));
    write_vector_field(files[k].field, scene.model.mesh, spectrum.fields[k]);
    if (!files[k].lines) continue;
    const LineIntegral lines =
        drawing->draw(normalised(scene.surface, spectrum.fields[k]), one.step("draw", 0.9));
    if (!lines.spread.converged || !lines.sharpen.converged)
      run.terminal().warning(
          "lines are less drawn out than they should be: multigrid did not reach its "
          "tolerance; lic --field FILE --solver direct has no such limit");
    for (const std::string& note :
         write_lines(files[k], scene.model, *domain, lines.signal, one.step("save", 0.1)))
      run.terminal().remark(note);
  }
  say_written(run, paths_of(files));
}

FieldSpectrum spectrum_in_texels(Run& run, const TexturedModel& scene, int count) {
  std::unique_ptr<ModelSignal> domain;
  {
    const Step step(run, "assemble", 0.2);
    domain = make_field_signal(run, scene, step);
  }
  const Step step(run, "eigenvalues", 0.4);
  const TexelVectorSpace vectors(scene.surface, *domain->texel_atlas(), *domain->texel_space());
  return texel_field_spectrum(vectors, count, step);
}

Exit spectrum(Run& run) {
  const OptionValues& options = run.options();
  require(options.has("output") || !options.flag("lines"),
          "--lines draws fields into files: name a folder for them with --output");
  const FieldSpectrumOptions wanted = asked_spectrum(options);
  const bool in_texels = options.text("basis") == "texel";
  const TexturedModel scene = read_usable_model(
      run, in_texels || options.flag("lines") ? MissingPictures::assume : MissingPictures::unneeded, 0.1);
  require(!scene.is_picture, scene.model.path.string() +
                                 ": is a picture; vector fields that change least are of surfaces");
  require(!in_texels || !works_at_vertices(options, scene),
          scene.model.path.string() + ": --basis texel is for textures, and it has no texture coordinates; --basis vertex has "
                                      "the same eigenvalues, or give it some with unwrap");
  const std::vector<FieldFile> files = asked_files(options, scene);
  if (!files.empty()) run.will_write(paths_of(files), options.text("output"));
  if (run.dry_run()) return Exit::done;

  FieldSpectrum found;
  about(scene.model, [&] {
    if (in_texels) {
      found = spectrum_in_texels(run, scene, wanted.count);
      return;
    }
    const Step step(run, "eigenvalues", 0.4);
    found = field_spectrum(scene.surface, wanted, step);
  });
  report(run, found, scene.surface.area);
  if (!files.empty()) write_fields(run, scene, found, files);
  return Exit::done;
}

}  // namespace

Verb spectrum_verb() {
  using Type = Option::Type;
  OptionTable table("spectrum",
                    "The vector fields that change least on the surface: the smallest eigenvalues "
                    "of a smoothness operator, and their fields.");
  table.example("scan.obj", "the eigenvalues of its smoothest vector fields");
  table.example("scan.obj -k 12 -o fields/ --lines", "the fields, drawn");
  add_model_options(table, "the model: OBJ, PLY, glTF or GLB");
  table.add(
      {.name = "basis",
       .letter = 'b',
       .type = Type::choice,
       .default_value = "whitney",
       .choices = {"triangle", "gradient", "whitney", "vertex", "texel"},
       .metavar = "BASIS",
       .group = "Spectrum",
       .help = "triangle, gradient, whitney, vertex or texel",
       .details =
           "triangle: a vector per triangle; whitney: a number per edge; gradient: gradients and "
           "turned gradients of functions; vertex: a complex number per vertex; texel: one per texel of the "
           "textures, over all seams. triangle, vertex and texel measure the whole derivative, "
           "whitney and gradient divergence and curl."});
  table.add({.name = "count",
             .letter = 'k',
             .type = Type::integer,
             .default_value = as_typed(FieldSpectrumOptions{}.count),
             .least = 1,
             .most = 1000,
             .group = "Spectrum",
             .help = "how many eigenvalues"});
  table.add({.name = "dual",
             .type = Type::choice,
             .default_value = "circumcentric",
             .choices = {"circumcentric", "barycentric", "circumcentric-as-printed"},
             .metavar = "DUAL",
             .group = "Spectrum",
             .help = "where a triangle's vector is taken to be, for --basis triangle: circumcentric, barycentric or "
                     "circumcentric-as-printed",
             .details =
                 "circumcentric: on the Delaunay triangulation of the surface, which converges. "
                 "barycentric: on the mesh as it is, as published, which does not. circumcentric-as-printed: on the mesh "
                 "as it is too, to compare with: edges that are not Delaunay have negative weights, and eigenvalues may "
                 "be negative; refused where two triangles lie on one circle."});
  table.add({.name = "mass",
             .type = Type::choice,
             .default_value = "exact",
             .choices = {"exact", "one-point"},
             .group = "Spectrum",
             .help = "how the squares of fields are integrated, for --basis whitney",
             .details = "one-point: by the value in the middle of each triangle, as published, to compare with: "
                        "rotations about it have no mass."});
  table.add({.name = "output",
             .letter = 'o',
             .type = Type::path,
             .metavar = "FOLDER",
             .group = "Output",
             .help = "a folder for the fields, NAME_BASIS_01.ply and so on",
             .details = "With vx, vy, vz at its faces, as lic --field takes it."});
  table.add({.name = "lines",
             .group = "Output",
             .help = "draw the lines of each field too, as lic does by default",
             .details =
                 "Pictures NAME_BASIS_01.png, or where there are no texture coordinates models "
                 "NAME_BASIS_01_lines.ply with colours at their vertices."});
  add_vertices_option(table, "lines at vertices, though there are textures");
  return {table, spectrum};
}

}  // namespace mq::app

// marquetry filter MESH [TEXTURE...] -o OUT --beta B: smooth or sharpen a signal on its surface.
//
// The verb finds the signal (textures, or colours at vertices), takes it into the space of values
// asked for, lets ScreenedPoisson work, and puts the result back. A texel that the filter leaves
// alone, or that no chart touches, keeps its bits.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "memory.h"
#include "mq/base/error.h"
#include "mq/base/memory.h"
#include "mq/base/words.h"
#include "mq/fem/multigrid_solver.h"
#include "mq/fem/reference_solver.h"
#include "mq/fem/texel_space.h"
#include "mq/fem/vertex_space.h"
#include "mq/filter/screened_poisson.h"
#include "mq/image/colour.h"
#include "mq/image/normal_map.h"
#include "outputs.h"
#include "run.h"
#include "scene.h"
#include "verb.h"

namespace mq::app {
namespace {

/// A signal to be filtered, wherever it comes from.
class Target {
 public:
  virtual ~Target() = default;
  virtual const SignalSpace& space() const = 0;
  virtual Signal values() const = 0;
  /// Puts filtered values into the model. Unknowns that equal `before` in every channel stay.
  virtual void put(const Signal& before, const Signal& after, Model& model) const = 0;
  virtual bool has_multigrid() const = 0;
  virtual SolverFactory multigrid() const = 0;
  virtual SolverFactory reference() const = 0;
};

/// Options of an iterative solver that say when it stops.
template <class SolverOptions>
SolverOptions when_to_stop(const OptionValues& options) {
  SolverOptions solver;
  solver.tolerance = options.number("tolerance");
  if (options.has("cycles")) solver.max_cycles = int(options.integer("cycles"));
  return solver;
}

/// Above so many unknowns a factorisation takes several times as long as multigrid, and more
/// memory.
constexpr int most_for_direct = 30'000;

/// What --solver automatic begins with.
bool begins_with_multigrid(const Target& target) {
  return target.has_multigrid() && target.space().size() > most_for_direct;
}

SolverFactory solver(const std::string& name, const Target& target) {
  if (name == "multigrid" || (name == "automatic" && begins_with_multigrid(target)))
    return target.multigrid();
  if (name == "reference") return target.reference();
  return direct_solver();
}

bool same_row(const Signal& a, const Signal& b, Eigen::Index row) {
  return (a.row(row).array() == b.row(row).array()).all();
}

/// Textures, all of them one signal.
class TextureTarget : public Target {
 public:
  TextureTarget(Run& run, const Scene& scene, const Progress& progress)
      : options_(run.options()),
        model_(scene.model),
        channels_(common_channels(scene.model)),
        space_(scene.surface, *scene.atlas, {}, progress) {
    if (options_.flag("normals")) refuse_tangent_space(scene);
    run.found(space_.defects());
    run.warn(space_.defects());
  }

  const SignalSpace& space() const override { return space_; }
  Signal values() const override { return space_.gather(decoded()); }
  bool has_multigrid() const override { return true; }
  SolverFactory multigrid() const override {
    return multigrid_solver(space_.texels(), when_to_stop<MultigridOptions>(options_));
  }
  SolverFactory reference() const override {
    return reference_solver(space_.texels(), when_to_stop<ReferenceOptions>(options_));
  }

  void put(const Signal& before, const Signal& after, Model& model) const override {
    std::vector<Image<float>> pictures = decoded();
    space_.scatter(after, pictures);
    for (std::size_t i = 0; i < pictures.size(); ++i)
      pictures[i] = encoded(pictures[i], model.textures[i]);
    for (int k = 0; k < space_.size(); ++k) {
      if (same_row(before, after, k)) continue;
      const Texels::Place& place = space_.texels().places[std::size_t(k)];
      const auto from = pictures[std::size_t(place.texture)].pixel(place.x, place.y);
      const auto to = model.textures[std::size_t(place.texture)].pixels.pixel(place.x, place.y);
      std::copy_n(from.begin(), to.size(), to.begin());
    }
  }

 private:
  ColourSpace colour_space() const {
    const std::string name = options_.text("space");
    return name == "linear" ? ColourSpace::linear
           : name == "log"  ? ColourSpace::log
                            : ColourSpace::stored;
  }

  static Transfer transfer(const Texture& texture) {
    const bool is_float = texture.format.depth == Depth::half || texture.format.depth == Depth::f32;
    return is_float ? Transfer::linear : Transfer::srgb;
  }

  Image<float> decoded(const Texture& texture) const {
    if (options_.flag("normals")) return normals_from_colours(texture.pixels);
    if (colour_space() == ColourSpace::stored) return texture.pixels;
    return decode(texture.pixels, colour_space(), transfer(texture));
  }

  Image<float> encoded(const Image<float>& picture, const Texture& texture) const {
    if (options_.flag("normals")) return colours_from_normals(picture);
    if (colour_space() == ColourSpace::stored) return picture;
    return encode(picture, colour_space(), transfer(texture));
  }

  /// How many channels all pictures have. Those with and without alpha are filtered together.
  static int common_channels(const Model& model) {
    int most = 0;
    for (const Texture& texture : model.textures)
      most = std::max(most, texture.pixels.channels());
    for (std::size_t i = 0; i < model.textures.size(); ++i) {
      const int channels = model.textures[i].pixels.channels();
      const bool lacks_alpha = channels + 1 == most && colour_channels(most) != most;
      require(
          channels == most || lacks_alpha,
          fmt::format("{}: has {} and another texture of the model {}: textures of one model are "
                      "filtered together and must agree; convert one of them",
                      texture_file(model, i), counted(channels, "channel"), most));
    }
    return most;
  }

  /// The pictures in the values that are filtered; where one lacks alpha it is 1. Not kept: on
  /// large textures they would stand beside the solver's matrices.
  std::vector<Image<float>> decoded() const {
    std::vector<Image<float>> pictures;
    for (const Texture& texture : model_.textures) {
      pictures.push_back(decoded(texture));
      const Image<float>& picture = pictures.back();
      if (picture.channels() == channels_) continue;
      Image<float> wider(picture.width(), picture.height(), channels_, 1.0F);
      for (int y = 0; y < picture.height(); ++y)
        for (int x = 0; x < picture.width(); ++x)
          std::ranges::copy(picture.pixel(x, y), wider.pixel(x, y).begin());
      pictures.back() = std::move(wider);
    }
    return pictures;
  }

  /// On the two sides of a seam the same normal has different coordinates in tangent space.
  void refuse_tangent_space(const Scene& scene) const {
    if (scene.atlas->seam_count == 0) return;
    const std::vector<Image<float>> pictures = decoded();
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      Image<float> coverage(pictures[i].width(), pictures[i].height(), 1);
      for (const Texels::Place& place : space_.texels().places)
        if (std::size_t(place.texture) == i) coverage(place.x, place.y) = 1;
      const double upright = share_upright(pictures[i], coverage);
      require(upright < 0.9,
              fmt::format("{}: {:.0f} % of its normals point along z, so it seems to be in tangent "
                          "space, where the same normal has different values on the two sides of a "
                          "seam (there are {}): bake it in object space first",
                          texture_file(scene.model, i), 100 * upright, scene.atlas->seam_count));
    }
  }

  const OptionValues& options_;
  const Model& model_;
  int channels_;
  TexelSpace space_;
};

/// Colours at vertices. Copies of a vertex that exporters wrote for several charts are one unknown,
/// their mean.
class VertexTarget : public Target {
 public:
  explicit VertexTarget(const Scene& scene) : scene_(scene), space_(scene.surface) {}

  const SignalSpace& space() const override { return space_; }

  bool has_multigrid() const override { return false; }
  SolverFactory multigrid() const override { throw for_textures("multigrid"); }
  SolverFactory reference() const override { throw for_textures("reference"); }

  Signal values() const override {
    const VertexSignal& colors = scene_.model.colors;
    Signal sum = Signal::Zero(space_.size(), colors.channels);
    Vector copies = Vector::Zero(space_.size());
    for (int v = 0; v < scene_.model.mesh.vertex_count(); ++v) {
      const int unknown = scene_.surface.vertex_from_source[std::size_t(v)];
      if (unknown < 0) continue;
      copies[unknown] += 1;
      for (int c = 0; c < colors.channels; ++c)
        sum(unknown, c) += colors.values[std::size_t(v) * colors.channels + c];
    }
    // A vertex split into fans has its source's colour in each; only one of them was counted.
    for (int u = 0; u < space_.size(); ++u) {
      if (copies[u] > 0) {
        sum.row(u) /= copies[u];
        continue;
      }
      const int source = scene_.surface.source_from_vertex[std::size_t(u)];
      for (int c = 0; c < colors.channels; ++c)
        sum(u, c) = colors.values[std::size_t(source) * colors.channels + c];
    }
    return sum;
  }

  void put(const Signal& before, const Signal& after, Model& model) const override {
    VertexSignal& colors = model.colors;
    for (int v = 0; v < model.mesh.vertex_count(); ++v) {
      const int unknown = scene_.surface.vertex_from_source[std::size_t(v)];
      if (unknown < 0 || same_row(before, after, unknown)) continue;
      for (int c = 0; c < colors.channels; ++c)
        colors.values[std::size_t(v) * colors.channels + c] = float(after(unknown, c));
    }
  }

 private:
  static Unsupported for_textures(const std::string& name) {
    return Unsupported("--solver " + name + " is for textures; use direct for colours at vertices");
  }

  const Scene& scene_;
  VertexSpace space_;
};

std::unique_ptr<Target> make_target(Run& run, const Scene& scene, bool at_vertices,
                                    const Progress& progress) {
  std::unique_ptr<Target> target;
  about(scene.model, [&] {
    if (at_vertices)
      target = std::make_unique<VertexTarget>(scene);
    else
      target = std::make_unique<TextureTarget>(run, scene, progress);
  });
  return target;
}

/// Whether colours at vertices are meant: asked for, or all there is.
bool at_vertices(const Run& run, const Scene& scene) {
  const bool asked = run.options().flag("vertices");
  if (!asked && scene.atlas) return false;
  const std::string file = scene.model.path.string();
  require(scene.model.colors.channels > 0,
          asked ? file + ": has no colours at its vertices (--vertices)"
                : file +
                      ": has neither texture coordinates nor colours at its vertices: there is "
                      "nothing to filter");
  require(run.options().text("space") == "stored",
          file + ": has no texture coordinates; --space is for textures, not for colours at "
                 "vertices: leave it out");
  return true;
}

Length spread(const OptionValues& options) {
  if (options.has("length")) return parse_length(options.text("length"));
  return {options.number("alpha"), Length::Unit::alpha};
}

Json change_json(const Signal& before, const Signal& after) {
  const Signal change = after - before;
  const double count = double(std::max<Eigen::Index>(1, change.size()));
  return {{"unknowns", before.rows()},
          {"channels", before.cols()},
          {"rms_change", std::sqrt(change.squaredNorm() / count)},
          {"largest_change", change.size() ? change.cwiseAbs().maxCoeff() : 0.0},
          {"below_0", (after.array() < 0).count()},
          {"above_1", (after.array() > 1).count()}};
}

Json solve_json(const SolveReport& report) {
  return {{"method", report.method},
          {"cycles", report.cycles},
          {"residuals", report.residuals},
          {"converged", report.converged}};
}

/// A signal before and after, and what was tried in vain.
struct Solution {
  Signal before;
  Filtered filtered;
  Json tried = Json::array();
};

/// One attempt, with these shares of the progress. The signal is taken once the solver stands, whose
/// making needs most memory.
void attempt(Run& run, const Target& target, double weight, const SolverFactory& factory,
             double preparing, double solving, Solution& solution) {
  std::unique_ptr<ScreenedPoisson> poisson;
  {
    const Step step(run, "prepare", preparing);
    poisson = std::make_unique<ScreenedPoisson>(target.space(), weight, factory, step);
  }
  const Step step(run, "solve", solving);
  if (solution.before.size() == 0) solution.before = target.values();
  solution.filtered = poisson->solve(solution.before, run.options().number("beta"), step);
}

std::string reached(const SolveReport& report) {
  return fmt::format("{} stopped at a relative residual of {:.1e} after {}", report.method,
                     report.residuals.empty() ? 1 : report.residuals.back(),
                     counted(report.cycles, "cycle"));
}

/// Whether there is memory for a factorisation; otherwise says so of the result that is kept.
bool can_factorise(Run& run, const Target& target, const std::string& what_happened) {
  const double wanted = factorisation_bytes(target.space().size()), there = double(available_memory());
  if (wanted <= there) return true;
  run.terminal().warning(fmt::format(
      "{}, and a factorisation would need about {:.1f} GB where {:.1f} GB are free: the result is "
      "less accurate than asked for (--solver direct tries it all the same)",
      what_happened, wanted / 1e9, there / 1e9));
  return false;
}

std::string less_accurate(const std::string& what_happened, const Error& error) {
  return fmt::format("{}; {}: the result is less accurate than asked for", what_happened,
                     error.what());
}

/// Solves with what the options ask for. Where that is left to the program and multigrid does not
/// get there, a factorisation does, if there is memory for it.
Solution solve(Run& run, const Target& target, double weight) {
  const std::string name = run.options().text("solver");
  Solution solution;
  attempt(run, target, weight, solver(name, target), 0.25, 0.15, solution);
  const SolveReport first = solution.filtered.report;
  if (first.converged || run.options().has("cycles")) return solution;
  const std::string what_happened = reached(first);
  if (name != "automatic" || !begins_with_multigrid(target)) {
    run.terminal().warning(what_happened +
                           ": the result is less accurate than asked for; --solver direct has no "
                           "such limit");
    return solution;
  }
  if (!can_factorise(run, target, what_happened)) return solution;
  run.terminal().remark(what_happened + ": factorising instead");
  solution.tried.push_back(solve_json(first));
  try {
    attempt(run, target, weight, direct_solver(), 0.08, 0.02, solution);
    return solution;
  } catch (const SolverError& error) {
    run.terminal().warning(less_accurate(what_happened, error));
  } catch (const OutOfMemory& error) {
    run.terminal().warning(less_accurate(what_happened, error));
  }
  solution.tried.clear();
  return solution;
}

void set_depth(Model& model, const std::string& name) {
  if (name == "keep") return;
  const Depth depth = depth_from_name(name);
  for (Texture& texture : model.textures) texture.format.depth = depth;
  model.colors.depth = depth;
}

Exit filter(Run& run) {
  const OptionValues& options = run.options();
  Scene scene = read_scene(run, MissingPictures::refuse, 0.2);
  const Defects defects = scene_defects(scene);
  run.warn(defects);
  require_usable(defects, scene.model.path.string());
  const bool vertices = at_vertices(run, scene);
  const Outputs outputs(options.text("output"), scene.model,
                        vertices ? Outputs::Kind::model : Outputs::Kind::pictures);
  run.will_write(outputs.paths(), outputs.folder());
  if (run.dry_run()) return Exit::done;

  std::unique_ptr<Target> target;
  {
    const Step step(run, "assemble", 0.2);
    target = make_target(run, scene, vertices, step);
  }
  const double weight = weight_from_length(spread(options), target->space().scale());
  Solution solution;
  about(scene.model, [&] { solution = solve(run, *target, weight); });
  const Signal& before = solution.before;
  const Filtered& filtered = solution.filtered;

  const SurfaceScale scale = target->space().scale();
  run.result = change_json(before, filtered.signal);
  run.result["alpha"] = weight / scale.area;
  run.result["length"] = std::sqrt(weight);
  run.solve = solve_json(filtered.report);
  run.solve["tried"] = solution.tried;
  {
    const Step step(run, "write", 0.1);
    target->put(before, filtered.signal, scene.model);
    set_depth(scene.model, options.text("depth"));
    for (const std::string& note : outputs.write(std::move(scene.model), step))
      run.terminal().remark(note);
  }
  Json written = Json::array();
  for (const auto& path : outputs.paths()) {
    written.push_back(path.string());
    run.terminal().remark("wrote " + path.string());
  }
  run.result["outputs"] = written;
  return Exit::done;
}

}  // namespace

Verb filter_verb() {
  using Type = Option::Type;
  OptionTable table("filter",
                    "Smooth or sharpen a texture, or colours at vertices, on the surface, across "
                    "the seams of the texture.");
  add_scene_options(table);
  table.add({.name = "output",
             .letter = 'o',
             .type = Type::path,
             .required = true,
             .metavar = "OUT",
             .help = "a picture, a model, or a folder for all pictures",
             .details = "With several textures %s in the name stands for the texture's own."});
  table.add({.name = "beta",
             .letter = 'b',
             .type = Type::number,
             .required = true,
             .least = 0,
             .most = 1000,
             .group = "Filter",
             .help = "factor on the gradients: 0 smooths, 1 changes nothing, more sharpens"});
  table.add({.name = "alpha",
             .letter = 'a',
             .type = Type::number,
             .default_value = "0.001",
             .least = 0,
             .most = 1e6,
             .group = "Filter",
             .help = "how far it reaches: weight of gradients on the surface scaled to unit area",
             .details = "(length / sqrt(area)) squared; 0 changes nothing."});
  table.add(
      {.name = "length",
       .letter = 'l',
       .type = Type::length,
       .group = "Filter",
       .help = "the same as a distance: 0.02 in model units, 1% of sqrt(area), 8tx in texels"});
  table.add(
      {.name = "solver",
       .type = Type::choice,
       .default_value = "automatic",
       .choices = {"automatic", "direct", "multigrid", "reference"},
       .metavar = "HOW",
       .group = "Filter",
       .help = "automatic, direct, multigrid or reference",
       .details =
           "direct: a factorisation. multigrid: iterations, with far less memory on "
           "large textures. automatic: direct up to 30,000 unknowns, multigrid "
           "above, where there is one, and direct again where that does not reach the tolerance "
           "and memory allows. reference: the multigrid solver as it was published, in double "
           "precision, to compare with."});
  table.add({.name = "tolerance",
             .type = Type::number,
             .default_value = "1e-6",
             .least = 1e-16,
             .most = 0.1,
             .group = "Filter",
             .help = "relative residual at which iterations stop"});
  table.add({.name = "cycles",
             .type = Type::integer,
             .least = 1,
             .most = 10000,
             .group = "Filter",
             .help = "stop iterations after so many cycles, converged or not"});
  table.add({.name = "space",
             .type = Type::choice,
             .default_value = "stored",
             .choices = {"stored", "linear", "log"},
             .group = "Signal",
             .help = "in which values are processed",
             .details =
                 "stored: as the file holds them. linear: light, with the sRGB curve undone. "
                 "log: the logarithm of light."});
  table.add(
      {.name = "normals",
       .group = "Signal",
       .help = "the texture is a normal map in object space; keep its normals of unit length"});
  table.add({.name = "vertices",
             .group = "Signal",
             .help = "filter the colours at vertices, though there are textures",
             .details = "Without texture coordinates this is what is done anyway."});
  table.add({.name = "depth",
             .type = Type::choice,
             .default_value = "keep",
             .choices = {"keep", "8", "16", "half", "float"},
             .group = "Signal",
             .help = "bits per value in the output"});
  table.exclusive({"alpha", "length"}).exclusive({"normals", "vertices"});
  add_frames_option(table);
  return {table, filter};
}

}  // namespace mq::app

// mpirun -n N marquetry-mpi stitch MESH [TEXTURE...] -o FOLDER/: the steps between photographs taken out, the texels parted
// among processes.
//
// What a region asks for where it meets another (filter/stitch.h) a process works out for its own rows; how regions go on
// past their borders, which takes the neighbours of a texel, it fetches for those of others. What borders say of the
// exposures of regions is gathered by all.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "equation.h"
#include "mq/base/error.h"
#include "mq/base/release.h"
#include "mq/base/words.h"
#include "mq/filter/stitch.h"
#include "mq/filter/weak_unknowns.h"
#include "mq/image/colour.h"
#include "mq/io/image_file.h"
#include "mq/model/photograph_texture.h"
#include "mq/model/stitch_regions.h"
#include "options/model_options.h"
#include "options/signal_options.h"
#include "shell/run.h"
#include "textures.h"
#include "verbs.h"
#include "verbs/shared/partials.h"

namespace mq::shared {
namespace {

using app::Exit;
using app::Run;

/// The model's part here, and who has the rest.
struct Shared {
  const Processes& processes;
  const TexturedModel& scene;
  TexelPart& part;
  Numbering numbering;
};

using Colour = std::vector<float>;

/// The colour of its label, for each own texel.
std::vector<Colour> label_colours(const Shared& shared, const std::vector<std::string>& files) {
  const std::vector<TextureSize>& sizes = shared.scene.texture_sizes;
  std::vector<Colour> colours(shared.part.own().size());
  shared.processes.together([&] {
    require(files.size() == sizes.size(),
            fmt::format("{} for {}: give one each", counted(std::ssize(files), "label picture"),
                        counted(std::ssize(sizes), "texture")));
    for (std::size_t k = 0; k < files.size(); ++k) {
      if (!shared.part.has_texture(int(k))) continue;
      const Texture picture = read_texture(files[k]);
      require_exact(picture);
      const int channels = picture.pixels.channels(), seen = colour_channels(channels);
      for (std::size_t n = 0; n < colours.size(); ++n) {
        const Texels::Place& at = shared.part.places()[std::size_t(shared.part.own()[n])];
        if (at.texture != int(k)) continue;
        const auto pixel = nearest_pixel(at, sizes[k], picture.pixels);
        if (seen < channels && pixel.back() == 0)
          throw InvalidInput(fmt::format("--labels: {}: is transparent in column {}, row {}, where nobody sees the surface; "
                                         "{}",
                                         files[k], at.x, at.y, not_yet("stitch")));
        colours[n].assign(pixel.begin(), pixel.begin() + seen);
      }
    }
  });
  return colours;
}

/// Numbers of regions, the same in all processes, for each unknown of the part's space.
std::vector<int> region_numbers(const Shared& shared, const std::vector<std::string>& files) {
  Signal labels = Signal::Zero(Eigen::Index(shared.part.places().size()), 1);
  if (files.empty()) {
    if (!shared.part.empty())
      for (const int i : shared.part.own()) labels(i, 0) = shared.part.space().texels().chart[std::size_t(i)];
  } else {
    const std::vector<Colour> colours = label_colours(shared, files);
    const auto text_of = [](const Colour& colour) { return fmt::format("{:a}", fmt::join(colour, " ")); };
    std::map<Colour, std::string> texts;
    for (const Colour& colour : colours)
      if (!texts.contains(colour)) texts.emplace(colour, text_of(colour));
    std::vector<std::string> own;
    for (const auto& [colour, text] : texts) own.push_back(text);
    std::map<std::string, int> number;
    for (const std::string& text : shared.processes.gather_lines(own)) number.emplace(text, 0);
    require_labels(files.front(), std::ssize(number));
    int count = 0;
    for (auto& [text, n] : number) n = count++;
    for (std::size_t n = 0; n < colours.size(); ++n)
      labels(shared.part.own()[n], 0) = number.at(texts.at(colours[n]));
  }
  shared.processes.talking([&] { shared.numbering.fill_halo(labels); });
  std::vector<int> numbers(std::size_t(labels.rows()), 0);
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = int(std::lround(labels(Eigen::Index(i), 0)));
  return numbers;
}

/// One more than the largest number of a region, in any process.
std::size_t region_bound(const Shared& shared, const std::vector<int>& labels) {
  int most = -1;
  for (const int i : shared.part.own()) most = std::max(most, labels[std::size_t(i)]);
  return std::size_t(shared.processes.largest(most) + 1);
}

/// How many regions there are altogether.
std::int64_t count_regions(const Shared& shared, const std::vector<int>& labels) {
  std::vector<double> there(region_bound(shared, labels), 0);
  for (const int i : shared.part.own()) there[std::size_t(labels[std::size_t(i)])] = 1;
  shared.processes.largest(there);
  return std::ranges::count(there, 1);
}

/// The pairs of all processes.
RegionPairs gathered(const Processes& processes, const RegionPairs& own) {
  const auto channels = std::size_t(own.from.cols()), width = 3 + 2 * channels;
  std::vector<double> rows;
  for (std::size_t k = 0; k < own.regions.size(); ++k) {
    rows.insert(rows.end(), {double(own.regions[k][0]), double(own.regions[k][1]), own.weights[k]});
    for (const Signal* side : {&own.from, &own.to})
      for (std::size_t c = 0; c < channels; ++c) rows.push_back((*side)(Eigen::Index(k), Eigen::Index(c)));
  }
  RegionPairs all;
  std::vector<std::vector<double>> from;
  processes.talking([&] {
    from = processes.exchange(std::vector<std::vector<double>>(std::size_t(processes.count()), rows));
  });
  std::size_t count = 0;
  for (const std::vector<double>& of_one : from) count += of_one.size() / width;
  all.from.resize(Eigen::Index(count), Eigen::Index(channels));
  all.to.resize(Eigen::Index(count), Eigen::Index(channels));
  for (const std::vector<double>& of_one : from)
    for (std::size_t at = 0; at < of_one.size(); at += width) {
      const auto row = std::ssize(all.weights);
      all.regions.push_back({int(of_one[at]), int(of_one[at + 1])});
      all.weights.push_back(of_one[at + 2]);
      for (std::size_t c = 0; c < channels; ++c) {
        all.from(row, Eigen::Index(c)) = of_one[at + 3 + c];
        all.to(row, Eigen::Index(c)) = of_one[at + 3 + channels + c];
      }
    }
  return all;
}

/// The gains of regions, from what all borders say.
RegionLevels levels_of(const Shared& shared, const SparseMatrix& S, const Signal& psi, const std::vector<int>& labels,
                       LightLaw law) {
  const Processes& processes = shared.processes;
  RegionPairs own;
  own.from.resize(0, psi.cols());
  std::vector<double> areas(region_bound(shared, labels), 0);
  processes.together([&] {
    if (shared.part.empty()) return;
    own = region_pairs(S, psi, labels, shared.part.own());
    const Vector mass = shared.part.space().lumped_mass();
    for (const int i : shared.part.own()) areas[std::size_t(labels[std::size_t(i)])] += mass[i];
  });
  processes.sum(areas);
  return {gathered(processes, own), areas, law};
}

/// What is asked of the gradients of the own texels where regions meet; rows of the part's space.
Signal asked_change(const Shared& shared, const SparseMatrix& S, const Signal& psi, const std::vector<int>& labels,
                    const std::string& borders) {
  Signal slopes = Signal::Zero(psi.rows(), 4 * psi.cols()), change = Signal::Zero(psi.rows(), psi.cols());
  const bool continued = borders == "continued";
  shared.processes.together([&] {
    if (continued && !shared.part.empty()) slopes = region_slopes(shared.part.space(), S, psi, labels);
  });
  if (continued) shared.processes.talking([&] { shared.numbering.fill_halo(slopes); });
  shared.processes.together([&] {
    if (shared.part.empty()) return;
    change = continued ? stitch_regions(shared.part.space(), psi, labels, slopes)
                       : level_borders(shared.part.space(), S, psi, labels);
  });
  return change;
}

/// ψ + δ, weak texels brought into the range of those beside them, whichever process has these.
Signal bounded(const Shared& shared, const WeakUnknowns& weak, const Signal& psi, const Signal& own_change) {
  Signal asked = Signal::Zero(psi.rows(), psi.cols());
  for (std::size_t n = 0; n < shared.part.own().size(); ++n)
    asked.row(shared.part.own()[n]) = own_change.row(Eigen::Index(n));
  Signal delta = asked;
  shared.processes.talking([&] {
    for (double changed = 1; changed > 0;) {
      shared.numbering.fill_halo(delta);
      changed = shared.processes.largest(weak.bound(asked, delta) ? 1.0 : 0.0);
    }
  });
  return psi + delta;
}

Exit stitch(Run& run) {
  const Processes processes;
  const OptionValues& options = run.options();
  std::optional<Outputs> outputs;
  const TexturedModel scene = read_scene(run, processes, "stitch", outputs, [](const OptionValues&) {});
  if (run.dry_run()) return Exit::done;

  const std::unique_ptr<TexelPart> part = part_of(run, processes, scene);
  const double weight = checked_weight(
      processes, "stitch", scene, [&](const SurfaceScale& scale) { return app::spread_weight(options, scale); });
  Signal before = read_values(run, processes, scene, *part);
  std::optional<Shared> shared;
  processes.talking([&] {
    shared.emplace(Shared{processes, scene, *part, Numbering(processes, *part)});
    shared->numbering.fill_halo(before);
  });
  const std::vector<int> labels = region_numbers(*shared, options.texts("labels"));

  SparseMatrix S;
  Signal diagonal = Signal::Zero(before.rows(), 1);
  processes.together([&] {
    if (part->empty()) return;
    S = part->space().stiffness();
    diagonal.col(0) = S.diagonal();
  });
  processes.talking([&] { shared->numbering.fill_halo(diagonal); });
  RegionLevels levels;
  const auto law = light_law(scene.model.textures, app::value_space(options));
  if (law && options.text("exposure") == "match") levels = levels_of(*shared, S, before, labels, *law);
  const Signal raised = levels.gains().rows() > 0 ? levels.raised(before, labels) : before;
  const Signal B = weight * own_rows(*part, asked_change(*shared, S, raised, labels, options.text("borders")));
  const WeakUnknowns weak(S, diagonal.col(0), labels, part->own());
  release(S);

  const Signal change = SharedEquation(run, processes, shared->numbering, *part, weight).solve(B);
  const Signal after = bounded(*shared, weak, raised, change);
  run.result["regions"] = count_regions(*shared, labels);
  if (levels.gains().size() > 0) run.result["largest_gain"] = std::exp(levels.gains().cwiseAbs().maxCoeff());
  report_weight(run, scene, weight);
  write_result(run, processes, scene, *part, *outputs, before, after);
  return Exit::done;
}

}  // namespace

app::Verb stitch_verb() {
  OptionTable table("stitch", "Take the steps out of textures where photographs meet, by several processes.");
  describe_program(table);
  table.example("castle.obj -o out/", "no steps, where every chart is a photograph");
  app::add_model_options(table);
  app::add_output_option(table);
  app::add_labels_option(table);
  app::add_levels_option(table);
  app::add_borders_option(table);
  app::add_spread_options(table, usual_photograph_length, "Stitch", "how far steps between photographs are spread");
  add_shared_solver_options(table, "multigrid", {"bddc"});
  app::add_space_option(table);
  app::add_depth_option(table);
  for (const char* name : {"unseen", "partial", "confidence", "frames", "compress"})
    table.elsewhere(name, not_yet("stitch"));
  return {table, stitch};
}

}  // namespace mq::shared

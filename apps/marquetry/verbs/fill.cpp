// marquetry fill MESH [TEXTURE...] -o OUT: values for the texels outside charts.
//
// First those that lookups at the borders of charts read: the smoothest for which the two sides of
// each seam agree, with everything inside charts as it is. Then all others, each from the nearest
// that a triangle covers, so that no level of a mipmap mixes in what was there before.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "mq/atlas/coverage.h"
#include "mq/base/error.h"
#include "mq/filter/seam_values.h"
#include "mq/image/spread.h"
#include "shell/results.h"
#include "shell/run.h"
#include "options/model_options.h"
#include "verbs/shared/seam_report.h"
#include "options/signal_options.h"
#include "options/solver_options.h"
#include "shell/verb.h"

namespace mq::app {
namespace {

/// 1 for unknowns whose centre no triangle covers.
std::vector<char> outside(const TexelSpace& space, const std::vector<Coverage>& coverage) {
  std::vector<char> result;
  for (const Texels::Place& at : space.texels().places)
    result.push_back(coverage[std::size_t(at.texture)].count(at.x, at.y) == 0);
  return result;
}

/// Gives the texels that no chart uses, as far as `distance` from one that a chart does, the values
/// of the nearest covered one: those of borders go on across a seam, and nowhere else. Returns how
/// many no chart uses.
std::int64_t spread_all(const TexelSpace& space, const std::vector<Coverage>& coverage,
                        double distance, Model& model) {
  std::int64_t outside = 0;
  for (std::size_t k = 0; k < model.textures.size(); ++k) {
    Image<float>& picture = model.textures[k].pixels;
    const int width = picture.width(), height = picture.height();
    Image<char> covered(width, height, 1);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) covered(x, y) = coverage[k].count(x, y) > 0;
    Image<char> used = covered;
    for (const Texels::Place& at : space.texels().places)
      if (std::size_t(at.texture) == k) used(at.x, at.y) = 1;
    outside += std::ranges::count(used.values(), 0);
    spread(covered, used, distance, picture);
  }
  return outside;
}

Exit fill(Run& run) {
  const OptionValues& options = run.options();
  TexturedModel scene = read_usable_model(run, MissingPictures::refuse, 0.2);
  require(scene.atlas.has_value(),
          scene.model.path.string() + ": has no texture coordinates, so no charts to fill around");
  const Outputs outputs(options.text("output"), scene.model, Outputs::Kind::pictures);
  run.will_write(outputs.paths(), outputs.folder());
  if (run.dry_run()) return Exit::done;

  std::unique_ptr<TextureSignal> target;
  std::vector<Coverage> coverage;
  std::vector<char> free;
  Signal before, after;
  const Json difference = seams_json(scene);
  about(scene.model, [&] {
    {
      const Step step(run, "assemble", 0.3);
      coverage = texel_coverage(scene.surface, *scene.atlas, step.progress().step("cover", 0.1));
      ValueSpace values = value_space(options);
      values.meets_at_seams = options.number("weight") > 0;
      target = make_texture_signal(
          run, scene,
          {.values = values, .space = soft_seams(*scene.atlas, options.number("weight"))},
          step.progress().step("space", 0.9));
      free = outside(target->space(), coverage);
    }
    const Step step(run, "solve", 0.3);
    before = target->values();
    after = solve_at_seams(run, target->space(), before, free, Smooth::values, step);
    // Nothing lies beyond what was given: a border may extrapolate, a picture should not.
    const Eigen::RowVectorXd low = before.colwise().minCoeff(), high = before.colwise().maxCoeff();
    for (Eigen::Index i = 0; i < after.rows(); ++i)
      if (free[std::size_t(i)]) after.row(i) = after.row(i).cwiseMax(low).cwiseMin(high);
  });
  run.result = change_json(before, after);
  run.result["border_texels"] = std::ranges::count(free, 1);
  const Step step(run, "write", 0.2);
  target->put(before, after, scene.model);
  const double distance = options.has("distance") ? options.number("distance")
                                                  : std::numeric_limits<double>::infinity();
  run.result["outside_texels"] =
      spread_all(target->space(), coverage, distance, scene.model);
  run.result["seams"] = {{"before", difference}, {"after", seams_json(scene)}};
  set_depth(options, scene.model);
  write_outputs(run, outputs, std::move(scene.model), step);
  return Exit::done;
}

}  // namespace

Verb fill_verb() {
  OptionTable table("fill",
                    "Give the texels outside charts values that go on from inside, so that neither "
                    "seams nor smaller levels of a mipmap show what was there.");
  add_model_options(table);
  add_output_option(table);
  table.add({.name = "distance",
             .type = Option::Type::number,
             .unit = "texels",
             .least = 0,
             .most = 1e6,
             .group = "Fill",
             .help = "how far beyond the charts' own texels; without it everywhere"});
  table.add({.name = "weight",
             .type = Option::Type::number,
             .default_value = "100",
             .least = 0,
             .most = 1e9,
             .group = "Fill",
             .help = "of agreement at seams against smoothness, per texel of a seam",
             .details = "0: charts go on by themselves, as normals in tangent space must."});
  add_space_option(table);
  add_normals_option(table);
  add_depth_option(table);
  add_frames_option(table);
  return {table, fill,
          {{.what = "texels outside charts", .vertices = "", .pictures = ""}}};
}

}  // namespace mq::app

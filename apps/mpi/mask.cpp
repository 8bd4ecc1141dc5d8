#include "mask.h"

#include <algorithm>
#include <array>
#include <optional>
#include <set>
#include <string>

#include "mq/base/error.h"
#include "mq/filter/modulation.h"
#include "mq/io/file_names.h"
#include "options/mask_options.h"
#include "textures.h"
#include "verbs/shared/filter_strength.h"

namespace mq::shared {
namespace {

using app::Run;

/// A value per unknown of the part's space, those of the halo 0.
std::vector<double> painted(Run& run, const Processes& processes, const TexturedModel& scene, const TexelPart& part) {
  std::vector<double> mask(part.places().size(), 0);
  std::vector<std::string> remarks;
  processes.together([&] {
    const std::vector<std::string> files = run.options().texts("mask");
    for (std::size_t k = 0; k < files.size(); ++k) {
      if (!part.has_texture(int(k))) continue;
      const app::MaskPicture picture = app::read_mask(files[k], scene.texture_sizes[k]);
      remarks.insert(remarks.end(), picture.remarks.begin(), picture.remarks.end());
      for (const int i : part.own()) {
        const Texels::Place& at = part.places()[std::size_t(i)];
        if (at.texture == int(k)) mask[std::size_t(i)] = mask_at(picture.pixels, scene.texture_sizes[k], at.x, at.y, -1);
      }
    }
  });
  std::vector<std::string> all;
  processes.talking([&] { all = processes.gather_lines(remarks); });
  for (const std::string& remark : std::set(all.begin(), all.end())) run.terminal().remark(remark);
  return mask;
}

/// Where its owner has a texel; nothing where none has it.
std::optional<Vector3> place_of(const Processes& processes, const TexelPart& part, const Texels::Place& texel) {
  double found[4] = {};
  for (const int i : part.own()) {
    const Texels::Place& at = part.places()[std::size_t(i)];
    if (at.texture != texel.texture || at.x != texel.x || at.y != texel.y) continue;
    const Vector3 position = part.space().texels().position(i);
    for (int k = 0; k < 3; ++k) found[k] = position[k];
    found[3] = 1;
  }
  processes.sum(found);
  if (found[3] == 0) return {};
  return Vector3(found[0], found[1], found[2]);
}

void add_spots_to(Run& run, const Processes& processes, const TexturedModel& scene, const TexelPart& part,
                  std::vector<double>& mask) {
  if (run.options().texts("spot").empty()) return;
  std::vector<Vector3> places;
  for (const int i : part.own()) places.push_back(part.space().texels().position(i));
  std::vector<double> own;
  for (const int i : part.own()) own.push_back(mask[std::size_t(i)]);
  const SurfaceScale scale{scene.atlas->surface_area, scene.atlas->texel_spacing()};
  const std::vector<Spot> spots = app::asked_spots(
      run.options(), scene, scale, [&](const Texels::Place& texel) { return place_of(processes, part, texel); });
  for (const Spot& spot : spots) {
    double changes = double(add_spots(std::array{spot}, places, own));
    processes.sum({&changes, 1});
    if (changes == 0) run.terminal().warning(app::spot_without_effect(spot, scene));
  }
  for (std::size_t n = 0; n < own.size(); ++n) mask[std::size_t(part.own()[n])] = own[n];
}

void report(Run& run, const Processes& processes, const TexelPart& part, const std::vector<double>& mask) {
  double sums[4] = {double(part.own().size()), 0, 0, 0};
  for (const int i : part.own()) {
    const double m = mask[std::size_t(i)];
    sums[1] += m, sums[2] += m != 0, sums[3] += m < 0;
  }
  processes.sum(sums);
  const double count = std::max(1.0, sums[0]);
  run.result["mask"] = app::mask_json(sums[1] / count, sums[2] / count, sums[3] / count);
}

}  // namespace

void check_mask(Run& run, const TexturedModel& scene) {
  const std::vector<std::string> files = run.options().texts("mask");
  require(files.empty() || !names_model(files.front()),
          "--mask: " + (files.empty() ? "" : files.front()) + " is a model: " + not_yet("filter"));
  app::check_mask(run, scene);
}

std::vector<double> asked_modulation(Run& run, const Processes& processes, const TexturedModel& scene,
                                     const TexelPart& part, const Numbering& numbering) {
  const OptionValues& options = run.options();
  const double beta = app::asked_beta(options);
  if (options.texts("mask").empty() && options.texts("spot").empty())
    return std::vector<double>(part.places().size(), beta);
  std::vector<double> mask = painted(run, processes, scene, part);
  // All processes find the same wrong with the words of --spot: that is said once.
  std::string refused;
  processes.talking([&] {
    try {
      add_spots_to(run, processes, scene, part, mask);
    } catch (const InvalidInput& error) {
      refused = error.what();
    }
  });
  processes.together([&] { require(refused.empty(), refused); });
  processes.talking([&] {
    report(run, processes, part, mask);
    numbering.fill_halo(mask, 1);
  });
  return modulation(mask, beta);
}

}  // namespace mq::shared

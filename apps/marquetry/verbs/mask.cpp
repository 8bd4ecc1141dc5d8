// marquetry mask MESH [TEXTURE...] -o OUT --what W: which texels the charts use, and for what.
#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "options/signal_options.h"
#include "mq/atlas/coverage.h"
#include "mq/base/error.h"
#include "mq/filter/seam_values.h"
#include "mq/io/file_names.h"
#include "shell/results.h"
#include "shell/run.h"
#include "options/model_options.h"
#include "shell/verb.h"

namespace mq::app {
namespace {

/// A colour of 3 × 8 bits for number n, another for each of the first 2²⁴ − 1, far apart for
/// neighbours; black is none.
std::array<float, 3> label_colour(int n) {
  constexpr std::uint32_t mask = (1U << 24) - 1, odd = 0x9E3779B1U;  // 2³² / golden ratio
  const std::uint32_t bits = n < 0 ? 0 : (std::uint32_t(n) + 1) * odd & mask;
  return {float(bits >> 16) / 255, float(bits >> 8 & 255) / 255, float(bits & 255) / 255};
}

struct Maps {
  std::vector<Image<float>> pictures;
  std::int64_t marked = 0;  ///< texels that are not black

  Maps(const std::vector<TextureSize>& sizes, int channels) {
    for (const TextureSize& size : sizes) pictures.emplace_back(size.width, size.height, channels);
  }
  void set(int texture, int x, int y, std::span<const float> values) {
    const auto pixel = pictures[std::size_t(texture)].pixel(x, y);
    std::copy_n(values.begin(), pixel.size(), pixel.begin());
    ++marked;
  }
  void set(int texture, int x, int y, float value) { set(texture, x, y, {{value}}); }
};

/// Texels that charts read; with `boundary` those of them that a seam or an end of the surface
/// touches.
Maps active_maps(Run& run, const TexturedModel& scene, const std::string& what, const Progress& progress) {
  const auto signal = make_texture_signal(
      run, scene, {.pictures = TextureSignalOptions::Pictures::replaced}, progress);
  const Texels& texels = signal->space().texels();
  Maps maps(scene.texture_sizes, what == "chart" ? 3 : 1);
  for (int i = 0; i < texels.size(); ++i) {
    const Texels::Place& at = texels.places[std::size_t(i)];
    if (what == "boundary" && texels.interior[std::size_t(i)]) continue;
    if (what == "chart")
      maps.set(at.texture, at.x, at.y, label_colour(texels.chart[std::size_t(i)]));
    else
      maps.set(at.texture, at.x, at.y, 1);
  }
  return maps;
}

Maps covered_maps(const TexturedModel& scene, const std::string& what, const Progress& progress) {
  const std::vector<Coverage> coverage = texel_coverage(scene.surface, *scene.atlas, progress);
  Maps maps(scene.texture_sizes, what == "triangle" ? 3 : 1);
  for (std::size_t k = 0; k < coverage.size(); ++k)
    for (int y = 0; y < coverage[k].count.height(); ++y)
      for (int x = 0; x < coverage[k].count.width(); ++x) {
        const int count = coverage[k].count(x, y);
        if (count == 0) continue;
        if (what == "triangle")
          maps.set(int(k), x, y, label_colour(coverage[k].triangle(x, y)));
        else
          maps.set(int(k), x, y, float(std::min(count, 255)) / 255);
      }
  return maps;
}

/// A model whose textures are pictures without loss, for `Outputs` to name.
void replace_textures(Model& model, std::vector<Image<float>> pictures) {
  model.textures.resize(pictures.size());
  for (std::size_t k = 0; k < pictures.size(); ++k) {
    Texture& texture = model.textures[k];
    const std::string stem = texture.path.empty() ? texture.name : texture.path.stem().string();
    texture = Texture();
    texture.name = (stem.empty() ? fmt::format("mask_{}", k) : stem) + ".png";
    texture.format.file_format = "png";
    texture.pixels = std::move(pictures[k]);
  }
}

void refuse_jpeg(const Outputs& outputs) {
  for (const auto& path : outputs.paths())
    require(path.extension() != ".jpg" && path.extension() != ".jpeg",
            "--output: " + path.string() + ": JPEG does not keep values exactly: choose .png");
}

Exit mask(Run& run) {
  const OptionValues& options = run.options();
  const std::string what = options.text("what");
  TexturedModel scene = read_usable_model(run, MissingPictures::assume, 0.3);
  require(scene.atlas.has_value(),
          scene.model.path.string() + ": has no texture coordinates, so no texels to mark");
  std::vector<Image<float>> blank;
  for (std::size_t k = 0; k < scene.texture_sizes.size(); ++k) blank.emplace_back();
  Model named = scene.model;
  replace_textures(named, std::move(blank));
  require(!names_model(options.text("output")),
          "--output: found '" + options.text("output") + "', wanted a picture or a folder");
  const Outputs outputs(options.text("output"), named, Outputs::Kind::pictures);
  refuse_jpeg(outputs);
  run.will_write(outputs.paths(), outputs.folder());
  if (run.dry_run()) return Exit::done;

  std::unique_ptr<Maps> maps;
  about(scene.model, [&] {
    const Step step(run, "mark", 0.5);
    const bool covered = what == "triangle" || what == "overlap";
    maps = std::make_unique<Maps>(covered ? covered_maps(scene, what, step)
                                          : active_maps(run, scene, what, step));
  });
  run.result["texels"] = maps->marked;
  const Step step(run, "write", 0.2);
  replace_textures(named, std::move(maps->pictures));
  write_outputs(run, outputs, std::move(named), step);
  return Exit::done;
}

}  // namespace

Verb mask_verb() {
  OptionTable table("mask", "Draw which texels the charts use, and for what.");
  add_model_options(table);
  add_output_option(table);
  table.add(
      {.name = "what",
       .letter = 'w',
       .type = Option::Type::choice,
       .default_value = "active",
       .choices = {"active", "boundary", "chart", "triangle", "overlap"},
       .metavar = "WHAT",
       .group = "Mask",
       .help = "active, boundary, chart, triangle or overlap",
       .details =
           "active: white where a lookup on the surface reads the texel. boundary: those of "
           "them at seams and at the ends of charts. chart, triangle: a colour of its own for "
           "each chart, or for the triangle that covers the texel's centre; black is none. "
           "overlap: how many triangles cover the centre, as the stored value."});
  add_frames_option(table);
  return {table, mask};
}

}  // namespace mq::app

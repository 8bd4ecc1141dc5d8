// marquetry mask MESH [TEXTURE...] -o OUT --what W: which texels the charts use, and for what.
#include <algorithm>
#include <utility>

#include "mq/base/error.h"
#include "mq/draw/texel_maps.h"
#include "mq/io/file_names.h"
#include "mq/model/lossless_textures.h"
#include "shell/results.h"
#include "shell/run.h"
#include "options/model_options.h"
#include "options/signal_options.h"
#include "shell/verb.h"

namespace mq::app {
namespace {

const std::vector<std::pair<std::string, TexelUse>>& uses() {
  static const std::vector<std::pair<std::string, TexelUse>> all = {
      {"active", TexelUse::active},
      {"boundary", TexelUse::boundary},
      {"chart", TexelUse::chart},
      {"triangle", TexelUse::triangle},
      {"overlap", TexelUse::overlap}};
  return all;
}

TexelUse asked_use(const OptionValues& options) {
  const std::string name = options.text("what");
  return std::ranges::find(uses(), name, [](const auto& use) { return use.first; })->second;
}

std::vector<std::string> use_names() {
  std::vector<std::string> names;
  for (const auto& [name, use] : uses()) names.push_back(name);
  return names;
}

void refuse_jpeg(const Outputs& outputs) {
  for (const auto& path : outputs.paths())
    require(path.extension() != ".jpg" && path.extension() != ".jpeg",
            "--output: " + path.string() + ": JPEG does not keep values exactly: choose .png");
}

Exit mask(Run& run) {
  const OptionValues& options = run.options();
  TexturedModel scene = read_usable_model(run, MissingPictures::assume, 0.3);
  require(scene.atlas.has_value(),
          scene.model.path.string() + ": has no texture coordinates, so no texels to mark; the verb unwrap makes some");
  Model named = scene.model;
  replace_with_lossless(named, std::vector<Image<float>>(scene.texture_sizes.size()), "mask");
  require(!names_model(options.text("output")),
          "--output: found '" + options.text("output") + "', wanted a picture or a folder");
  const Outputs outputs(options.text("output"), named, Outputs::Kind::pictures);
  refuse_jpeg(outputs);
  run.will_write(outputs.paths(), outputs.folders());
  if (run.dry_run()) return Exit::done;

  TexelMaps maps;
  about(scene.model, [&] {
    const Step step(run, "mark", 0.5);
    maps = texel_maps(scene.surface, *scene.atlas, asked_use(options), step);
    run.found(maps.defects);
    run.warn(maps.defects);
  });
  run.result["texels"] = maps.marked;
  const Step step(run, "write", 0.2);
  replace_with_lossless(named, std::move(maps.pictures), "mask");
  write_outputs(run, outputs, std::move(named), step);
  return Exit::done;
}

}  // namespace

Verb mask_verb() {
  OptionTable table("mask", "Draw which texels the charts use, and for what.");
  table.example("bust.obj --what chart -o charts.png", "charts in colours of their own");
  add_model_options(table);
  add_model_output_option(table);
  table.add(
      {.name = "what",
       .letter = 'w',
       .type = Option::Type::choice,
       .default_value = use_names().front(),
       .choices = use_names(),
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

// marquetry mask MESH [TEXTURE...] -o OUT --what W: which texels the charts use, and for what.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "mq/base/error.h"
#include "mq/base/words.h"
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
      {"overlap", TexelUse::overlap},
      {"depth", TexelUse::depth}};
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

bool in_colours(TexelUse use) {
  return use == TexelUse::chart || use == TexelUse::triangle || use == TexelUse::depth;
}

bool marks_few(TexelUse use) { return use == TexelUse::boundary || use == TexelUse::overlap; }

std::string why_nothing(TexelUse use) {
  switch (use) {
    case TexelUse::boundary: return "no chart has an end or a seam";
    case TexelUse::overlap:
      return "no texel's centre lies in two triangles; the verb check also lists what overlaps between centres";
    default: return "no triangle has an area both on the surface and in a texture";
  }
}

/// Says where marks are that are hard to find by eye: sparse ones by place, none at all as such.
void say_marks(Run& run, const TexelMaps& maps, TexelUse use) {
  run.result["texels"] = maps.marked;
  if (maps.marked == 0) run.terminal().remark("nothing is marked: " + why_nothing(use));
  if (!marks_few(use)) return;
  std::vector<Defect::Place> places = marked_places(maps);
  const std::int64_t count = std::ssize(places);
  places.resize(std::min<std::size_t>(places.size(), Defect::max_places));
  run.result["places"] = count;
  run.result["largest"] = places_json(places, run.texture_names());
  if (maps.marked == 0) return;
  run.terminal().remark(fmt::format("marked {} {}", counted(maps.marked, "texel"),
                                    places_text(places, count, run.texture_names())));
  std::int64_t all = 0;
  for (const Image<float>& picture : maps.pictures) all += std::int64_t(picture.width()) * picture.height();
  if (maps.marked < all / 1000 && run.options().integer("grow") == 0)
    run.terminal().remark(fmt::format("so few are hard to see: --grow {} draws them larger",
                                      std::max(2, maps.pictures.front().width() / 128)));
}

Exit mask(Run& run) {
  const OptionValues& options = run.options();
  const TexelUse use = asked_use(options);
  const int reach = int(options.integer("grow"));
  require(reach == 0 || !in_colours(use),
          "--grow: --what " + options.text("what") + " stands for numbers; it is for active, boundary "
                                                     "and overlap");
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
    maps = texel_maps(scene.surface, *scene.atlas, use, step);
    run.found(maps.defects);
    run.warn(maps.defects);
  });
  say_marks(run, maps, use);
  if (reach > 0) grow(maps, reach);
  const Step step(run, "write", 0.2);
  replace_with_lossless(named, std::move(maps.pictures), "mask");
  write_outputs(run, outputs, std::move(named), step);
  return Exit::done;
}

}  // namespace

Verb mask_verb() {
  OptionTable table("mask", "Draw which texels the charts use, and for what.");
  table.example("bust.obj --what chart -o charts.png", "charts in colours of their own");
  table.example("scan.obj --what overlap --grow 16 -o overlaps.png", "where charts lie on each other");
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
       .help = "active, boundary, chart, triangle, overlap or depth",
       .details =
           "active: white where a lookup on the surface reads the texel. boundary: those of "
           "them at seams and at the ends of charts. chart, triangle: a colour of its own for "
           "each chart, or for the triangle that covers the texel's centre; black is none. "
           "overlap: white where two triangles or more cover the centre. depth: how many do, as the "
           "stored value."});
  table.add({.name = "grow",
             .type = Option::Type::integer,
             .default_value = "0",
             .unit = "texels",
             .least = 0,
             .most = 4096,
             .group = "Mask",
             .help = "mark so much around what is marked too, so that single texels can be seen",
             .details = "For active, boundary and overlap."});
  add_frames_option(table);
  return {table, mask};
}

}  // namespace mq::app

#include "verbs/shared/captured_textures.h"

#include <fmt/format.h>

#include <optional>
#include <utility>

#include "verbs/shared/frame_textures.h"
#include "mq/base/error.h"
#include "mq/image/colour.h"
#include "mq/io/evolving_gltf.h"
#include "mq/io/file_names.h"
#include "mq/io/frame_files.h"
#include "mq/io/model.h"
#include "mq/model/captured_textures.h"
#include "mq/model/stored_frames.h"
#include "shell/results.h"

namespace mq::app {
namespace {

constexpr int most_side = 16384;

void require_atlas_unless_models(const EvolvingReader& reader, const std::string& to) {
  require(has_atlas(reader) || (names_model(to) && !names_animation(to)),
          fmt::format("{}: it has no texture coordinates: give it some with the verb unwrap, or "
                      "export models (frame_%04d.ply), which get colours at vertices",
                      reader.manifest().string()));
}

/// The side of the textures that an atlas was made for, if its maker said so.
std::optional<int> packed_side(const EvolvingReader& reader) {
  const Json about = Json::parse(reader.about(), nullptr, false);
  const Json::json_pointer place("/options/size");
  if (about.is_discarded() || !about.contains(place) || !about[place].is_number_integer())
    return {};
  const auto side = about[place].get<std::int64_t>();
  if (side < 1 || side > most_side) return {};
  return int(side);
}

int texture_side(const OptionValues& options, const EvolvingReader& reader) {
  if (options.has("size")) return int(options.integer("size"));
  return packed_side(reader).value_or(CapturedTextureOptions().side);
}

/// The captured frames that --from names, as what they show is wanted.
CapturedTextures captured_textures(Run& run, const EvolvingReader& reader,
                                   const std::vector<int>& frames) {
  const OptionValues& options = run.options();
  CapturedTextureOptions how{.side = texture_side(options, reader),
                             .samples = int(options.integer("samples")),
                             .words = {.sequence = "--from", .steps = "--stitch"}};
  if (options.flag("stitch")) how.steps = CapturedTextureOptions::Steps::taken_out;
  if (options.has("texture")) how.textures = options.text("texture");
  if (const auto made_for = packed_side(reader); made_for && how.side < *made_for)
    run.terminal().warning(
        fmt::format("--size: {} texels, and the atlas was made for {}: its gutters are narrower "
                    "here, and charts may touch",
                    how.side, *made_for));
  return {reader, options.text("from"), frames, std::move(how), run.terminal()};
}

Json steps_json(const BorderJump& jump) {
  return {{"across", jump.across}, {"within", jump.within}};
}

/// How much of a texture was seen.
Json texture_json(const CapturedTextures::Textured& shown) {
  const TextureFrame& texture = shown.texture;
  Json found = {{"frame", shown.number},
                {"texels", texture.texels},
                {"unseen", texture.unseen},
                {"filled", texture.filled},
                {"accuracy", texture.accuracy}};
  if (shown.steps_were_taken_out)
    found["steps"] = {{"before", steps_json(texture.before)}, {"after", steps_json(texture.after)}};
  return found;
}

Json vertices_json(const CapturedTextures::Coloured& shown) {
  return {{"frame", shown.number},
          {"vertices", shown.model.mesh.vertex_count()},
          {"unseen", shown.unseen},
          {"accuracy", shown.accuracy}};
}

/// As files want it; of what must stay.
FrameTextures::Frame as_frame(const CapturedTextures::Textured& shown) {
  return {.number = shown.number,
          .mesh = shown.mesh,
          .inside = shown.texture.inside,
          .pixels = shown.texture.picture,
          .values = shown.is_light ? FrameTextures::Values::light : FrameTextures::Values::display,
          .depth = shown.depth};
}

/// As a display is given it.
Image<float> displayed(const CapturedTextures::Textured& shown) {
  const Image<float>& picture = shown.texture.picture;
  return shown.is_light ? encode(picture, ColourSpace::linear, TransferFunction::srgb) : picture;
}

}  // namespace

void add_captured_texture_options(OptionTable& table) {
  using Type = Option::Type;
  const std::string group = "Textures";
  table.add({.name = "from",
             .type = Type::path,
             .metavar = "SEQUENCE",
             .group = group,
             .help = "the captured frames: what they show is written as textures",
             .details = "frame_%04d.ply, or a folder, with the numbers of the evolving mesh's "
                        "frames. Without an atlas (unwrap, evolve) models get colours at "
                        "vertices, and nothing else can be written."});
  table.add({.name = "texture",
             .type = Type::path,
             .group = group,
             .help = "pictures instead of those the captured frames name, %04d for the number"});
  table.add({.name = "size",
             .letter = 's',
             .type = Type::integer,
             .unit = "texels",
             .least = 1,
             .most = most_side,
             .group = group,
             .help = "side of the textures; without it that the atlas was made for",
             .details = "In smaller ones gutters are narrower, and charts may touch."});
  table.add({.name = "samples",
             .type = Type::integer,
             .default_value = std::to_string(CapturedTextureOptions().samples),
             .least = 1,
             .most = 8,
             .group = group,
             .help = "per texel and direction"});
  table.add({.name = "stitch",
             .type = Type::flag,
             .group = group,
             .help = "take out steps where texels come from different captured charts",
             .details = "Gradients inside of charts are kept, as the verb stitch does."});
}

std::vector<std::filesystem::path> captured_paths(const OptionValues& options,
                                                  const EvolvingReader& reader,
                                                  const std::vector<int>& numbers) {
  const std::string output = options.text("output");
  find_frames(options.text("from"), numbers);  // refused now where one is missing
  require(has_atlas(reader) || !options.flag("stitch"),
          fmt::format("--stitch: it is of textures, and {} has no texture coordinates",
                      reader.manifest().string()));
  if (!names_animation(output)) {
    const FrameTextures files(output);
    if (has_atlas(reader)) return files.paths(numbers);
  }
  require_atlas_unless_models(reader, output);
  if (names_animation(output)) return {output};
  std::vector<std::filesystem::path> paths;
  for (const int number : numbers) paths.emplace_back(frame_name(output, number));
  return paths;
}

void write_captured_textures(Run& run, const EvolvingReader& reader, const std::vector<int>& frames,
                             const std::string& to) {
  const OptionValues& options = run.options();
  require_atlas_unless_models(reader, to);
  if (names_video(to)) {
    require_video_options(to, video_options(options));
    const int side = texture_side(options, reader);
    require_whole_video(to, side, side);
  }
  const Step step(run, "textures", 0.9);
  CapturedTextures captured = captured_textures(run, reader, frames);
  for (const std::filesystem::path& path : captured.paths()) run.will_read(path);
  Json& found = run.result["textures"] = Json::array();
  if (names_animation(to)) {
    const Progress all = step.progress().step("write", 1);
    write_animation(
        to, reader, frames.front(), frames.back(), options.number("rate"),
        [&](int frame) {
          const CapturedTextures::Textured shown = captured.texture(frame);
          found.push_back(texture_json(shown));
          return displayed(shown);
        },
        all);
    run.found(captured.defects());
    return;
  }
  std::optional<FrameTextures> files;
  if (has_atlas(reader)) files.emplace(to);
  for (const int f : frames) {
    const int number = reader.frames()[f].number;
    const Progress part =
        step.progress().step(fmt::format("frame {}", number), 1.0 / double(frames.size()));
    if (files) {
      const CapturedTextures::Textured shown = captured.texture(f, part);
      found.push_back(texture_json(shown));
      for (const std::string& note :
           files->write(as_frame(shown), video_options(options), run.progress()))
        run.terminal().remark(note);
    } else {
      const CapturedTextures::Coloured shown = captured.at_vertices(f);
      found.push_back(vertices_json(shown));
      write_model(frame_name(to, number), shown.model);
    }
  }
  if (files) files->finish();
  run.found(captured.defects());
}

}  // namespace mq::app

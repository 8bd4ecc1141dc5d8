#include "captured_textures.h"

#include <fmt/format.h>

#include "evolving_frames.h"
#include "frame_textures.h"
#include "mq/base/error.h"
#include "mq/io/frame_files.h"
#include "mq/io/model.h"
#include "mq/io/vertex_colours.h"
#include "mq/sequence/texture_frame.h"

namespace mq::app {

void add_captured_texture_options(OptionTable& table) {
  using Type = Option::Type;
  const std::string group = "Textures";
  table.add({.name = "from",
             .type = Type::path,
             .metavar = "SEQUENCE",
             .group = group,
             .help = "the captured frames: what they show is written as textures",
             .details = "frame_%04d.ply, or a folder, with the numbers of the evolving mesh's "
                        "frames. The evolving mesh must have an atlas (unwrap, evolve)."});
  table.add({.name = "texture",
             .type = Type::path,
             .group = group,
             .help = "pictures instead of those the captured frames name, %04d for the number"});
  table.add({.name = "size",
             .letter = 's',
             .type = Type::integer,
             .default_value = "1024",
             .unit = "texels",
             .least = 1,
             .most = 16384,
             .group = group,
             .help = "side of the textures"});
  table.add({.name = "samples",
             .type = Type::integer,
             .default_value = "2",
             .least = 1,
             .most = 8,
             .group = group,
             .help = "per texel and direction"});
}

void write_captured_textures(Run& run, const EvolvingReader& reader,
                             const std::vector<int>& frames, const std::string& to) {
  const OptionValues& options = run.options();
  FrameTextures output(to);
  const std::vector<int> numbers = numbers_of(reader, frames);
  const std::vector<FrameFile> files = find_frames(options.text("from"), numbers);
  for (const FrameFile& file : files) run.will_read(file.path);
  const int size = int(options.integer("size"));
  const TextureFrameOptions how{
      .width = size, .height = size, .samples = int(options.integer("samples"))};
  const Step step(run, "textures", 0.9);
  run.result["textures"] = Json::array();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const Progress part =
        step.progress().step(fmt::format("frame {}", numbers[i]), 1.0 / double(frames.size()));
    const EvolvingSegment segment = reader.segment(reader.frames()[frames[i]].segment);
    require(!segment.uvs.empty(),
            fmt::format("{}: it has no texture coordinates: give it some with the verb unwrap",
                        reader.manifest().string()));
    ReadModelOptions reading;
    if (options.has("texture"))
      reading.textures = {frame_name(options.text("texture"), numbers[i])};
    const Model captured = read_model(files[i].path, reading);
    require(has_colours(captured),
            fmt::format("{}: --from wants colours at vertices or a texture, and it has neither",
                        files[i].path.string()));
    const Mesh mesh = mesh_of(segment, reader.positions(frames[i]));
    const TextureFrame frame =
        resample_texture(mesh, captured.mesh, surface_colours(captured), how, part);
    run.result["textures"].push_back(
        {{"frame", numbers[i]}, {"texels", frame.texels}, {"unseen", frame.unseen}});
    const bool light = captured.colors.channels == 0 && holds_light(captured.textures[0].format);
    output.write({.number = numbers[i],
                  .mesh = mesh,
                  .inside = frame.inside,
                  .pixels = frame.picture,
                  .values = light ? FrameTextures::Values::light : FrameTextures::Values::display},
                 options.number("rate"));
  }
  output.finish();
}

}  // namespace mq::app

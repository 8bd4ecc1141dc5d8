#include "captured_textures.h"

#include <fmt/format.h>

#include <map>
#include <optional>
#include <set>

#include "evolving_frames.h"
#include "frame_textures.h"
#include "mq/atlas/atlas.h"
#include "mq/base/error.h"
#include "mq/image/colour.h"
#include "mq/io/evolving_gltf.h"
#include "mq/io/file_names.h"
#include "mq/io/frame_files.h"
#include "mq/io/model.h"
#include "mq/io/vertex_colours.h"
#include "mq/mesh/orient.h"
#include "mq/mesh/surface.h"
#include "mq/video/texture_frame.h"
#include "shell/results.h"

namespace mq::app {
namespace {

constexpr int most_side = 16384;
constexpr int usual_side = 1024;  ///< where nobody says what the atlas was made for

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
  return packed_side(reader).value_or(usual_side);
}

/// The captured frames, and what a store's frames show of them.
class Captured {
 public:
  Captured(Run& run, const EvolvingReader& reader, const std::vector<int>& frames)
      : run_(run), reader_(reader), side_(texture_side(run.options(), reader)) {
    if (const auto made_for = packed_side(reader); made_for && side_ < *made_for)
      run.terminal().warning(
          fmt::format("--size: {} texels, and the atlas was made for {}: its gutters are narrower "
                      "here, and charts may touch",
                      side_, *made_for));
    const std::vector<FrameFile> files =
        find_frames(run.options().text("from"), numbers_of(reader, frames));
    for (std::size_t i = 0; i < files.size(); ++i) {
      run.will_read(files[i].path);
      files_[frames[i]] = files[i].path;
    }
    run.result["textures"] = Json::array();
  }

  /// The texture of a frame; says in the result how much of it was seen.
  const TextureFrame& texture(int frame, const Progress& progress = {}) {
    const OptionValues& options = run_.options();
    read(frame);
    TextureFrameOptions how{
        .width = side_, .height = side_, .samples = int(options.integer("samples"))};
    if (options.flag("stitch")) how.captured_charts = captured_charts(frame);
    texture_ = resample_texture(mesh_, model_.mesh, surface_colours(model_), how, progress);
    Json found = {{"frame", reader_.frames()[frame].number},
                  {"texels", texture_.texels},
                  {"unseen", texture_.unseen},
                  {"filled", texture_.filled},
                  {"accuracy", texture_.accuracy}};
    if (!how.captured_charts.empty())
      found["steps"] = {{"before", steps_json(texture_.before)},
                        {"after", steps_json(texture_.after)}};
    run_.result["textures"].push_back(std::move(found));
    return texture_;
  }

  /// The same as files want it; valid until the next is asked for.
  FrameTextures::Frame frame(int frame, const Progress& progress) {
    texture(frame, progress);
    return {.number = reader_.frames()[frame].number,
            .mesh = mesh_,
            .inside = texture_.inside,
            .pixels = texture_.picture,
            .values = is_light() ? FrameTextures::Values::light : FrameTextures::Values::display,
            .depth = depth()};
  }

  /// The same as display values.
  Image<float> displayed(int frame) {
    const Image<float>& picture = texture(frame).picture;
    return is_light() ? encode(picture, ColourSpace::linear, TransferFunction::srgb) : picture;
  }

  /// The mesh of a frame with what its vertices show.
  Model at_vertices(int frame) {
    read(frame);
    const VertexColours found = resample_vertices(mesh_, model_.mesh, surface_colours(model_));
    run_.result["textures"].push_back({{"frame", reader_.frames()[frame].number},
                                       {"vertices", mesh_.vertex_count()},
                                       {"unseen", found.unseen},
                                       {"accuracy", found.accuracy}});
    Model shown;
    shown.colors.channels = 3;
    for (Eigen::Index v = 0; v < found.colours.rows(); ++v)
      for (int k = 0; k < 3; ++k) shown.colors.values.push_back(float(found.colours(v, k)));
    shown.mesh = mesh_;
    return shown;
  }

 private:
  bool is_light() const {
    return model_.colors.channels == 0 && holds_light(model_.textures[0].format);
  }

  /// As deep as what colours are taken from.
  Depth depth() const {
    Depth deepest = Depth::u8;
    if (model_.colors.channels == 0)
      for (const Texture& texture : model_.textures)
        deepest = std::max(deepest, texture.format.depth);
    return deepest;
  }

  static Json steps_json(const BorderJump& jump) {
    return {{"across", jump.across}, {"within", jump.within}};
  }

  /// Charts of the captured triangles.
  std::vector<int> captured_charts(int frame) const {
    require(!model_.textures.empty() && model_.mesh.has_uvs(),
            fmt::format("{}: --stitch takes out steps between charts, and it has none",
                        files_.at(frame).string()));
    std::vector<TextureSize> sizes;
    for (const Texture& texture : model_.textures)
      sizes.push_back({.width = texture.pixels.width(), .height = texture.pixels.height()});
    return make_atlas(make_surface(model_.mesh), sizes).chart;
  }

  void read(int frame) {
    const OptionValues& options = run_.options();
    ReadModelOptions reading;
    if (options.has("texture"))
      reading.textures = {frame_name(options.text("texture"), reader_.frames()[frame].number)};
    const std::filesystem::path& path = files_.at(frame);
    model_ = read_model(path, reading);
    require(has_colours(model_),
            fmt::format("{}: --from wants colours at vertices or a texture, and it has neither",
                        path.string()));
    mesh_ = mesh_of(reader_.segment(reader_.frames()[frame].segment), reader_.positions(frame));
    turn_back(path);
  }

  /// As track does: what is seen from one side is only found by what faces the same way.
  void turn_back(const std::filesystem::path& path) {
    Oriented found = oriented_like(model_.mesh, mesh_);
    model_.mesh = std::move(found.mesh);
    std::erase_if(found.defects, [&](const Defect& one) { return !said_.insert(one.kind).second; });
    for (Defect& defect : found.defects)
      defect.message = fmt::format("{}: {}", path.string(), defect.message);
    run_.found(found.defects);
    run_.warn(found.defects);
  }

  Run& run_;
  const EvolvingReader& reader_;
  int side_;
  std::map<int, std::filesystem::path> files_;
  Model model_;
  Mesh mesh_;
  TextureFrame texture_;
  std::set<std::string> said_;  ///< kinds of defects
};

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
             .default_value = "2",
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
  Captured captured(run, reader, frames);
  if (names_animation(to)) {
    const Progress all = step.progress().step("write", 1);
    write_animation(
        to, reader, frames.front(), frames.back(), options.number("rate"),
        [&](int frame) { return captured.displayed(frame); }, all);
    return;
  }
  std::optional<FrameTextures> files;
  if (has_atlas(reader)) files.emplace(to);
  for (const int f : frames) {
    const int number = reader.frames()[f].number;
    const Progress part =
        step.progress().step(fmt::format("frame {}", number), 1.0 / double(frames.size()));
    if (files)
      for (const std::string& note :
           files->write(captured.frame(f, part), video_options(options), run.progress()))
        run.terminal().remark(note);
    else
      write_model(frame_name(to, number), captured.at_vertices(f));
  }
  if (files) files->finish();
}

}  // namespace mq::app

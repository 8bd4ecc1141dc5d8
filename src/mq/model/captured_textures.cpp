#include "mq/model/captured_textures.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "mq/atlas/atlas.h"
#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/base/words.h"
#include "mq/io/frame_files.h"
#include "mq/io/vertex_colours.h"
#include "mq/mesh/facing_points.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/orient.h"
#include "mq/mesh/surface.h"
#include "mq/model/stored_frames.h"

namespace mq {
namespace {

namespace fs = std::filesystem;

/// Whether what a model shows is light.
bool is_light(const Model& model) {
  return model.colors.channels == 0 && holds_light(model.textures[0].format);
}

/// As deep as what colours are taken from.
Depth depth_of(const Model& model) {
  Depth deepest = Depth::u8;
  if (model.colors.channels == 0)
    for (const Texture& texture : model.textures) deepest = std::max(deepest, texture.format.depth);
  return deepest;
}

}  // namespace

CapturedTextures::CapturedTextures(const EvolvingReader& reader, const std::string& sequence,
                                   const std::vector<int>& frames, CapturedTextureOptions options,
                                   Messages& messages)
    : reader_(reader), frames_(frames), options_(std::move(options)), messages_(messages) {
  const bool is_photographed = names_camera_frames(sequence);
  const std::vector<int> numbers = numbers_of(reader, frames);
  const std::vector<FrameFile> files =
      is_photographed ? find_camera_frames(sequence, numbers, options_.photographs.images)
                      : find_frames(sequence, numbers);
  if (is_photographed) {
    require_atlas(reader);
    require(options_.textures.empty(), fmt::format("{}: it is of captured meshes, and {} is photographs with cameras",
                                                   option_name("textures"), sequence));
    photographed_.emplace(options_.side, options_.photographs, messages);
  }
  for (std::size_t i = 0; i < files.size(); ++i) files_[frames[i]] = files[i].path;
}

CapturedTextures::Textured CapturedTextures::photographed(int frame, const Progress& progress) {
  const StoredFrame& stored = reader_.frames()[std::size_t(frame)];
  const fs::path& path = files_.at(frame);
  Textured result;
  result.number = stored.number;
  result.mesh = mesh_of(reader_.segment(stored.segment), reader_.positions(frame));
  const std::vector<Photograph> photographs =
      photographs_of_frame({stored.number, path}, photographed_->options());
  result.texture = photographed_->texture(fmt::format("frame {} by {}", stored.number, path.string()), result.mesh,
                                          photographs, progress);
  result.changed = photographed_->changed();
  return result;
}

CapturedTextures::Textured CapturedTextures::texture(int frame, const Progress& progress) {
  if (photographed_) return photographed(frame, progress);
  Captured captured = read(frame);
  TextureFrameOptions how{
      .width = options_.side, .height = options_.side, .samples = options_.samples};
  if (options_.steps == CapturedTextureOptions::Steps::taken_out)
    how.captured_charts = captured_charts(frame, captured.model);
  Textured result;
  result.number = reader_.frames()[std::size_t(frame)].number;
  result.texture = resample_texture(captured.mesh, captured.model.mesh,
                                    surface_colours(captured.model), how, progress);
  require_near(frame, captured, result.texture.accuracy);
  result.is_light = is_light(captured.model);
  result.depth = depth_of(captured.model);
  result.steps_were_taken_out = !how.captured_charts.empty();
  result.mesh = std::move(captured.mesh);
  return result;
}

CapturedTextures::Coloured CapturedTextures::at_vertices(int frame) {
  Captured captured = read(frame);
  const VertexColours found =
      resample_vertices(captured.mesh, captured.model.mesh, surface_colours(captured.model));
  require_near(frame, captured, found.accuracy);
  Coloured result;
  result.number = reader_.frames()[std::size_t(frame)].number;
  result.unseen = found.unseen;
  result.accuracy = found.accuracy;
  result.model.colors.channels = 3;
  for (Eigen::Index v = 0; v < found.colours.rows(); ++v)
    for (int k = 0; k < 3; ++k) result.model.colors.values.push_back(float(found.colours(v, k)));
  result.model.mesh = std::move(captured.mesh);
  return result;
}

CapturedTextures::Captured CapturedTextures::read(int frame) {
  const StoredFrame& stored = reader_.frames()[std::size_t(frame)];
  ReadModelOptions reading;
  if (!options_.textures.empty()) reading.textures = {frame_name(options_.textures, stored.number)};
  const fs::path& path = files_.at(frame);
  Captured captured;
  captured.model = read_model(path, reading);
  require(captured.model.mesh.triangle_count() > 0,
          fmt::format("{}: frame {} has no triangles, so it shows nothing: leave it out, {} names the others",
                      path.string(), stored.number, option_name("frames")));
  require(has_colours(captured.model),
          fmt::format("{}: {} wants colours at vertices or a texture, and it has neither",
                      path.string(), option_name("sequence")));
  captured.mesh = mesh_of(reader_.segment(stored.segment), reader_.positions(frame));
  turn_back(path, captured);
  return captured;
}

/// As tracking does: what is seen from one side is only found by what faces the same way.
void CapturedTextures::turn_back(const fs::path& path, Captured& captured) {
  Oriented found = oriented_like(captured.model.mesh, captured.mesh);
  captured.model.mesh = std::move(found.mesh);
  for (Defect& defect : found.defects) {
    if (!said_.insert(defect.kind).second) continue;
    if (defect.severity == Defect::Severity::warning)
      messages_.warning(path.string() + ": " + short_sentence(defect));
    defect.message = fmt::format("{}: {}", path.string(), defect.message);
    defects_.push_back(std::move(defect));
  }
}

/// The store may have been made of another sequence.
void CapturedTextures::require_near(int frame, const Captured& captured, double accuracy) const {
  const double most = FacingPointsOptions().most_distance;
  require(accuracy < 0.999 * most * bounding_box(captured.model.mesh).diagonal(),
          fmt::format(
              "{}: half of the vertices that {} has for it are farther off than {:g} % of its "
              "diagonal, or face away: it was made of something else; check {} and the numbers of "
              "its frames",
              files_.at(frame).string(), reader_.manifest().string(), 100 * most,
              option_name("sequence")));
}

/// Charts of the captured triangles.
std::vector<int> CapturedTextures::captured_charts(int frame, const Model& model) const {
  require(!model.textures.empty() && model.mesh.has_uvs(),
          fmt::format("{}: {} takes out steps between charts, and it has none",
                      files_.at(frame).string(), option_name("steps")));
  std::vector<TextureSize> sizes;
  for (const Texture& texture : model.textures)
    sizes.push_back({.width = texture.pixels.width(), .height = texture.pixels.height()});
  return make_atlas(make_surface(model.mesh), sizes).chart;
}

}  // namespace mq

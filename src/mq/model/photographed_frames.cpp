#include "mq/model/photographed_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <utility>

#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/fem/multigrid_solver.h"
#include "mq/image/spread.h"
#include "mq/io/path_status.h"
#include "mq/model/model_signal.h"
#include "mq/model/textured_model.h"
#include "mq/video/texel_owners.h"

namespace mq {
namespace {

namespace fs = std::filesystem;

/// The mesh with a black picture.
TexturedModel black_model(const std::string& name, const Mesh& mesh, int width, Messages& messages) {
  Model model;
  model.path = name;
  model.mesh = mesh;
  Texture& texture = model.textures.emplace_back();
  texture.name = "texture.png";
  texture.format.file_format = "png";
  texture.pixels = Image<float>(width, width, 3);
  TexturedModel scene =
      textured_model(std::move(model), {.weld = {.kind = WeldOptions::Kind::none}}, messages);
  require_usable(scene.defects(), name);
  return scene;
}

/// Texels whose square a triangle touches, at one of `samples`² places of it.
Image<char> touched_texels(const Mesh& mesh, int width, int samples) {
  const TexelOwners owners(mesh, width, width, samples);
  Image<char> inside(width, width, 1);
  for (int row = 0; row < width * samples; ++row)
    for (int column = 0; column < width * samples; ++column)
      if (owners.owner(column, row).triangle >= 0 && owners.owner(column, row).distance == 0)
        inside(column / samples, row / samples) = 1;
  return inside;
}

/// The picture with what lies outside charts given the nearest colour, and what is to be known of it.
TextureFrame as_frame(const TexturedModel& scene, const Texels& texels, std::span<const int> labels) {
  TextureFrame frame;
  frame.picture = scene.model.textures[0].pixels;
  const int width = frame.picture.width();
  frame.inside = touched_texels(scene.model.mesh, width, TextureFrameOptions().samples);
  frame.texels = std::ranges::count(frame.inside.values(), 1);
  Image<char> known(width, width, 1);
  for (int k = 0; k < texels.size(); ++k) {
    const Texels::Place& at = texels.places[std::size_t(k)];
    known(at.x, at.y) = 1;
    frame.unseen += labels[std::size_t(k)] == unseen && frame.inside(at.x, at.y);
  }
  frame.filled = frame.unseen;
  spread(known, std::numeric_limits<double>::infinity(), frame.picture);
  return frame;
}

}  // namespace

bool names_camera_frames(const std::string& name) {
  return names_cameras(name) || (has_frame_place(name) && !fs::path(name).has_extension());
}

std::vector<FrameFile> find_camera_frames(const std::string& name, const std::vector<int>& numbers,
                                          const std::vector<std::string>& images) {
  require(numbers.size() < 2 || has_frame_place(name) || std::ranges::any_of(images, has_frame_place),
          fmt::format("{}: its photographs would be those of each of {} frames: {} says where those of each frame are, "
                      "with a place for the number, such as shots/%04d",
                      name, numbers.size(), option_name("images")));
  std::vector<FrameFile> files;
  for (const int number : numbers) {
    fs::path path = has_frame_place(name) ? frame_name(name, number) : name;
    if (!is_there(path))
      throw IoError(fmt::format("{}: the cameras of frame {} are not there", path.string(), number));
    files.push_back({number, std::move(path)});
  }
  return files;
}

std::vector<Photograph> photographs_of_frame(const FrameFile& frame, const PhotographedOptions& options) {
  CamerasOptions where;
  for (const std::string& folder : options.images)
    where.images.emplace_back(has_frame_place(folder) ? frame_name(folder, frame.number) : folder);
  std::vector<Photograph> photographs = read_camera_set(frame.path, where).photographs;
  if (photographs.empty()) throw IoError(frame.path.string() + ": it names no photograph");
  return photographs;
}

PhotographedFrames::PhotographedFrames(int width, PhotographedOptions options, Messages& messages)
    : side_(width), options_(std::move(options)), messages_(messages), labels_(width, width, 1) {}

TextureFrame PhotographedFrames::texture(const std::string& name, const Mesh& mesh,
                                         std::span<const Photograph> photographs, const Progress& progress) {
  TexturedModel scene = black_model(name, mesh, side_, messages_);
  const TextureSignal target(scene, {}, messages_, progress.step("assemble", 0.15));
  const Texels& texels = target.space().texels();
  PhotographTextureOptions how = options_.texture;
  how.before = kept(texels, photographs.size());
  const PhotographTexturing work(scene, target, photographs, how, messages_, progress.step("look", 0.4));
  const PhotographTexture found = work.make({}, progress.step("take", 0.2));
  require(std::ranges::any_of(found.labels, [](int label) { return label != unseen; }),
          name + ": no photograph shows any of it: are its cameras in the same units and coordinates?");
  const double weight = weight_from_length(usual_photograph_length, target.scale());
  const Stitcher stitcher(target.space(), weight, found.regions, target.space().multigrid(), {},
                          Stitcher::Systems::one_each);
  const Filtered stitched =
      stitcher.stitch(found.values, found.beyond, found.offset, progress.step("solve", 0.2));
  target.put(target.values(), stitched.signal, scene.model);
  keep(texels, found.labels, photographs.size());
  return as_frame(scene, texels, found.labels);
}

/// Per texel the photograph that it came from in the frame before; none where that had others.
std::vector<int> PhotographedFrames::kept(const Texels& texels, std::size_t photographs) const {
  std::vector<int> before;
  if (photographs_ != photographs) return before;
  for (const Texels::Place& at : texels.places) before.push_back(labels_(at.x, at.y));
  return before;
}

void PhotographedFrames::keep(const Texels& texels, std::span<const int> labels, std::size_t photographs) {
  std::int64_t both = 0, other = 0;
  Image<int> now(side_, side_, 1);
  std::ranges::fill(now.values(), unseen);
  for (int k = 0; k < texels.size(); ++k) {
    const Texels::Place& at = texels.places[std::size_t(k)];
    const int label = now(at.x, at.y) = labels[std::size_t(k)], before = labels_(at.x, at.y);
    if (photographs_ != photographs || label == unseen || before == unseen) continue;
    ++both;
    other += label != before;
  }
  changed_ = both > 0 ? double(other) / double(both) : 0;
  labels_ = std::move(now);
  photographs_ = photographs;
}

}  // namespace mq

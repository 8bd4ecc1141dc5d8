#include "mq/io/animation.h"

#include <fmt/format.h>

#include <cmath>

#include "mq/base/error.h"
#include "mq/io/atomic_file.h"
#include "mq/io/detail/animation_glb.h"
#include "mq/io/detail/animation_usd.h"
#include "mq/io/detail/gltf_compress.h"
#include "mq/io/detail/stored_zip.h"
#include "mq/io/file_names.h"
#include "mq/io/image_file.h"

namespace mq {
namespace {

namespace fs = std::filesystem;

void check(const EvolvingReader& reader, const AnimationPart& part) {
  const int count = int(reader.frames().size());
  require(part.first >= 0 && part.first <= part.last && part.last < count,
          fmt::format("frames {} to {} were asked for of {}", part.first, part.last, count));
  require(part.frames_per_second > 0 && std::isfinite(part.frames_per_second),
          fmt::format("{} frames a second were asked for", part.frames_per_second));
}

Bytes png_of(Image<float> pixels) {
  Texture texture;
  texture.pixels = std::move(pixels);
  return texture_bytes(texture, "png").bytes;
}

/// "walk_1.png": of the segment that is the second shown.
std::string picture_name(const fs::path& path, std::size_t segment) {
  return fmt::format("{}_{}.png", path.stem().string(), segment);
}

/// The text of USD, and the pictures that it names.
std::vector<OutputFile> usd_files(const fs::path& path, const EvolvingReader& reader, const AnimationPart& part,
                                  const PictureOfFrame& pictures, const Progress& progress) {
  const std::vector<FrameRange> segments = ranges_of_segments(reader, part);
  std::vector<std::string> names;
  std::vector<OutputFile> files(1);  // what names the others is the first
  const Progress painting = progress.step("pictures", 0.5);
  for (std::size_t s = 0; pictures && s < segments.size(); ++s) {
    Image<float> picture = pictures(segments[s].begin);
    names.push_back(picture.values().empty() ? "" : picture_name(path, s));
    if (!names.back().empty()) files.push_back({names.back(), png_of(std::move(picture))});
    painting.at(double(s + 1) / double(segments.size()));
  }
  files[0] = {path.stem().string() + ".usda",
              to_bytes(animation_usda(reader, part, names, progress.step("text", 0.5)))};
  return files;
}

}  // namespace

std::vector<FrameRange> ranges_of_segments(const EvolvingReader& reader, const AnimationPart& part) {
  std::vector<FrameRange> ranges;
  for (int f = part.first; f <= part.last; ++f) {
    const int segment = reader.frames()[std::size_t(f)].segment;
    if (ranges.empty() || reader.frames()[std::size_t(ranges.back().begin)].segment != segment)
      ranges.push_back({f, f});
    ranges.back().end = f + 1;
  }
  return ranges;
}

std::vector<fs::path> animation_files(const fs::path& path, const EvolvingReader& reader, const AnimationPart& part,
                                      const std::function<bool(int frame)>& has_picture) {
  std::vector<fs::path> files{path};
  if (lower_extension(path) != ".usda") return files;
  const std::vector<FrameRange> segments = ranges_of_segments(reader, part);
  for (std::size_t s = 0; s < segments.size(); ++s)
    if (has_picture(segments[s].begin)) files.push_back(path.parent_path() / picture_name(path, s));
  return files;
}

void write_animation(const fs::path& path, const EvolvingReader& reader, const AnimationPart& part,
                     const PictureOfFrame& pictures, const Progress& progress) {
  check(reader, part);
  const std::string extension = lower_extension(path);
  require(names_animation(path),
          path.string() + ": found another extension, wanted .glb, .usda or .usdz for an animation");
  require(part.compression == Compression::none || (extension == ".glb" && part.compression == Compression::meshopt),
          path.string() + ": an animation is compressed by meshopt and as .glb, or not");
  if (extension == ".glb") {
    Bytes glb = animation_glb(reader, part, pictures, progress);
    if (part.compression != Compression::none)
      glb = compressed_glb(std::move(glb), path.filename().string(), part.compression);
    return write_file(path, glb);
  }
  std::vector<OutputFile> files = usd_files(path, reader, part, pictures, progress);
  if (extension == ".usdz") return write_file(path, stored_zip(files));
  // The file that names the others comes last.
  for (std::size_t i = files.size(); i-- > 1;) write_file(path.parent_path() / files[i].name, files[i].bytes);
  write_file(path, files[0].bytes);
}

}  // namespace mq

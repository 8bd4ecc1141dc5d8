#include "mq/io/animation_read.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <tuple>

#include "mq/base/error.h"
#include "mq/evolving/matched_ids.h"
#include "mq/image/colour.h"
#include "mq/io/detail/animation_found.h"
#include "mq/io/file_names.h"
#include "mq/io/image_file.h"
#include "mq/mesh/check.h"

namespace mq {
namespace {

namespace fs = std::filesystem;

class FoundSource : public EvolvingSource {
 public:
  explicit FoundSource(FoundAnimation found) : found_(std::move(found)) {}

  EvolvingSegment segment(int index) const override { return found_.segments.at(std::size_t(index)); }
  std::vector<Vector3> positions(int frame) const override { return found_.positions(frame); }

 private:
  FoundAnimation found_;
};

FoundAnimation find_animation(const fs::path& path) {
  Bytes bytes = read_file(path);
  if (bytes.empty()) throw IoError(path.string() + " is empty; check that it was written and copied whole");
  const std::string_view text = text_of(bytes);
  if (text.starts_with("PK\x03\x04")) return find_usdz_animation(path.string(), std::move(bytes));
  if (text.starts_with("#usda") || text.starts_with("PXR-USDC") || lower_extension(path).starts_with(".usd"))
    return find_usda_animation(path.string(), std::move(bytes));
  return find_gltf_animation(path.string(), std::move(bytes), path.parent_path());
}

/// Corners of a vertex with equal texture coordinates have one, however often a file has it.
void join_uvs(EvolvingSegment& segment) {
  std::map<std::tuple<int, double, double>, int> known;
  std::vector<Vector2> pool;
  for (std::size_t t = 0; t < segment.corner_uvs.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      int& uv = segment.corner_uvs[t][k];
      if (uv < 0) continue;
      const Vector2 at = segment.uvs[std::size_t(uv)];
      const auto [place, is_new] = known.try_emplace({segment.triangles[t][k], at.x(), at.y()}, int(pool.size()));
      if (is_new) pool.push_back(at);
      uv = place->second;
    }
  segment.uvs = std::move(pool);
}

/// The size of what moves. Throws where a frame has other vertices than its segment, or what cannot be used.
double size_of_frames(const FoundAnimation& found, const std::string& name, const Progress& progress) {
  Vector3 low = Vector3::Constant(largest_coordinate), high = -low;
  for (std::size_t f = 0; f < found.segment_of.size(); ++f) {
    const std::vector<Vector3> positions = found.positions(int(f));
    const int wanted = found.segments[std::size_t(found.segment_of[f])].vertex_count();
    if (std::ssize(positions) != wanted)
      throw IoError(
          fmt::format("{}, frame {}: found {} vertices, wanted {}, as many as the first frame of its mesh "
                      "has: {}",
                      name, found.numbers[f], positions.size(), wanted, frames_instead));
    for (const Vector3& p : positions) {
      if (!p.allFinite() || p.cwiseAbs().maxCoeff() > largest_coordinate)
        throw IoError(
            fmt::format("{}, frame {}: a vertex lies at {:.6g}, {:.6g}, {:.6g}, wanted at most {:.0e} from 0: "
                        "scale it down where it was made",
                        name, found.numbers[f], p.x(), p.y(), p.z(), largest_coordinate));
      low = low.cwiseMin(p), high = high.cwiseMax(p);
    }
    progress.at(double(f + 1) / double(found.segment_of.size()));
  }
  return (high - low).norm();
}

/// As a display is given it.
Image<float> displayed(const Texture& texture) {
  const bool is_light = texture.format.depth >= Depth::half;
  return is_light ? encode(texture.pixels, ColourSpace::linear, TransferFunction::srgb) : texture.pixels;
}

Image<float> animation_picture(const FoundPicture& picture, const fs::path& path,
                               std::vector<fs::path>& files, std::vector<std::string>& notes) {
  if (!picture.bytes.empty())
    return displayed(
        read_texture_bytes(picture.bytes, fmt::format("{}, the embedded picture {}", path.string(), picture.name)));
  if (picture.name.empty()) return {};
  const fs::path folder = path.parent_path();
  std::error_code ignored;  // names of other machines may lead anywhere
  if (fs::exists(folder / picture.name, ignored)) {
    files.push_back(folder / picture.name);
    return displayed(read_texture(files.back()));
  }
  const std::string note =
      fmt::format("its picture {} is not there, and is left out; put it there, or name others", shown(picture.name));
  if (std::ranges::count(notes, note) == 0) notes.push_back(note);
  return {};
}

}  // namespace

bool names_moving_file(const fs::path& path) {
  static constexpr const char* endings[] = {".usda", ".usdz", ".usd", ".usdc", ".glb", ".gltf"};
  return std::ranges::count(endings, lower_extension(path)) > 0;
}

OpenAnimation open_animation(const fs::path& path, const Progress& progress) {
  FoundAnimation found = find_animation(path);
  const std::string name = path.string();
  std::vector<StoredSegment> segments;
  for (EvolvingSegment& segment : found.segments) {
    if (segment.triangles.empty())
      throw IoError(name + ": a mesh of it has no faces but holes; wanted a surface: take that mesh out");
    join_uvs(segment);
    try {
      check(segment);
    } catch (const InvalidInput& error) {
      throw IoError(fmt::format("{}: {}", name, error.what()));
    }
    segments.push_back({{}, segment.vertex_count(), segment.triangle_count()});
  }
  match_ids(found.segments);
  const double size = size_of_frames(found, name, progress);
  if (!(size > 0))
    throw IoError(name + ": all its vertices are in one place; wanted a surface: look at its points and their scale");
  std::vector<StoredFrame> frames;
  for (std::size_t f = 0; f < found.numbers.size(); ++f)
    frames.push_back({{}, found.numbers[f], found.segment_of[f], {}});
  std::vector<std::string> notes = std::move(found.notes);
  std::vector<fs::path> files = std::move(found.files);
  std::vector<Image<float>> pictures;
  for (const FoundPicture& picture : found.pictures)
    pictures.push_back(animation_picture(picture, path, files, notes));
  std::vector<std::string> remarks = std::move(found.remarks);
  const double rate = found.frames_per_second, numbers_rate = found.numbers_per_second, unit = found.metres_per_unit;
  auto source = std::make_shared<FoundSource>(std::move(found));
  return {EvolvingReader(path, source, std::move(segments), std::move(frames), store_step(size), unit),
          rate,
          numbers_rate,
          std::move(pictures),
          std::move(files),
          std::move(notes),
          std::move(remarks)};
}

}  // namespace mq

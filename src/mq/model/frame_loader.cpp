#include "mq/model/frame_loader.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/base/words.h"
#include "mq/io/file_print.h"
#include "mq/io/path_status.h"

namespace mq {

namespace fs = std::filesystem;

std::vector<int> FrameLoader::missing_before(int) const { return {}; }

Mesh FrameLoader::material(int frame) const {
  throw InvalidInput(name(frame) + ": it is not known where its material is at rest");
}

std::string FrameLoader::material_name(int frame) const { return "the material of " + name(frame); }

std::vector<KnownFile> FrameLoader::files(int, const Model&) const { return {}; }

bool FrameLoader::is_changed(int, const std::vector<KnownFile>&) const { return false; }

int FrameLoader::index_of(int number_wanted) const {
  int low = 0, high = count();
  while (low < high) {
    const int middle = low + (high - low) / 2;
    if (number(middle) < number_wanted)
      low = middle + 1;
    else
      high = middle;
  }
  return low < count() && number(low) == number_wanted ? low : -1;
}

FileFrames::FileFrames(std::string sequence, FileFramesOptions options, Messages& messages)
    : sequence_(std::move(sequence)),
      options_(std::move(options)),
      files_(find_frames(sequence_, options_.numbers, options_.missing)) {
  if (!options_.material.empty()) {
    std::vector<int> numbers;
    for (const FrameFile& file : files_) numbers.push_back(file.number);
    materials_ = find_frames(options_.material, numbers);
  }
  if (options_.missing == MissingFrames::refused) require_textures();
  remark_gaps(messages);
  warn_of_missing(messages);
}

std::vector<int> FileFrames::missing_before(int frame) const {
  const std::vector<int>& wanted = options_.numbers;
  return {frame == 0 ? wanted.begin() : std::ranges::upper_bound(wanted, number(frame - 1)),
          frame == count() ? wanted.end() : std::ranges::lower_bound(wanted, number(frame))};
}

Model FileFrames::read_with(int frame, ReadModelOptions::Pictures pictures) const {
  ReadModelOptions how;
  if (!options_.textures.empty()) how.textures = {frame_name(options_.textures, number(frame))};
  how.pictures = pictures;
  return read_model(file(frame).path, how);
}

Model FileFrames::read(int frame) const { return read_with(frame, options_.pictures); }

Model FileFrames::with_pictures(int frame) const {
  return read_with(frame, ReadModelOptions::Pictures::read);
}

Mesh FileFrames::material(int frame) const {
  if (materials_.empty()) return FrameLoader::material(frame);
  return read_model(materials_[std::size_t(frame)].path).mesh;
}

std::string FileFrames::material_name(int frame) const {
  return materials_.empty() ? FrameLoader::material_name(frame)
                            : materials_[std::size_t(frame)].path.string();
}

std::vector<KnownFile> FileFrames::files(int frame, const Model& model) const {
  std::vector<KnownFile> files;
  for (const fs::path& path : files_of(model))
    files.push_back(
        {path.lexically_proximate(file(frame).path.parent_path()).string(), file_print(path)});
  return files;
}

bool FileFrames::is_changed(int frame, const std::vector<KnownFile>& known) const {
  const fs::path& own = file(frame).path;
  for (const KnownFile& one : known) {
    const fs::path path = &one == &known.front() ? own : own.parent_path() / one.name;
    try {
      if (file_print(path) != one.print) return true;
    } catch (const IoError&) {
      return true;
    }
  }
  return false;
}

std::vector<fs::path> FileFrames::paths() const {
  std::vector<fs::path> paths;
  for (int f = 0; f < count(); ++f) {
    paths.push_back(file(f).path);
    if (!options_.textures.empty()) paths.emplace_back(frame_name(options_.textures, number(f)));
    if (!materials_.empty()) paths.push_back(materials_[std::size_t(f)].path);
  }
  return paths;
}

void FileFrames::require_textures() const {
  if (options_.textures.empty()) return;
  for (const FrameFile& file : files_)
    if (const std::string name = frame_name(options_.textures, file.number); !is_there(name))
      throw IoError(
          fmt::format("{}: {} is not there, the picture of {}: check the name, or go without it",
                      option_name("textures"), name, file.path.string()));
}

/// Those that are wanted by their numbers are left out one by one.
void FileFrames::warn_of_missing(Messages& messages) const {
  const std::size_t wanted = options_.numbers.size();
  const std::size_t missing = wanted == 0 ? 0 : wanted - files_.size();
  for (int f = 0; f <= count() && missing > 0; ++f)
    if (const std::vector<int> numbers = missing_before(f); !numbers.empty()) {
      messages.warning(fmt::format("{}: {} of {} {} missing, the first is frame {}; {} left out",
                                   sequence_, missing, counted(std::int64_t(wanted), "frame"),
                                   missing == 1 ? "is" : "are", numbers.front(),
                                   missing == 1 ? "it is" : "they are"));
      return;
    }
}

void FileFrames::remark_gaps(Messages& messages) const {
  if (!options_.numbers.empty()) return;
  int shortest = std::numeric_limits<int>::max(), gaps = 0, first = -1;
  for (int f = 1; f < count(); ++f) shortest = std::min(shortest, number(f) - number(f - 1));
  for (int f = 1; f < count(); ++f)
    if (number(f) - number(f - 1) > shortest && gaps++ == 0) first = f;
  if (gaps > 0)
    messages.remark(fmt::format(
        "frames are missing in {}, the first between {} and {}; what moves far in between may be "
        "lost",
        counted(gaps, "place"), number(first - 1), number(first)));
}

MemoryFrames::MemoryFrames(std::vector<Frame> frames, std::string sequence)
    : frames_(std::move(frames)), sequence_(std::move(sequence)) {
  for (std::size_t f = 1; f < frames_.size(); ++f)
    require(frames_[f - 1].number < frames_[f].number,
            fmt::format("numbers of frames must increase, found {} after {}", frames_[f].number,
                        frames_[f - 1].number));
}

std::string MemoryFrames::name(int frame) const { return fmt::format("frame {}", number(frame)); }

Mesh MemoryFrames::material(int frame) const {
  const Frame& one = frames_[std::size_t(frame)];
  if (one.material.empty()) return FrameLoader::material(frame);
  return {one.material, one.model.mesh.triangles, {}, {}, {}};
}

}  // namespace mq

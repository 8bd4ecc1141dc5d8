#include "mq/io/frame_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <limits>
#include <map>
#include <regex>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/io/path_status.h"

namespace mq {
namespace {

namespace fs = std::filesystem;

const char* const place_pattern = "%(0?)([1-9]?)d";
constexpr int largest_number = std::numeric_limits<int>::max();
const char* const mesh_extensions[] = {".obj", ".ply", ".gltf", ".glb"};

std::string lower(std::string text) {
  for (char& c : text) c = char(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

bool is_mesh(const fs::path& path) {
  return std::ranges::count(mesh_extensions, lower(path.extension().string())) > 0;
}

/// The files of a folder by name; hidden ones are none.
std::vector<fs::path> files_of(const fs::path& folder) {
  std::error_code failure;
  std::vector<fs::path> files;
  for (fs::directory_iterator at(folder, failure), end; !failure && at != end;
       at.increment(failure))
    if (at->is_regular_file(failure) && !at->path().filename().string().starts_with('.'))
      files.push_back(at->path());
  if (failure)
    throw IoError(
        fmt::format("{}: the folder cannot be read: {}", folder.string(), failure.message()));
  std::ranges::sort(files);
  return files;
}

bool is_digit(unsigned char c) { return std::isdigit(c) != 0; }

/// The number that digits say; where it is too large for a frame's, says so.
int number_of(std::string_view digits, const fs::path& path) {
  int number = -1;
  const auto read = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (read.ec != std::errc())
    throw IoError(
        fmt::format("{}: its number {} is larger than {}, the largest a frame can have: rename the "
                    "files, or move it away if it is no frame",
                    path.string(), digits, largest_number));
  return number;
}

/// USD, Alembic and what else holds scenes in time.
bool names_scene(const fs::path& path) {
  static constexpr const char* scenes[] = {".usd", ".usda", ".usdc", ".usdz", ".abc", ".fbx", ".blend"};
  return std::ranges::count(scenes, lower(path.extension().string())) > 0;
}

/// A stem's last digits as a number and what stands before them; −1 where it has none.
struct Numbered {
  std::string before;
  int number = -1;
};
Numbered numbered(const fs::path& path) {
  const std::string stem = path.stem().string();
  const auto end = std::find_if(stem.rbegin(), stem.rend(), is_digit).base();
  const auto begin =
      std::find_if_not(std::make_reverse_iterator(end), stem.rend(), is_digit).base();
  Numbered result{std::string(stem.begin(), begin) + '#' + std::string(end, stem.end()), -1};
  if (begin != end) result.number = number_of({begin, end}, path);
  return result;
}

void add(std::map<int, fs::path>& frames, int number, const fs::path& path) {
  const auto [place, is_new] = frames.try_emplace(number, path);
  if (!is_new)
    throw IoError(fmt::format("{} and {} are both frame {}: remove one", place->second.string(),
                              path.string(), number));
}

std::map<int, fs::path> frames_in(const fs::path& folder) {
  std::map<int, fs::path> frames;
  std::string before, extension;
  for (const fs::path& path : files_of(folder)) {
    if (!is_mesh(path)) continue;
    const Numbered name = numbered(path);
    if (name.number < 0) continue;
    if (frames.empty()) {
      before = name.before;
      extension = lower(path.extension().string());
    }
    if (lower(path.extension().string()) != extension || name.before != before)
      throw IoError(fmt::format("{}: {} and {} are not of one sequence: name the files, such as {}",
                                folder.string(), frames.begin()->second.filename().string(),
                                path.filename().string(),
                                (folder / ("frame_%04d" + extension)).string()));
    add(frames, name.number, path);
  }
  if (frames.empty())
    throw IoError(
        fmt::format("{}: no frames in this folder, which would be meshes (.obj, .ply, "
                    ".gltf, .glb) with a number in their name",
                    folder.string()));
  return frames;
}

/// The files that are there and whose names are `name` with a number.
std::map<int, fs::path> frames_named(const fs::path& name) {
  const std::string file = name.filename().string();
  if (!has_frame_place(file))
    throw InvalidInput(
        fmt::format("{}: the place for the number belongs into the name of the "
                    "file, not of the folder",
                    name.string()));
  std::smatch place;
  std::regex_search(file, place, std::regex(place_pattern));
  const std::string before = place.prefix(), after = place.suffix();
  const fs::path folder = name.has_parent_path() ? name.parent_path() : fs::path(".");
  std::map<int, fs::path> frames;
  for (const fs::path& path : files_of(folder)) {
    const std::string found = path.filename().string();
    if (found.size() <= before.size() + after.size() || !found.starts_with(before) ||
        !found.ends_with(after))
      continue;
    const std::string_view digits =
        std::string_view(found).substr(before.size(), found.size() - before.size() - after.size());
    if (!std::ranges::all_of(digits, is_digit)) continue;
    const int number = number_of(digits, path);
    if (frame_name(file, number) == found)
      add(frames, number, name.has_parent_path() ? path : fs::path(found));
  }
  if (frames.empty())
    throw IoError(fmt::format("{}: no file is called so, such as {}", name.string(),
                              frame_name(name.string(), 1)));
  return frames;
}

}  // namespace

std::vector<int> parse_frames(const std::string& text) {
  std::smatch part;
  static const std::regex pattern("([0-9]{1,10})(?:-([0-9]{1,10})(?:x([1-9][0-9]{0,5}))?)?");
  if (!std::regex_match(text, part, pattern)) return {};
  const std::int64_t first = std::stoll(part[1]);
  const std::int64_t last = part[2].matched ? std::stoll(part[2]) : first;
  const std::int64_t step = part[3].matched ? std::stoll(part[3]) : 1;
  std::vector<int> frames;
  if (std::max(first, last) > largest_number || (last - first) / step >= 1'000'000) return {};
  for (std::int64_t frame = first; frame <= last; frame += step) frames.push_back(int(frame));
  return frames;
}

bool has_frame_place(const std::string& name) {
  const std::regex pattern(place_pattern);
  std::smatch place;
  if (!std::regex_search(name, place, pattern)) return false;
  const std::string after = place.suffix();
  require(!std::regex_search(after, pattern),
          fmt::format("{}: found two places for a frame's number, wanted one", name));
  return true;
}

std::string frame_name(const std::string& name, int frame) {
  std::smatch place;
  if (!std::regex_search(name, place, std::regex(place_pattern))) return name;
  const int width = place[2].length() ? std::stoi(place[2]) : 1;
  const std::string number =
      place[1].length() ? fmt::format("{:0{}}", frame, width) : fmt::format("{:{}}", frame, width);
  return place.prefix().str() + number + place.suffix().str();
}

std::vector<FrameFile> find_frames(const std::string& name, const std::vector<int>& numbers,
                                   MissingFrames where_missing) {
  const bool in_folder = is_folder(name);
  if (!in_folder && !has_frame_place(name)) {
    if (!is_there(name))
      throw IoError(fmt::format("{}: there is no such file or folder", name));
    require(!names_scene(name),
            fmt::format("{}: all frames in one file are not followed; write a file a frame first: marquetry export {} -o "
                        "frame_%04d.ply does so for .usda and .usdz, Blender for others (the documentation of evolve has "
                        "its command)",
                        name, name));
    throw InvalidInput(fmt::format(
        "{}: found one file, wanted a sequence: a folder, or a name with a place for the frame's "
        "number, such as frame_%04d.ply",
        name));
  }
  const std::map<int, fs::path> found = in_folder ? frames_in(name) : frames_named(name);
  std::vector<FrameFile> frames;
  std::vector<int> missing;
  for (const auto& [number, path] : found)
    if (numbers.empty()) frames.push_back({number, path});
  for (const int number : numbers) {
    const auto place = found.find(number);
    if (place == found.end())
      missing.push_back(number);
    else
      frames.push_back({number, place->second});
  }
  if (!missing.empty() && (where_missing == MissingFrames::refused || frames.empty()))
    throw IoError(
        fmt::format("{}: {} of {} missing, the first is frame {}; there are {}, from {} to {}",
                    name, missing.size(),
                    counted(std::ssize(numbers), "frame") + (numbers.size() == 1 ? " is" : " are"),
                    missing[0], found.size(), found.begin()->first, found.rbegin()->first));
  return frames;
}

}  // namespace mq

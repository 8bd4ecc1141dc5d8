#include "mq/io/detail/picture_finder.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "mq/base/error.h"
#include "mq/io/file_names.h"

namespace mq {
namespace {

namespace fs = std::filesystem;

bool is_there(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

/// Letters beyond ASCII as they are.
std::string small_letters(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
  return text;
}

/// A name without the extension of a picture, or of what pictures are developed from, if it has one:
/// "IMG.0001" keeps its end.
std::string stem_of(const std::string& name) {
  static constexpr const char* raw[] = {".heic", ".heif", ".dng", ".cr2", ".cr3",
                                        ".nef",  ".arw",  ".raf", ".orf", ".rw2"};
  const bool ends = names_picture(name) || std::ranges::count(raw, lower_extension(name)) > 0;
  return ends ? fs::path(name).stem().string() : name;
}

/// With '/' between folders, as programs on Windows do not write it.
fs::path portable(std::string name) {
  std::ranges::replace(name, '\\', '/');
  return fs::path(name).lexically_normal();
}

}  // namespace

PictureFinder::PictureFinder(std::vector<fs::path> folders) : folders_(std::move(folders)) {}

void PictureFinder::list_files() const {
  if (listed_) return;
  listed_ = true;
  std::vector<fs::path> seen;
  for (const fs::path& folder : folders_) {
    std::error_code error;
    const fs::path real = fs::weakly_canonical(folder, error);
    if (error || std::ranges::find(seen, real) != seen.end()) continue;
    seen.push_back(real);
    for (fs::directory_iterator at(folder.empty() ? "." : folder, error), end; !error && at != end;
         at.increment(error)) {
      const std::string file = at->path().filename().string();
      if (!names_picture(file) || !is_there(at->path())) continue;
      by_name_.emplace(small_letters(file), folder / file);
      by_stem_.emplace(small_letters(stem_of(file)), folder / file);
    }
  }
}

std::optional<fs::path> PictureFinder::unique(const Names& names, const std::string& key,
                                              const std::string& name,
                                              const std::string& where) const {
  std::vector<std::string> found;
  const auto [begin, end] = names.equal_range(key);
  for (auto at = begin; at != end; ++at) found.push_back(at->second.string());
  std::ranges::sort(found);
  if (found.size() > 1)
    throw IoError(fmt::format("{}: its picture {} may be {}: rename them, or give the folder with the "
                              "right ones alone",
                              where, name, fmt::join(found, " or ")));
  return found.empty() ? std::nullopt : std::optional<fs::path>(found.front());
}

std::optional<fs::path> PictureFinder::find(const std::string& name,
                                            const std::string& where) const {
  if (name.find('\0') != std::string::npos) return std::nullopt;
  const fs::path asked = portable(name), last = asked.filename();
  if (last.empty()) return std::nullopt;
  for (const fs::path& wanted : {asked, last})
    for (const fs::path& folder : folders_)
      if (is_there(folder / wanted)) return folder / wanted;
  list_files();
  const std::string small = small_letters(last.string());
  if (const auto found = unique(by_name_, small, name, where)) return found;
  return unique(by_stem_, stem_of(small), name, where);
}

}  // namespace mq

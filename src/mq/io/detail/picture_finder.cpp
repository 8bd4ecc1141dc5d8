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

PictureFinder::PictureFinder(std::vector<fs::path> folders, std::vector<fs::path> deep)
    : folders_(std::move(folders)), deep_(std::move(deep)) {}

void PictureFinder::Listed::add(const fs::path& file) {
  const std::string name = file.filename().string();
  if (!names_picture(name) || !is_there(file)) return;
  by_name.emplace(small_letters(name), file);
  by_stem.emplace(small_letters(stem_of(name)), file);
}

namespace {

/// visit(folder) for those that are there, each once.
void for_each_folder(const std::vector<fs::path>& folders, const auto& visit) {
  std::vector<fs::path> seen;
  for (const fs::path& folder : folders) {
    std::error_code error;
    const fs::path real = fs::weakly_canonical(folder, error);
    if (error || !fs::is_directory(folder.empty() ? "." : folder, error) ||
        std::ranges::find(seen, real) != seen.end())
      continue;
    seen.push_back(real);
    visit(folder);
  }
}

}  // namespace

void PictureFinder::list_files() const {
  if (listed_.done) return;
  listed_.done = true;
  for_each_folder(folders_, [&](const fs::path& folder) {
    std::error_code error;
    for (fs::directory_iterator at(folder.empty() ? "." : folder, error), end; !error && at != end;
         at.increment(error))
      listed_.add(folder / at->path().filename());
  });
}

void PictureFinder::list_deep_files() const {
  constexpr int most_below = 6;
  if (deep_listed_.done) return;
  deep_listed_.done = true;
  for_each_folder(deep_, [&](const fs::path& folder) {
    std::error_code error;
    fs::recursive_directory_iterator at(folder, fs::directory_options::skip_permission_denied, error);
    for (const fs::recursive_directory_iterator end; !error && at != end; at.increment(error)) {
      if (at.depth() >= most_below) at.disable_recursion_pending();
      if (at.depth() > 0) deep_listed_.add(at->path());
    }
  });
}

namespace {

/// How many folders, from the last one, are called alike.
int folders_alike(const fs::path& a, const fs::path& b) {
  const fs::path folder_of_a = a.parent_path(), folder_of_b = b.parent_path();
  const std::vector<fs::path> of_a(folder_of_a.begin(), folder_of_a.end());
  const std::vector<fs::path> of_b(folder_of_b.begin(), folder_of_b.end());
  int alike = 0;
  for (auto i = of_a.rbegin(), j = of_b.rbegin(); i != of_a.rend() && j != of_b.rend() && *i == *j; ++i, ++j) ++alike;
  return alike;
}

/// Those whose folders are called most as `asked` says.
std::vector<std::string> in_folders_asked(const std::vector<std::string>& found, const fs::path& asked) {
  int most = 0;
  for (const std::string& file : found) most = std::max(most, folders_alike(file, asked));
  std::vector<std::string> some;
  for (const std::string& file : found)
    if (folders_alike(file, asked) == most) some.push_back(file);
  return some;
}

}  // namespace

std::optional<fs::path> PictureFinder::listed(const Listed& files, const fs::path& asked, const std::string& name,
                                              const std::string& where) const {
  const std::string small = small_letters(asked.filename().string());
  const auto unique = [&](const Names& names, const std::string& key) -> std::optional<fs::path> {
    std::vector<std::string> found;
    const auto [begin, end] = names.equal_range(key);
    for (auto at = begin; at != end; ++at) found.push_back(at->second.string());
    std::ranges::sort(found);
    if (found.size() > 1) found = in_folders_asked(found, asked);
    if (found.size() > 1)
      throw IoError(fmt::format("{}: its picture {} may be {}: rename them, or give the folder with the "
                                "right ones alone",
                                where, name, fmt::join(found, " or ")));
    return found.empty() ? std::nullopt : std::optional<fs::path>(found.front());
  };
  if (const auto found = unique(files.by_name, small)) return found;
  return unique(files.by_stem, stem_of(small));
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
  if (const auto found = listed(listed_, asked, name, where)) return found;
  list_deep_files();
  return listed(deep_listed_, asked, name, where);
}

}  // namespace mq

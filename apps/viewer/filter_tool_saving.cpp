// Files of the mask and of what is made with it.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "filter_tool.h"
#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/io/path_status.h"

namespace mq::view {
namespace {

namespace fs = std::filesystem;

}  // namespace

/// A command that reads the mask and writes the texture can only be repeated where they are two
/// files.
void FilterTool::require_other_files(const std::vector<fs::path>& files,
                                     const std::vector<fs::path>& others) {
  for (const fs::path& file : files)
    for (const fs::path& other : others)
      require(
          full_name(file) != full_name(other),
          fmt::format("{}: mask and texture need files of their own: name another", file.string()));
}

Outputs FilterTool::outputs(const std::string& path) const {
  return {path, session_.scene->model, paint_target_->kind()};
}

void FilterTool::save_texture(const std::string& path) {
  require_ready();
  if (nothing_painted()) session_.say("nothing is painted: the texture is saved as it was opened");
  const Outputs outputs = this->outputs(path);
  require_other_files(outputs.paths(), mask_files_);
  session_.run.will_write(outputs.paths(), outputs.folders());
  texture_name_ = path;
  texture_files_ = outputs.paths();
  const std::lock_guard lock(mutex_);
  saves_.emplace_back().path = path;
  stopped_ = false;
}

void FilterTool::save_mask(const std::string& path) {
  require_ready();
  const Outputs outputs = this->outputs(path);
  for (const auto& file : outputs.paths()) paint_target_->require_mask_name(file, smoothed_ > 0);
  require_other_files(outputs.paths(), texture_files_);
  session_.run.will_write(outputs.paths(), outputs.folders());
  mask_files_ = outputs.paths();
  mask_name_ = path;
  const std::lock_guard lock(mutex_);
  saves_.push_back({.path = path,
                    .masks = outputs.paths(),
                    .mask = mask_,
                    .smooths = smoothed_ > 0,
                    .changes = changes_});
  stopped_ = false;
}

/// What was painted since is not in the file.
void FilterTool::take_note_of_written() {
  std::vector<Save> written;
  {
    const std::lock_guard lock(mutex_);
    written.swap(written_);
  }
  if (const int saved = saved_version_; std::exchange(noted_version_, saved) != saved) session_.kept = {};
  for (const Save& save : written) {
    std::vector<std::string> names;
    for (const auto& file : save.masks) names.push_back(file.string());
    options_.set("mask", names);
    if (save.changes == changes_) saved_mask_ = save.path;
    session_.say("wrote " + save.path);
  }
}

void FilterTool::give_up_saving() {
  const std::lock_guard lock(mutex_);
  std::string paths;
  for (const Save& save : saves_) paths += (paths.empty() ? "" : ", ") + save.path;
  saves_.clear();
  if (!paths.empty()) session_.say("not saved: " + paths);
}

std::string FilterTool::saving() const {
  const std::lock_guard lock(mutex_);
  return saves_.empty() ? "" : saves_.front().path;
}

std::string FilterTool::unsaved() const {
  const std::lock_guard lock(mutex_);
  const bool kept = !saved_mask_.empty() || saved_version_ == wanted_.version;
  if (nothing_painted() || kept) return {};
  return begins_ == Begins::nowhere ? "what was painted with the filter" : "what 'smooth, sharpen' made";
}

std::string FilterTool::kept_as() const {
  return nothing_painted() || at_vertices() || session_.sequence ? "" : session_.texture_file("filtered");
}

void FilterTool::keep(const std::string& path) {
  require_ready();
  const std::lock_guard lock(mutex_);
  saves_.emplace_back().path = path;
  stopped_ = false;
}

/// Whether there was one to be written: nothing need be solved for it.
bool FilterTool::write_mask() {
  Save save;
  {
    const std::lock_guard lock(mutex_);
    if (saves_.empty() || saves_.front().masks.empty()) return false;
    save = saves_.front();
  }
  paint_target_->write_mask(save.mask, full, save.smooths, save.masks);
  save.mask.clear();
  const std::lock_guard lock(mutex_);
  saves_.pop_front();
  written_.push_back(std::move(save));
  return true;
}

bool FilterTool::write_texture(int version, const Progress& progress) {
  std::string path;
  {
    const std::lock_guard lock(mutex_);
    if (saves_.empty()) return false;
    path = saves_.front().path;
  }
  Model model = session_.scene->model;
  const bool nothing = std::ranges::all_of(followed_, [](int m) { return m == 0; });
  if (!nothing) {
    const ShownSignal values = shown();
    Signal after = before_;
    parallel_for(after.rows(), [&](std::int64_t k) {
      for (int c = 0; c < int(after.cols()); ++c) after(k, c) = values(k, c);
    });
    paint_target_->target().put(before_, after, model);
  }
  const Outputs outputs = this->outputs(path);
  for (const std::string& note : outputs.write(std::move(model), progress.step("write", 0)))
    session_.run.terminal().remark(note);
  saved_version_ = version;
  {
    const std::lock_guard lock(mutex_);
    saves_.pop_front();
  }
  session_.run.terminal().remark("wrote " + path);
  return true;
}

}  // namespace mq::view

// Results, and what is shown on the way to them.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>

#include "mq/base/error.h"
#include "verb_tool.h"

namespace mq::view {
namespace {

/// Of all stages of a run together, at 4 or 16 bytes each; the first ones are let go.
constexpr std::int64_t most_texels_kept = 256 << 20;

}  // namespace

VerbTool::Stage VerbTool::stage_of(const std::string& name, const Model& result) const {
  Stage stage;
  stage.name = name;
  if (at_vertices_)
    stage.colours = std::make_shared<VertexSignal>(result.colors);
  else
    stage.pictures = pictures_of(result);
  return stage;
}

void VerbTool::show_stage(const std::string& name, const Model& result) {
  Stage stage = stage_of(name, result);
  const std::lock_guard lock(stages_mutex_);
  if (std::exchange(other_run_, false)) stages_.clear();
  put(std::move(stage), stages_.size());
}

void VerbTool::show(std::shared_ptr<TextureSet> pictures) {
  const std::lock_guard lock(stages_mutex_);
  if (std::exchange(other_run_, false)) stages_.clear();
  if (stages_.size() == 1 && stages_.front().pictures == pictures) return;
  stages_.clear();
  put({"result", {}, std::move(pictures), nullptr}, 0);
}

void VerbTool::show_stage(double time, const Model& result) {
  Stage stage = stage_of(fmt::format("time {:.4g}", time), result);
  stage.time = time;
  const std::lock_guard lock(stages_mutex_);
  const auto later = std::ranges::find_if(stages_, [&](const Stage& s) { return s.time > time; });
  put(std::move(stage), std::size_t(later - stages_.begin()));
}

bool VerbTool::show_again(double time) {
  const std::lock_guard lock(stages_mutex_);
  const auto found = std::ranges::find_if(stages_, [&](const Stage& s) { return s.time == time; });
  if (found == stages_.end()) return false;
  newest_ = std::size_t(found - stages_.begin());
  return true;
}

void VerbTool::forget_stages() {
  const std::lock_guard lock(stages_mutex_);
  stages_.clear();
}

/// As the newest. Where all take too much memory the first of the others go.
void VerbTool::put(Stage stage, std::size_t place) {
  std::int64_t texels = session_.scene->model.mesh.vertex_count();
  if (stage.pictures)
    for (int i = 0; i < stage.pictures->size(); ++i)
      texels += std::int64_t(stage.pictures->width(i)) * stage.pictures->height(i);
  stages_.insert(stages_.begin() + std::ptrdiff_t(place), std::move(stage));
  newest_ = place;
  while (stages_.size() > 1 && std::int64_t(stages_.size()) * texels > most_texels_kept) {
    const std::size_t gone = newest_ == 0 ? 1 : 0;
    stages_.erase(stages_.begin() + std::ptrdiff_t(gone));
    newest_ -= gone < newest_ ? 1 : 0;
  }
}

/// Where work is shown on its way, what is shown of it.
void VerbTool::stage_controls() {
  int stage = int(stage_), count = 0;
  std::string name;
  {
    const std::lock_guard lock(stages_mutex_);
    count = int(stages_.size());
    if (stage < count) name = stages_[stage_].name;
  }
  has_had_stages_ = has_had_stages_ || count > 1;
  if (!has_had_stages_) return;
  ImGui::BeginDisabled(count < 2);
  const bool moved = ImGui::SliderInt("on the way", &stage, 0, std::max(1, count - 1), name.c_str(),
                                      ImGuiSliderFlags_AlwaysClamp);
  ImGui::EndDisabled();
  if (ImGui::IsItemHovered() && !ImGui::IsItemActive())
    ImGui::SetTooltip("what was shown on the way to the result, which is on the right");
  if (moved && stage < count) choose_stage(std::size_t(stage));
}

/// Those of the run, or of the stage with a time of its own that a person looks at.
OptionValues VerbTool::options_of_shown() const {
  OptionValues options = options_;
  const std::lock_guard lock(stages_mutex_);
  if (!at_newest_ && stage_ < stages_.size() && stages_[stage_].time)
    options.set("time", {fmt::format("{}", *stages_[stage_].time)});
  return options;
}

void VerbTool::choose_stage(std::size_t stage) {
  const std::lock_guard lock(stages_mutex_);
  require(stage < stages_.size(),
          fmt::format("there is no stage {}: {} to {} are there", stage, 0, stages_.size() - 1));
  stage_ = stage;
  at_newest_ = stage == newest_;
  session_.show(stages_[stage].pictures, stages_[stage].colours);
}

}  // namespace mq::view

// What a person sets of the filter, and what is said of it.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "controls.h"
#include "filter_tool.h"
#include "mq/base/error.h"
#include "tasks.h"
#include "theme.h"

namespace mq::view {

void FilterTool::panel() {
  const bool is_ready = ready_;
  if (!is_ready) {
    ImGui::TextUnformatted("getting ready ...");
    return;
  }
  if (begins_ == Begins::everywhere) {
    whole_controls();
  } else {
    brush_controls();
    strength_controls();
  }
  ImGui::BeginDisabled(nothing_painted());
  if (ask_to_save(session_, at_vertices() ? "model" : "texture", texture_name_))
    tried(session_, [&] { save_texture(texture_name_); });
  ImGui::EndDisabled();
  histogram_controls();
  if (ImGui::CollapsingHeader("more")) more_controls();
}

/// The brush comes once there is something that it can take away here and there.
void FilterTool::whole_controls() {
  strength_controls();
  remark("Above 0 % detail comes out more clearly, below it is smoothed.");
  ImGui::BeginDisabled(!nothing_painted());
  if (ImGui::Button(run_words(name()).c_str(), {-1, 0})) tried(session_, [&] { fill(full); });
  ImGui::EndDisabled();
  if (nothing_painted()) return;
  remark("The brush erases it again where it should not be.");
  brush_controls();
}

void FilterTool::brush_controls() {
  int brush = int(brush_);
  ImGui::RadioButton("sharpen", &brush, 0);
  ImGui::SameLine();
  ImGui::RadioButton("smooth", &brush, 1);
  ImGui::SameLine();
  ImGui::RadioButton("erase", &brush, 2);
  if (brush != int(brush_)) tried(session_, [&] { choose(Brush(brush)); });
  edit_brush(size_, brush_radius(), scale_.area);
  undo_buttons(session_, *this);
}

/// beta as what it adds, and how far it reaches as the size of detail.
void FilterTool::strength_controls() {
  double strength = 100 * (options_.number("beta") - 1);
  const std::string words = (strength > 0 ? "+" : "") + plain(strength) + " % detail";
  if (slider("strength", strength, {-100, 500}, words))
    tried(session_, [&] { set("strength", fmt::format("{:.3g}", strength)); });
  if (!options_.given("length")) {
    tried(session_, [&] {
      OptionValues edited = options_;
      if (edit(edited, "alpha")) take(edited);
    });
    if (ImGui::SmallButton("as a size"))
      tried(session_, [&] {
        set("length", fmt::format("{:.3g}%", 100 * std::sqrt(options_.number("alpha"))));
      });
    return;
  }
  const Length length = parse_length(options_.text("length"));
  const bool percent = length.unit == Length::Unit::percent,
             model = length.unit == Length::Unit::model;
  double size = length.value;
  if (slider("size of detail", size,
             {percent ? 0.05 : model ? size / 20 : 0.5, percent ? 20 : model ? size * 20 : 100.0, true},
             plain(size) + (percent ? " % of the model" : model ? "" : " texels")))
    tried(session_, [&] {
      set("length", fmt::format("{:.3g}{}", size, percent ? "%" : model ? "" : "tx"));
    });
}

void FilterTool::more_controls() {
  double flow = 100 * strength_, hardness = 100 * hardness_;
  if (slider("per touch", flow, {1, 100}, plain(flow) + " %")) strength_ = flow / 100;
  if (slider("hard edge", hardness, {0, 100}, plain(hardness) + " % of the brush"))
    hardness_ = hardness / 100;
  if (ImGui::Button("everywhere")) fill(full);
  ImGui::SameLine();
  if (ImGui::Button("nowhere")) fill(0);
  ImGui::BeginDisabled(nothing_painted());
  if (ask_to_save(session_, "mask", mask_name_)) tried(session_, [&] { save_mask(mask_name_); });
  ImGui::EndDisabled();
  copy_button(session_, [&] { return as_command(); });
  remark(fmt::format("{} {} painted{}", painted_, paint_target_->unknowns(),
                     settled_ ? "" : ", solving"));
}

/// How bright what is shown is, over how bright it was, and what a picture of it would clamp.
void FilterTool::histogram_controls() const {
  Histogram before, after;
  {
    const std::lock_guard lock(mutex_);
    before = values_before_;
    after = values_after_;
  }
  if (after.count == 0 || holds_numbers(session_.scene->model)) return;  // light is not clamped
  const auto most = double(std::max(*std::ranges::max_element(before.counts),
                                    *std::ranges::max_element(after.counts)));
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const ImVec2 size{ImGui::GetContentRegionAvail().x, 3 * ImGui::GetFontSize()};
  ImDrawList* const list = ImGui::GetWindowDrawList();
  list->AddRectFilled(corner, {corner.x + size.x, corner.y + size.y},
                      ImGui::GetColorU32(ImGuiCol_FrameBg), 3);
  const auto draw = [&](const Histogram& values, ImU32 colour) {
    const float wide = size.x / float(values.counts.size());
    for (std::size_t i = 0; i < values.counts.size(); ++i) {
      const float high = most > 0 ? float(std::sqrt(double(values.counts[i]) / most)) * size.y : 0;
      const float left = corner.x + float(i) * wide;
      list->AddRectFilled({left, corner.y + size.y - high}, {left + wide, corner.y + size.y}, colour);
    }
  };
  draw(before, ImGui::GetColorU32(ImGuiCol_TextDisabled, 0.45F));
  draw(after, ImGui::GetColorU32(ImGuiCol_PlotHistogram, 0.7F));
  ImGui::Dummy(size);
  const double share = 100 * after.clamped_share(), was = 100 * before.clamped_share();
  const std::string clamped = share < 0.05 ? share > 0 ? "under 0.1" : "0" : fmt::format("{:.1f}", share);
  if (share > was + 0.5)
    ImGui::TextColored({0.9F, 0.5F, 0.2F, 1}, "%s", (clamped + " % of values clamped").c_str());
  else
    remark(clamped + " % of values clamped");
}

}  // namespace mq::view

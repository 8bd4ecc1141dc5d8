// The panel on the left: the model, the tasks, what belongs to the one that is chosen, and what goes
// on.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>

#include "controls.h"
#include "mq/base/error.h"
#include "theme.h"
#include "viewer.h"
#include "window_flags.h"

namespace mq::view {
namespace {

/// 27306 as "27,306".
std::string counted(std::int64_t count) {
  std::string digits = std::to_string(count);
  for (int at = int(digits.size()) - 3; at > 0; at -= 3) digits.insert(std::size_t(at), ",");
  return digits;
}

}  // namespace

void Viewer::panel(float width, float height) {
  ImGui::SetNextWindowPos({0, 0});
  ImGui::SetNextWindowSize({width - 2, height});
  ImGui::Begin("panel", nullptr, fixed_window);
  ImGui::PushItemWidth(width * 0.5F);
  const TexturedModel& scene = *session_.scene;
  ImGui::TextUnformatted(scene.model.path.filename().string().c_str());
  const float buttons = ImGui::CalcTextSize("open ...").x + ImGui::CalcTextSize("close").x +
                        4 * ImGui::GetStyle().FramePadding.x + ImGui::GetStyle().ItemSpacing.x;
  ImGui::SameLine(ImGui::GetWindowContentRegionMax().x - buttons);  // left of a scroll bar
  if (ImGui::SmallButton("open ...")) tried(session_, [&] { ask_for_model(); });
  ImGui::SameLine();
  if (ImGui::SmallButton("close")) model_to_close_ = true;
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("Ctrl + W: back to the empty window, with samples");
  remark(fmt::format("{} triangles{}", counted(scene.surface.triangle_count()),
                     scene.atlas ? fmt::format(", {} charts", counted(std::ssize(scene.atlas->charts)))
                                 : ", no texture coordinates"));
  task_controls();
  ImGui::Separator();
  remark(task_words[std::size_t(task_)].help);
  ImGui::PushID(task_words[std::size_t(task_)].name);  // "more" of each is its own
  switch (task_) {
    case Task::look: look_controls(); break;
    case Task::compare: compare_controls(); break;
    case Task::photographs: photograph_controls(); break;
    case Task::play: play_controls(); break;
    case Task::picture: picture_controls(); break;
    case Task::change: change_controls(); break;
    case Task::paint:
    case Task::measure: tool_controls(); break;
  }
  ImGui::PopID();
  loading_controls();
  kept_controls();
  panel_footer();
  ImGui::PopItemWidth();
  ImGui::End();
}

/// Two columns of buttons; the chosen one stands out.
void Viewer::task_controls() {
  const float wide = (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x) / 2;
  for (std::size_t i = 0; i < task_words.size(); ++i) {
    const bool chosen = task_ == Task(i);
    if (i % 2 == 1) ImGui::SameLine();
    if (chosen)
      ImGui::PushStyleColor(ImGuiCol_Button, ImGui::GetStyleColorVec4(ImGuiCol_ButtonActive));
    if (ImGui::Button(task_words[i].label, {wide, 0})) tried(session_, [&] { take_task(Task(i)); });
    if (chosen) ImGui::PopStyleColor();
    if (ImGui::IsItemHovered())
      ImGui::SetTooltip("%s (key %d)", task_words[i].help, int(i) + 1);
  }
}

/// Of the tool in hand, with its strokes and its work.
void Viewer::tool_controls() {
  if (!tool_) return;
  ImGui::PushID(tool_name_.c_str());  // options have names of their own, such as show
  tool_->panel();
  ImGui::PopID();
  if (!tool_->kept_as().empty()) {
    if (ImGui::Button("keep it on the model", {-1, 0})) tried(session_, [&] { keep(); });
    if (ImGui::IsItemHovered())
      ImGui::SetTooltip("It becomes the model's texture, in no file yet, which this tool and the others begin with");
  }
  history_controls();
  const bool changes = task_ == Task::paint || session_.result || session_.result_colours;
  if (session_.compares() && changes && task_ != Task::compare) wipe_controls();
  if (!tool_->busy()) return;  // last, so that nothing moves when it comes and goes
  progress_bar(tool_->fraction(), tool_->step());
  if (ImGui::Button("stop")) tool_->cancel();
}

/// A list of strokes; one that is pressed is the last that is done.
void Viewer::history_controls() {
  const Tool::History history = tool_->history();
  if (history.strokes.empty()) return;
  const std::string head = fmt::format("strokes ({})###strokes", history.strokes.size());
  if (!ImGui::CollapsingHeader(head.c_str())) return;
  const auto go_to = [&](std::size_t wanted) {
    tried(session_, [&] { go_to_stroke(wanted); });
  };
  if (ImGui::Selectable("as it was opened", history.done == 0)) go_to(0);
  for (std::size_t i = 0; i < history.strokes.size(); ++i) {
    const bool taken_back = i >= history.done;
    if (taken_back)
      ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
    const std::string line = fmt::format("{}: {}", i + 1, history.strokes[i]);
    if (ImGui::Selectable(line.c_str(), i + 1 == history.done)) go_to(i + 1);
    if (taken_back) ImGui::PopStyleColor();
  }
}

void Viewer::go_to_stroke(std::size_t count) {
  require(tool_ != nullptr, "there are no strokes: nothing is in hand that makes some");
  const Tool::History history = tool_->history();
  require(count <= history.strokes.size(),
          fmt::format("there is no stroke {}: there are {}", count, history.strokes.size()));
  for (std::size_t at = history.done; at > count; --at) tool_->undo();
  for (std::size_t at = history.done; at < count; ++at) tool_->redo();
}

/// What is on its way, once it takes longer than a moment.
void Viewer::loading_controls() {
  if (!loader_.busy() || session_.playing) return;
  ImGui::Separator();
  ImGui::TextUnformatted(("loading " + loader_.name()).c_str());
  progress_bar(loader_.fraction(), loader_.step());
  if (ImGui::Button("cancel")) cancel_loading();
}

/// At the lower end of the panel, or behind what is longer than it.
void Viewer::panel_footer() {
  const float line = ImGui::GetFrameHeightWithSpacing();
  const float end = ImGui::GetWindowHeight() - line - ImGui::GetStyle().WindowPadding.y;
  if (ImGui::GetCursorPosY() < end) ImGui::SetCursorPosY(end);
  if (ImGui::Button("keys: ?")) keys_shown_ = !keys_shown_;
  ImGui::SameLine();
  if (ImGui::Button(theme_ == Theme::dark ? "light panels" : "dark panels"))
    set_theme(theme_ == Theme::dark ? Theme::light : Theme::dark);
}

}  // namespace mq::view

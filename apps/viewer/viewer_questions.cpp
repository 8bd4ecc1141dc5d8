// What a person is asked before something unsaved is lost.
#include <fmt/format.h>
#include <imgui.h>

#include "controls.h"
#include "mq/base/error.h"
#include "viewer.h"

namespace mq::view {

/// Of the model also what was kept on it; what a tool made of that holds it.
std::string Viewer::unsaved(Leaving leaving) const {
  const std::string made = tool_ ? tool_->unsaved() : "";
  return !made.empty() || leaving == Leaving::tool ? made : session_.kept.words;
}

void Viewer::unless_lost(Leaving leaving, const std::string& what, std::function<void()> act,
                         std::function<void()> otherwise) {
  const std::string unsaved = this->unsaved(leaving), saving = tool_ ? tool_->saving() : "";
  if (asking_ == Asking::person && !(unsaved.empty() && saving.empty())) {
    leaving_ = leaving;
    on_yes_ = act;
    on_no_ = otherwise;
    if (saving.empty()) {
      question_ = fmt::format("You have not saved {}. It is lost if you {}.", unsaved, what);
    } else {
      question_ =
          fmt::format("{} is being saved first. It is given up if you {} at once.", saving, what);
      on_saved_ = [this, leaving, what, act, otherwise] { unless_lost(leaving, what, act, otherwise); };
    }
    return;
  }
  act();
  if (!unsaved.empty()) session_.run.terminal().warning(unsaved + " was not saved, and is gone");
}

/// What waits for a file to be written goes on once that is done, and not where it failed.
void Viewer::go_on_when_saved(bool failed) {
  if (!on_saved_ || (!failed && tool_ && !tool_->saving().empty())) return;
  if (failed) return answer(false);
  on_yes_ = std::move(on_saved_);
  answer(true);
}

void Viewer::answer(bool go_on) {
  const std::function<void()> act = go_on ? std::move(on_yes_) : std::move(on_no_);
  question_.clear();
  asked_to_close_ = false;
  on_yes_ = on_no_ = on_saved_ = {};
  if (!act) return;
  try {
    act();
  } catch (const Error& error) {
    session_.say(error.what());
  }
}

void Viewer::answer_save() {
  require(!question_.empty() && !on_saved_ && !unsaved(leaving_).empty(),
          "there is nothing to save first: nothing unsaved is asked for");
  save_and_go_on();
}

bool Viewer::can_keep() const {
  return !question_.empty() && !on_saved_ && leaving_ == Leaving::tool && tool_ && !tool_->kept_as().empty();
}

void Viewer::answer_keep() {
  require(can_keep(), "nothing is asked for that could become the model's texture");
  keep_and_go_on(std::move(on_yes_));
}

/// Where it cannot be saved the question stays.
void Viewer::save_and_go_on() {
  if (!tool_ || tool_->unsaved().empty()) {
    save_kept();
    return answer(true);
  }
  tool_->save();
  const std::string file = tool_->saving();
  question_ = file + " is being saved.";
  on_saved_ = [this, act = std::move(on_yes_), otherwise = on_no_] {
    if (!tool_ || tool_->unsaved().empty()) return act();
    if (otherwise) otherwise();
  };
  on_yes_ = {};
}

void Viewer::close() {
  if (!question_.empty() && !asked_to_close_) answer(false);
  if (question_.empty()) {
    asked_to_close_ = true;
    unless_lost(Leaving::model, "close the window", [this] { closed_ = true; });
  }
  if (!closed_) display_.stay_open();
}

void Viewer::ask_before_losing() {
  constexpr const char* title = "not saved";
  const bool can_save = !on_saved_ && on_yes_ && !unsaved(leaving_).empty();
  if (question_.empty()) {
    if (ImGui::BeginPopupModal(title)) {  // a key answered it
      ImGui::CloseCurrentPopup();
      ImGui::EndPopup();
    }
    return;
  }
  if (!ImGui::IsPopupOpen(title)) ImGui::OpenPopup(title);
  const ImVec2 middle{float(display_.width()) / 2, float(display_.height()) / 2};
  ImGui::SetNextWindowPos(middle, ImGuiCond_Always, {0.5F, 0.5F});
  if (!ImGui::BeginPopupModal(title, nullptr,
                              ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove))
    return;
  ImGui::PushTextWrapPos(scaled(440));
  ImGui::TextUnformatted(question_.c_str());
  ImGui::PopTextWrapPos();
  ImGui::Spacing();
  if (can_save && ImGui::Button("save it first")) tried(session_, [&] { save_and_go_on(); });
  if (can_save && can_keep()) {
    ImGui::SameLine();
    if (ImGui::Button("keep it on the model")) tried(session_, [&] { answer_keep(); });
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("What comes next begins with it; it is in no file yet");
  }
  if (can_save) ImGui::SameLine();
  const bool no = ImGui::Button("stay");
  if (on_yes_) ImGui::SameLine();
  const bool yes = on_yes_ && ImGui::Button(can_save ? "throw it away" : "give it up");  // last, whatever else there is
  if (yes || no) answer(yes);
  if (question_.empty()) ImGui::CloseCurrentPopup();
  ImGui::EndPopup();
}

}  // namespace mq::view

// What keys do, and the list of it that "?" shows.
#include <imgui.h>
#include <imgui_internal.h>

#include <algorithm>

#include "controls.h"
#include "mq/base/error.h"
#include "viewer.h"

namespace mq::view {
namespace {

struct KeyWords {
  const char *key, *does;
};

constexpr KeyWords key_words[] = {
    {"left button", "turns the model; paints and measures with a tool in hand"},
    {"right button", "turns the model"},
    {"middle button, Shift + left", "moves the model"},
    {"wheel", "nearer, farther"},
    {"1 to 8", "the tasks, in their order"},
    {"F", "the whole model, and the whole texture"},
    {"U", "the model's upright axis: y or z"},
    {"B", "before and after, or after alone"},
    {"L, S, W", "light, seams, wires"},
    {"[ and ], - and +", "a smaller, a larger brush"},
    {"Ctrl + Z, Ctrl + Y", "takes the last stroke back, does it again"},
    {"N", "where the textures differ most from before; the next such place"},
    {"Ctrl + O, Ctrl + S", "opens a model, saves what was made"},
    {"Ctrl + W, Ctrl + Q", "closes the model, the window"},
    {"M", "the last messages"},
    {"D", "dark or light panels"},
    {"Return, Escape", "save it first, and stay, where the window asks"},
    {"Escape", "ends what is going on, and puts lists and messages away"},
    {"? or F1", "this list"},
};

}  // namespace

/// Where no text is being written.
void Viewer::use_keys() {
  for (const std::string& key : display_.keys()) {
    const bool ends = key == "escape" || (key == "return" && asking_path_);
    if (ImGui::GetIO().WantTextInput && !ends) continue;
    if (dragging_ == Dragging::working) continue;
    tried(session_, [&] { use_key(key); });
  }
}

bool Viewer::use_key(const std::string& key) {
  if (!question_.empty()) {
    if (key == "escape") answer(false);
    if (key == "return") answer_save();
    return key == "escape" || key == "return";
  }
  if (key == "?") {
    keys_shown_ = !keys_shown_;
    return true;
  }
  if (key == "return" && asking_path_) {
    take_path();
    return true;
  }
  if (key == "escape") return end_what_goes_on();
  if (key.starts_with("ctrl+")) return use_command_key(key.substr(5));
  if (session_.empty || key.size() != 1) return false;
  Look& look = session_.look;
  switch (key[0]) {
    case 'f': home(), home_atlas(); break;
    case 'b':
      look.wipe = look.wipe < 0 && session_.compares() ? 0.5 : -1;
      if (look.wipe >= 0 && !has_changed()) session_.say("nothing was changed yet: before and after are the same");
      break;
    case 'n': look_at_difference(); break;
    case 'l': look.lit = !look.lit; break;
    case 's': look.seams = !look.seams; break;
    case 'u': set_up(up_ == View::Up::y ? View::Up::z : View::Up::y); break;
    case 'w': look.wires = !look.wires; break;
    case 'm': messages_shown_ = !messages_shown_; break;
    case 'd': set_theme(theme_ == Theme::dark ? Theme::light : Theme::dark); break;
    case '[':
    case '-':
    case ']':
    case '+': {
      const double step = 1.2;
      if (tool_) tool_->scale_brush(key == "[" || key == "-" ? 1 / step : step);
      break;
    }
    default:
      if (key[0] < '1' || key[0] > '8') return false;
      take_task(Task(key[0] - '1'));
  }
  return true;
}

/// A list that is open first, then messages and questions, then work.
bool Viewer::end_what_goes_on() {
  const bool lists = ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopupId | ImGuiPopupFlags_AnyPopupLevel);
  if (lists && !asking_path_) {
    ImGui::ClosePopupToLevel(0, false);
    return true;
  }
  const bool shows = keys_shown_ || messages_shown_ || !session_.refusal.empty() || asking_path_;
  keys_shown_ = messages_shown_ = asking_path_ = false;
  session_.refusal.clear();
  if (shows) return true;
  if (loader_.busy()) cancel_loading();
  else if (tour_.busy()) tour_.cancel();
  else if (tool_ && tool_->busy()) tool_->cancel();
  return true;
}

bool Viewer::use_command_key(const std::string& key) {
  if (key == "o") {
    ask_for_model();
  } else if (key == "w") {
    close_model();
  } else if (key == "q") {
    close();
  } else if (key == "s") {
    const bool kept = !session_.kept.words.empty() && !(tool_ && tool_->has_changed());
    require(kept || tool_ != nullptr, "there is nothing to save: nothing was changed");
    kept ? save_kept() : tool_->save();
  } else if (key == "z") {
    if (tool_) tool_->undo();
  } else if (key == "y" || key == "shift+z") {
    if (tool_) tool_->redo();
  } else {
    return false;
  }
  return true;
}

void Viewer::show_messages() {
  if (!messages_shown_) return;
  const ImVec2 middle{float(display_.width()) / 2, float(display_.height()) / 2};
  ImGui::SetNextWindowPos(middle, ImGuiCond_Always, {0.5F, 0.5F});
  ImGui::SetNextWindowSize({std::min(scaled(700), float(display_.width()) - scaled(40)), 0});
  ImGui::Begin("messages", &messages_shown_, ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse);
  if (session_.news.empty()) ImGui::TextUnformatted("There are none.");
  for (const Session::News& one : session_.news) {
    ImGui::Bullet();
    ImGui::TextWrapped("%s", one.text.c_str());
  }
  ImGui::End();
}

void Viewer::show_keys() {
  if (!keys_shown_) return;
  const ImVec2 middle{float(display_.width()) / 2, float(display_.height()) / 2};
  ImGui::SetNextWindowPos(middle, ImGuiCond_Always, {0.5F, 0.5F});
  ImGui::Begin("keys", &keys_shown_,
               ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoCollapse);
  float widest = 0;
  for (const KeyWords& words : key_words)
    widest = std::max(widest, ImGui::CalcTextSize(words.key).x);
  for (const KeyWords& words : key_words) {
    ImGui::TextUnformatted(words.key);
    ImGui::SameLine(widest + scaled(30));
    ImGui::TextUnformatted(words.does);
  }
  ImGui::End();
}

}  // namespace mq::view

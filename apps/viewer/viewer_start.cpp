// The window without a model: what can be opened; and how files are asked for at any time.
#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <filesystem>

#include "controls.h"
#include "mq/base/error.h"
#include "mq/io/picture_check.h"
#include "viewer.h"
#include "window_flags.h"

namespace mq::view {
namespace {

namespace fs = std::filesystem;

struct SampleWords {
  const char *name, *label, *help;
};

constexpr SampleWords samples[] = {
    {"bust", "an owl", "a bust with a photographed texture in 28 charts"},
    {"bust_3000", "a scan", "the same in 3,000 charts, as photogrammetry cuts"},
    {"genus4", "a button", "a shape with four holes"},
    {"sphere", "a ball", "in six charts"},
    {"merging", "two drops", "a sequence: they fuse and part"},
    {"photographs", "photographs", "the owl, with six photographs and their cameras"},
};

/// What of a kind lies in a folder, folders first.
std::vector<std::string> files_in(const fs::path& folder, FileKind kind) {
  std::vector<std::string> folders, files;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with(".")) continue;
    if (entry.is_directory(ignored))
      folders.push_back(name + "/");
    else if (is_of(kind, entry.path()))
      files.push_back(name);
  }
  std::ranges::sort(folders);
  std::ranges::sort(files);
  folders.insert(folders.end(), files.begin(), files.end());
  return folders;
}

}  // namespace

void Viewer::start_pane(float width, float height) {
  ImGui::SetNextWindowPos({0, 0});
  ImGui::SetNextWindowSize({width, height});
  ImGui::Begin("start", nullptr, fixed_window);
  const float column = std::min(scaled(560), width - scaled(40));
  ImGui::SetCursorPos({(width - column) / 2, std::max(scaled(16), height * 0.1F)});
  ImGui::BeginChild("column", {column, 0});
  view::title("marquetry");
  remark("Look at textured models, compare and correct their textures.");
  ImGui::Dummy({0, scaled(10)});
  if (loader_.busy()) {
    loading_controls();
  } else {
    open_controls();
    sample_controls();
    recent_controls();
  }
  ImGui::Dummy({0, scaled(14)});
  if (ImGui::SmallButton("keys: ?")) keys_shown_ = true;
  ImGui::SameLine();
  if (ImGui::SmallButton(theme_ == Theme::dark ? "light panels" : "dark panels"))
    set_theme(theme_ == Theme::dark ? Theme::light : Theme::dark);
  ImGui::EndChild();
  ImGui::End();
}

void Viewer::open_controls() {
  if (ImGui::Button("open a model ...", {scaled(150), scaled(32)}))
    tried(session_, [&] { ask_for_model(); });
  ImGui::SameLine();
  ImGui::AlignTextToFramePadding();
  ImGui::PushTextWrapPos(0);
  ImGui::TextUnformatted(
      "or drop it on this window: OBJ, PLY, glTF, GLB, a picture, or a folder of frames");
  ImGui::PopTextWrapPos();
}

void Viewer::sample_controls() {
  heading("samples to try");
  for (const SampleWords& sample : samples) {
    if (ImGui::Button(sample.label, {scaled(100), 0}))
      tried(session_, [&] { open_sample(sample.name); });
    ImGui::SameLine();
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(sample.help);
  }
}

void Viewer::recent_controls() {
  if (recent_.empty()) return;
  heading("opened before");
  const std::vector<std::string> files = recent_;
  for (const std::string& file : files) {
    const fs::path path(file);
    ImGui::PushID(file.c_str());
    if (ImGui::Selectable(path.filename().string().c_str(), false, 0, {scaled(180), 0}))
      tried(session_, [&] { open({file}); });
    ImGui::SameLine();
    ImGui::TextDisabled("%s", path.parent_path().string().c_str());
    ImGui::PopID();
  }
}

/// By the desktop's dialog, or where there is none by a box in the window, which begins where files of the kind were
/// chosen last, or else beside the model.
void Viewer::ask_for_files(FileKind kind, std::function<void(const Files&)> then) {
  on_chosen_ = std::move(then);
  asked_kind_ = kind;
  if (FileChooser::there()) {
    chooser_.ask(kind);
    return;
  }
  asking_path_ = true;
  const fs::path beside = session_.empty ? fs::path() : session_.scene->model.path.parent_path();
  const auto last = chosen_in_.find(kind);
  const fs::path folder = last != chosen_in_.end() ? fs::path(last->second)
                          : beside.empty()         ? fs::current_path()
                                                   : fs::absolute(beside);
  to_open_ = (folder / "").string();
}

void Viewer::take_chosen_files() {
  const auto files = chooser_.chosen();
  if (files && !files->empty() && on_chosen_) tried(session_, [&] { on_chosen_(*files); });
}

void Viewer::drop(const Files& files) {
  const bool in_hand = tool_ && task_of(tool_name_) == task_;
  if (!in_hand || !tool_->take_files(files)) open(files);
}

/// A path, and what lies in its folder. Of several, more are added with Ctrl held.
void Viewer::path_question() {
  const FileKindWords& words = words_of(asked_kind_);
  const std::string titled = std::string(words.title) + "###path";
  const char* const title = titled.c_str();
  if (!asking_path_) {
    if (ImGui::BeginPopupModal(title)) {  // a key ended it
      ImGui::CloseCurrentPopup();
      ImGui::EndPopup();
    }
    return;
  }
  const bool appears = !ImGui::IsPopupOpen(title);
  if (appears) ImGui::OpenPopup(title);
  const ImVec2 middle{float(display_.width()) / 2, float(display_.height()) / 2};
  ImGui::SetNextWindowPos(middle, ImGuiCond_Always, {0.5F, 0.5F});
  if (!ImGui::BeginPopupModal(title, &asking_path_,
                              ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove))
    return;
  if (appears) ImGui::SetKeyboardFocusHere();
  ImGui::SetNextItemWidth(scaled(480));
  ImGui::InputText("##path", &to_open_, ImGuiInputTextFlags_AutoSelectAll);
  bool open_it = false;
  const Files chosen = parted(to_open_);
  const fs::path named = fs::path(chosen.empty() ? "" : chosen.back()).parent_path();
  const fs::path folder = named.empty() ? "." : named;
  ImGui::BeginChild("files", {scaled(480), scaled(260)}, true);
  if (ImGui::Selectable("../", false, ImGuiSelectableFlags_DontClosePopups))
    to_open_ = (folder.parent_path() / "").string();
  for (const std::string& name : files_in(folder, asked_kind_))
    if (ImGui::Selectable(name.c_str(), std::ranges::count(chosen, (folder / name).string()) > 0,
                          ImGuiSelectableFlags_DontClosePopups |
                              ImGuiSelectableFlags_AllowDoubleClick)) {
      const std::string file = (folder / name).string();
      const bool adds = words.several && ImGui::GetIO().KeyCtrl && !name.ends_with('/') && !to_open_.ends_with('/');
      to_open_ = adds ? to_open_ + "; " + file : file;
      open_it |= ImGui::IsMouseDoubleClicked(0) && !name.ends_with('/');
    }
  ImGui::EndChild();
  ImGui::PushTextWrapPos(scaled(480));
  ImGui::TextDisabled("Listed are folders, and %s%s", words.files,
                      words.several ? ". Ctrl and a press add another one." : ".");
  ImGui::PopTextWrapPos();
  const bool is_folder = asked_kind_ == FileKind::cameras && to_open_.ends_with('/');
  open_it |= ImGui::Button(is_folder ? "choose this folder" : words.button, {scaled(is_folder ? 150 : 100), 0});
  ImGui::SameLine();
  const bool leave = ImGui::Button("cancel");
  if (open_it || leave) ImGui::CloseCurrentPopup();
  ImGui::EndPopup();
  if (leave) asking_path_ = false;
  if (open_it) tried(session_, [&] { take_path(); });
}

void Viewer::take_path() {
  asking_path_ = false;
  const Files files = parted(to_open_);
  require(!files.empty(), "no file is named");
  chosen_in_[asked_kind_] = fs::absolute(files.front()).parent_path().string();
  if (on_chosen_) on_chosen_(files);
}

/// What went wrong, over the panes until it is put away.
void Viewer::show_refusal(float width) {
  if (session_.refusal.empty()) return;
  const float room = session_.empty ? width : float(surface_at_.width);
  const float wide = std::min(scaled(560), room - scaled(30));
  const float middle = session_.empty ? width / 2 : float(surface_at_.x) + float(surface_at_.width) / 2;
  const float bottom = float(display_.height()) - scaled(40);  // of the empty window, whose head has its name
  ImGui::SetNextWindowPos({middle, session_.empty ? bottom : scaled(16)}, ImGuiCond_Always,
                          {0.5F, session_.empty ? 1.F : 0.F});
  ImGui::SetNextWindowSize({wide, 0});
  ImGui::PushStyleColor(ImGuiCol_WindowBg, theme_ == Theme::dark ? ImVec4(0.35F, 0.16F, 0.12F, 1)
                                                                 : ImVec4(1, 0.87F, 0.82F, 1));
  ImGui::Begin("refused", nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_AlwaysAutoResize |
                   ImGuiWindowFlags_NoFocusOnAppearing);
  ImGui::PushTextWrapPos(0);
  ImGui::TextUnformatted(session_.refusal.c_str());
  ImGui::PopTextWrapPos();
  if (ImGui::Button("all right")) session_.refusal.clear();
  ImGui::End();
  ImGui::PopStyleColor();
}

}  // namespace mq::view

#include "viewer.h"

#include <fmt/format.h>
#include <imgui.h>

#include <backends/imgui_impl_opengl3.h>
#include <algorithm>
#include <utility>

#include "controls.h"
#include "mq/base/error.h"
#include "mq/image/resample.h"
#include "mq/io/picture_check.h"
#include "tools.h"
#include "window_flags.h"

namespace mq::view {
namespace {

constexpr float panel_width = 300, status_height = 24;

}  // namespace

Viewer::Viewer(Session& session, Display& display) : session_(session), display_(display) {}

Viewer::~Viewer() {
  if (tool_) tool_->stop();
}

const std::vector<std::string>& Viewer::tool_names() { return view::tool_names(); }

void Viewer::take_tool(const std::string& name) {
  if (name == tool_name_) return;
  unless_lost("take the tool " + name, [this, name] { change_tool(name); });
}

void Viewer::change_tool(const std::string& name) {
  if (name == tool_name_) return;
  std::unique_ptr<Tool> taken = make_tool(name, session_);
  if (tool_) tool_->stop();
  tool_.reset();
  session_.reset_shown();
  tool_ = std::move(taken);
  tool_name_ = name;
  if (!tool_) return;
  if (const auto paint = tool_->shown_as()) session_.show_as(*paint);
}

void Viewer::frame(const ScriptedInput* scripted) {
  const Stopwatch watch;
  drawing_ = 0;
  display_.begin_frame();
  ImGuiIO& io = ImGui::GetIO();
  scripted_ = scripted != nullptr;
  if (scripted != nullptr) {
    mouse_used_since_said_ = scripted->x != io.MousePos.x || scripted->y != io.MousePos.y ||
                             (mouse_used_since_said_ && said_ == session_.messages);
    said_ = session_.messages;
    io.MousePos = {scripted->x, scripted->y};
    io.MouseDown[0] = scripted->left;
    io.MouseDown[1] = scripted->right;
    io.MouseDown[2] = scripted->middle;
    io.MouseWheel = scripted->wheel;
  }
  ImGui_ImplOpenGL3_NewFrame();
  ImGui::NewFrame();
  layout();
  ImGui::Render();
  with_graphics([&] {
    draw();
    display_.end_frame();
  });
  if (scripted_) session_.frames.push_back({watch.seconds() - drawing_, drawing_});
  if (std::exchange(screenshot_asked_, false))
    tried(session_, [&] {
      session_.run.will_write({screenshot_name_});
      screenshot(screenshot_name_);
      session_.say("wrote " + screenshot_name_);
      screenshot_name_ = Session::free_file(screenshot_name_);
    });
}

/// Also for a picture of what is shown: a window's framebuffer holds nothing once it was shown.
void Viewer::draw() const {
  glBindFramebuffer(GL_FRAMEBUFFER, display_.framebuffer());
  glViewport(0, 0, display_.width(), display_.height());
  glClearColor(0.16F, 0.16F, 0.17F, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

void Viewer::place_panes() {
  const auto width = float(display_.width()), height = float(display_.height());
  const float free = width - panel_width, top = height - status_height;
  const bool with_atlas = session_.scene->atlas.has_value();
  const int left = int(panel_width),
            split = with_atlas ? int(panel_width + 0.6F * free) : int(width);
  surface_at_ = {left, 0, std::max(1, split - left - (with_atlas ? 2 : 0)), std::max(1, int(top))};
  atlas_at_ = {split, 0, std::max(1, int(width) - split), std::max(1, int(top))};
}

void Viewer::layout() {
  place_panes();
  if (!opened_) {
    home();
    home_atlas();
    opened_ = true;
  }
  session_.camera.resize(surface_at_.width, surface_at_.height);
  try {
    play();
    take_loaded();
  } catch (const Error& error) {
    session_.playing = false;
    error_ = error.what();
    session_.say(error_);
  }
  bool failed = false;
  if (tool_) {
    try {
      tool_->frame();
    } catch (const Error& error) {
      failed = true;
      error_ = error.what();
      session_.say(error_);
    }
  }
  go_on_when_saved(failed);
  if (const std::vector<std::string> files = display_.dropped(); !files.empty()) {
    try {
      open(files);
    } catch (const Error& error) {
      session_.say(error.what());
    }
  }
  for (TextureSet* set : {session_.before.get(), session_.after.get(), session_.result.get()})
    if (set != nullptr) with_graphics([&] { upload(*set); });
  const auto width = float(display_.width()), top = float(display_.height()) - status_height;
  panel(panel_width, top);
  surface_pane();
  if (session_.scene->atlas) atlas_pane();
  use_keys();
  session_.listen();
  status_line(top, width);
  ask_before_losing();
}

void Viewer::upload(TextureSet& set) {
  const Stopwatch watch;
  const auto lock = set.lock();
  const std::int64_t texels = set.upload();
  if (texels == 0) return;
  ++uploads_;
  if (!scripted_) return;
  glFinish();
  session_.uploads.push_back({watch.seconds(), texels});
}

/// Ctrl+Z takes back, Ctrl+Y or Ctrl+Shift+Z does again; where no text is being written.
void Viewer::use_keys() {
  for (const Display::Key key : display_.keys()) {
    if (!tool_ || !question_.empty() || dragging_ == Dragging::working) continue;
    if (ImGui::GetIO().WantTextInput) continue;
    try {
      if (key == Display::Key::undo)
        tool_->undo();
      else
        tool_->redo();
    } catch (const Error& error) {
      session_.say(error.what());
    }
  }
}

/// What was said stays in front for a while, in scripts until the mouse is used; then what is under
/// the mouse is. Words that are too long for a line take several.
void Viewer::status_line(float y, float width) {
  constexpr double seconds = 6;
  std::string message;
  if (scripted_ && !session_.news.empty()) message = session_.news.back().text;
  for (const Session::News& one : session_.news)
    if (!scripted_ && one.since.seconds() < seconds)
      message += (message.empty() ? "" : "\n") + one.text;
  const std::string words = in_words(pick_, session_.pictures->radius());
  const bool news = !message.empty() && !(scripted_ && mouse_used_since_said_ && !words.empty());
  const std::string& shown = news ? message : words;
  const float lines = ImGui::CalcTextSize(shown.c_str(), nullptr, false, width - 16).y;
  const float height = std::max(status_height, lines + 10);
  ImGui::SetNextWindowPos({0, y + status_height - height});
  ImGui::SetNextWindowSize({width, height});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(8, 5));
  ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, ImVec2(1, 1));
  // In front of the panes, of which several lines cover some.
  ImGui::Begin("status", nullptr,
               (fixed_window & ~ImGuiWindowFlags_NoBringToFrontOnFocus) |
                   ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoInputs |
                   ImGuiWindowFlags_NoFocusOnAppearing);
  ImGui::PopStyleVar(2);
  ImGui::PushTextWrapPos(width - 8);
  if (news) ImGui::PushStyleColor(ImGuiCol_Text, IM_COL32(255, 220, 140, 255));
  ImGui::TextUnformatted(shown.c_str());
  if (news) ImGui::PopStyleColor();
  ImGui::PopTextWrapPos();
  ImGui::End();
}

Image<float> Viewer::picture() const {
  draw();
  return read_pixels(display_.width(), display_.height());
}

void Viewer::screenshot(const std::string& path, std::optional<Pane> pane) const {
  require_screenshot(path);
  Image<float> seen = picture();
  if (pane) {
    const Rectangle at = place_of(*pane);
    seen = cropped(seen, at.x, at.y, at.width, at.height);
  }
  write_image(path, seen);
}

void require_screenshot(const std::string& path) {
  const std::string extension = lower_extension(path);
  require(names_picture(path) && extension != ".exr",
          fmt::format("{}: found '{}', wanted .png, .jpg or .tif: what is on a screen has 8 bits",
                      path, extension));
}

}  // namespace mq::view

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
#include "recent.h"
#include "tools.h"
#include "window_flags.h"

namespace mq::view {
namespace {

constexpr float panel_width = 300, status_height = 24;

}  // namespace

Viewer::Viewer(Session& session, Display& display, double scale, Theme theme, const Stopwatch& start)
    : session_(session), display_(display), asked_to_open_(start), scale_(scale), since_start_(start), tour_(session) {
  set_theme(theme);
  if (session.sequence) task_ = Task::play;
  recent_ = recent_files();
  picture_name_ = session.free_file("view.png");
  session.ask_for_files = [this](FileKind kind, std::function<void(const Files&)> then) {
    ask_for_files(kind, std::move(then));
  };
}

Viewer::~Viewer() {
  if (tool_) tool_->stop();
}

const std::vector<std::string>& Viewer::tool_names() { return view::tool_names(); }

void Viewer::take_tool(const std::string& name) {
  if (name == tool_name_) {
    task_ = task_of(name);
    return;
  }
  require(!session_.empty, "there is no model to work on: open one first");
  unless_lost(Leaving::tool, name == "none" ? "put it away" : "go on to '" + tool_words(name) + "'",
              [this, name] { change_tool(name); });
}

void Viewer::change_tool(const std::string& name) {
  if (name == tool_name_) return;
  std::unique_ptr<Tool> taken = make_tool(name, session_);
  if (tool_) tool_->stop();
  tool_.reset();
  on_chosen_ = {};  // which may be the tool's
  asking_path_ = false;
  session_.reset_shown();
  tool_ = std::move(taken);
  tool_name_ = name;
  task_ = task_of(name);
  if (!tool_) return;
  if (task_ == Task::photographs) photographs_tool_ = name;
  if (const auto paint = tool_->shown_as()) session_.show_as(*paint);
}

/// What only looks leaves the tool in hand.
void Viewer::take_task(Task task) {
  require(!session_.empty, "there is no model to work on: open one first");
  const auto take = [&](const std::string& tool) {
    if (tool == tool_name_)
      task_ = task;
    else
      unless_lost(Leaving::tool, fmt::format("go on to '{}'", task_words[std::size_t(task)].label),
                  [this, tool, task] {
                    change_tool(tool);
                    task_ = task;
                  });
  };
  const bool own = task_of(tool_name_) == task && tool_;
  if (task != Task::compare && task != Task::picture && std::exchange(wipes_for_task_, false))
    session_.look.wipe = -1;
  switch (task) {
    case Task::compare:
      task_ = task;
      wipe_awaited_ = true;
      wipe_for_task();
      break;
    case Task::look:
    case Task::picture: task_ = task; break;
    case Task::paint: take("filter"); break;
    case Task::photographs: take(own ? tool_name_ : session_.before ? photographs_tool_ : "none"); break;
    case Task::measure: take("geodesic"); break;
    case Task::change: take(own ? tool_name_ : "none"); break;
    case Task::play: take("none"); break;
  }
}

/// Where nothing is changed yet, as soon as something is.
void Viewer::wipe_for_task() {
  if (!has_changed() || !std::exchange(wipe_awaited_, false) || session_.look.wipe >= 0) return;
  wipes_for_task_ = true;
  session_.look.wipe = 0.5;
}

void Viewer::set_theme(Theme theme) {
  theme_ = theme;
  view::set_theme(theme);
}

std::string Viewer::title() const {
  if (session_.empty) return "marquetry";
  const std::string mark = unsaved(Leaving::model).empty() ? "" : "* ";
  return mark + session_.scene->model.path.filename().string() + " - marquetry";
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
  trail_ = display_.trail();
  if (scripted_) trail_.clear();
  ImGui_ImplOpenGL3_NewFrame();
  ImGui::NewFrame();
  layout();
  ImGui::Render();
  with_graphics([&] {
    draw();
    display_.end_frame();
  });
  note_first_pictures();
  last_frame_ = watch.seconds();
  if (scripted_) session_.frames.push_back({watch.seconds() - drawing_, drawing_});
  if (std::exchange(screenshot_asked_, false))
    tried(session_, [&] {
      session_.run.will_write({picture_name_});
      if (picture_of_ == 2)
        screenshot(picture_name_);
      else
        write_picture(picture_name_, Pane(picture_of_), 1 << picture_times_);
      session_.say("wrote " + picture_name_);
      picture_name_ = session_.free_file(session_.name_of(picture_name_));
    });
  if (const std::string now = title(); std::exchange(shown_title_, now) != now)
    display_.set_title(now);
}

/// Also for a picture of what is shown: a window's framebuffer holds nothing once it was shown.
void Viewer::draw() const {
  glBindFramebuffer(GL_FRAMEBUFFER, display_.framebuffer());
  glViewport(0, 0, display_.width(), display_.height());
  const ImVec4& ground = ImGui::GetStyleColorVec4(ImGuiCol_WindowBg);
  glClearColor(ground.x, ground.y, ground.z, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

void Viewer::place_panes() {
  const auto width = float(display_.width()), height = float(display_.height());
  const float panel = session_.empty && !look_ ? 0 : scaled(panel_width);
  const float free = width - panel, top = height - scaled(status_height);
  const bool with_atlas = look_ ? look_->look->has_uvs : session_.scene->atlas.has_value();
  const int left = int(panel), split = with_atlas ? int(panel + 0.6F * free) : int(width);
  surface_at_ = {left, 0, std::max(1, split - left - (with_atlas ? 2 : 0)), std::max(1, int(top))};
  atlas_at_ = {split, 0, std::max(1, int(width) - split), std::max(1, int(top))};
}

void Viewer::layout() {
  const bool looks = looks_at_loading();
  place_panes();
  if (!opened_ && !session_.empty) {
    home();
    home_atlas();
    opened_ = true;
  }
  session_.camera.resize(surface_at_.width, surface_at_.height);
  work();
  for (TextureSet* set : {session_.before.get(), session_.after.get(), session_.result.get()})
    if (set != nullptr) with_graphics([&] { upload(*set); });
  const auto width = float(display_.width()),
             top = float(display_.height()) - scaled(status_height);
  if (looks && session_.empty) {
    look_pane(top);
  } else if (session_.empty) {
    start_pane(width, top);
  } else {
    panel(scaled(panel_width), top);
    surface_pane();
    if (dragging_ == Dragging::working) let_tool_work();  // on what the mouse did, while this is drawn
    if (session_.scene->atlas) atlas_pane();
  }
  show_refusal(width);
  session_.listen();
  status_line(top, width);
  show_keys();
  show_messages();
  path_question();
  ask_before_losing();
  use_keys();  // once fields have what was written before them
}

/// What goes on behind the window, and what comes from outside of it.
void Viewer::work() {
  try {
    play();
    take_loaded();
  } catch (const Error& error) {
    session_.playing = false;
    if (std::exchange(is_first_, false)) first_failure_ = std::current_exception();
    show_error(error.what());
  }
  let_tool_work();
  try {
    take_difference();
  } catch (const Error& error) {
    show_error(error.what());
  }
  go_on_when_saved(std::exchange(tool_failed_, false));
  if (std::exchange(model_to_close_, false)) tried(session_, [&] { close_model(); });
  take_chosen_files();
  if (const std::vector<std::string> files = display_.dropped(); !files.empty())
    tried(session_, [&] { drop(files); });
}

void Viewer::let_tool_work() {
  if (!tool_) return;
  try {
    tool_->frame();
  } catch (const Error& error) {
    tool_failed_ = true;
    show_error(error.what());
  }
}

void Viewer::show_error(const std::string& text) {
  error_ = text;
  session_.refuse(text);
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

/// What was said stays in front for a while, in scripts until the mouse is used; then what is under
/// the mouse is. Words that are too long for a line take several.
void Viewer::status_line(float y, float width) {
  constexpr double seconds = 6;
  std::string message;
  if (scripted_ && !session_.news.empty()) message = session_.news.back().text;
  std::vector<std::string> recent;
  for (const Session::News& one : session_.news)
    if (!scripted_ && one.since.seconds() < seconds && one.text != session_.refusal) recent.push_back(one.text);
  if (recent.size() <= 2)
    for (const std::string& one : recent) message += (message.empty() ? "" : "\n") + one;
  else
    message = fmt::format("{} messages (key M shows them), the last: {}", recent.size(), recent.back());
  std::string words = in_words(pick_, session_.pictures->radius());
  if (const std::string known = tool_ && pick_ ? tool_->reading(pick_) : ""; !known.empty())
    words = known + "  " + words;
  const bool news = !message.empty() && !(scripted_ && mouse_used_since_said_ && !words.empty());
  std::string shown = news ? message : words;
  if (const std::string working = tool_ ? tool_->working() : ""; !working.empty())
    shown = working + (shown.empty() ? "" : "\n") + shown;
  const float lines = ImGui::CalcTextSize(shown.c_str(), nullptr, false, width - scaled(16)).y;
  const float least = scaled(status_height), height = std::max(least, lines + scaled(8));
  ImGui::SetNextWindowPos({0, y + least - height});
  ImGui::SetNextWindowSize({width, height});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(scaled(8), scaled(4)));
  ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, ImVec2(1, 1));
  // In front of the panes, of which several lines cover some.
  ImGui::Begin("status", nullptr,
               (fixed_window & ~ImGuiWindowFlags_NoBringToFrontOnFocus) |
                   ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoInputs |
                   ImGuiWindowFlags_NoFocusOnAppearing);
  ImGui::PopStyleVar(2);
  ImGui::PushTextWrapPos(width - scaled(8));
  const ImU32 colour =
      theme_ == Theme::dark ? IM_COL32(255, 220, 140, 255) : IM_COL32(140, 80, 0, 255);
  if (news) ImGui::PushStyleColor(ImGuiCol_Text, colour);
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

/// Drawn once more, in a canvas of that size.
void Viewer::write_picture(const std::string& path, Pane pane, int times) {
  require_screenshot(path);
  require(!session_.empty, "there is no model to make a picture of: open one first");
  require(pane == Pane::surface || session_.scene->atlas.has_value(),
          "the model has no texture coordinates, so no picture of its texture");
  const Look& look = session_.look;
  const FalseColour scale =
      shows_numbers(look) ? session_.pictures->scale_of(look, session_.shown()) : FalseColour{};
  const ModelPictures::Shown shown{look, scale, session_.before.get(), session_.shown(),
                                   session_.result_colours};
  const Rectangle at = place_of(pane);
  Canvas canvas;
  canvas.resize(at.width * times, at.height * times);
  if (pane == Pane::surface) {
    Turntable camera = session_.camera;
    camera.resize(at.width * times, at.height * times);
    session_.pictures->draw_surface(camera, shown, canvas);
  } else {
    AtlasView view = session_.atlas;
    view.zoom *= times;
    session_.pictures->draw_atlas(view, shown, canvas);
  }
  write_image(path, canvas.read());
}

void require_screenshot(const std::string& path) {
  const std::string extension = lower_extension(path);
  require(names_picture(path) && extension != ".exr",
          fmt::format("{}: found '{}', wanted .png, .jpg or .tif: what is on a screen has 8 bits",
                      path, extension));
}

}  // namespace mq::view

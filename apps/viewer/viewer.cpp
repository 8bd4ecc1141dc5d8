#include "viewer.h"

#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include <backends/imgui_impl_opengl3.h>
#include <algorithm>
#include <cmath>
#include <utility>

#include "controls.h"
#include "mq/base/error.h"
#include "mq/image/resample.h"
#include "mq/io/picture_check.h"
#include "shell/results.h"
#include "tools.h"

namespace mq::view {
namespace {

constexpr float panel_width = 300, status_height = 24;
constexpr ImGuiWindowFlags fixed = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize |
                                   ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse |
                                   ImGuiWindowFlags_NoBringToFrontOnFocus;

/// A window without borders that a picture fills; whether the mouse is in it.
bool picture_window(const char* name, const Viewer::Rectangle& at, GLuint picture) {
  ImGui::SetNextWindowPos({float(at.x), float(at.y)});
  ImGui::SetNextWindowSize({float(at.width), float(at.height)});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(0, 0));
  ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0);
  ImGui::Begin(name, nullptr,
               fixed | ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse);
  ImGui::PopStyleVar(3);
  const ImVec2 size{float(at.width), float(at.height)};
  const ImVec2 corner = ImGui::GetCursorPos();
  ImGui::Image(reinterpret_cast<void*>(std::intptr_t(picture)), size, {0, 1}, {1, 0});
  ImGui::SetCursorPos(corner);
  ImGui::InvisibleButton("mouse", size,
                         ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight |
                             ImGuiButtonFlags_MouseButtonMiddle);
  return ImGui::IsItemHovered() || ImGui::IsItemActive();
}

/// The middle of the pixel of a pane that the mouse is on.
ImVec2 mouse_in(const Viewer::Rectangle& at) {
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  return {mouse.x - float(at.x) + 0.5F, mouse.y - float(at.y) + 0.5F};
}

void outlined_text(ImDrawList* list, ImVec2 at, const char* text) {
  list->AddText({at.x + 1, at.y + 1}, IM_COL32(255, 255, 255, 200), text);
  list->AddText(at, IM_COL32(20, 20, 24, 255), text);
}

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

/// What is left to the graphics, in scripts measured.
template <class Draw>
void Viewer::with_graphics(const Draw& draw) {
  const Stopwatch watch;
  draw();
  drawing_ += watch.seconds();
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

void Viewer::panel(float width, float height) {
  ImGui::SetNextWindowPos({0, 0});
  ImGui::SetNextWindowSize({width - 2, height});
  ImGui::Begin("panel", nullptr, fixed);
  ImGui::PushItemWidth(width * 0.5F);
  const TexturedModel& scene = *session_.scene;
  ImGui::TextUnformatted(scene.model.path.filename().string().c_str());
  ImGui::Text("%d triangles, %d vertices", scene.surface.triangle_count(),
              scene.surface.mesh.vertex_count());
  if (scene.atlas)
    ImGui::Text("%d charts, %d seam edges", int(scene.atlas->charts.size()),
                scene.atlas->seam_count);
  ImGui::Separator();
  view_controls();
  if (session_.sequence) sequence_controls();
  ImGui::Separator();
  if (ImGui::BeginCombo("tool", tool_name_.c_str(), ImGuiComboFlags_HeightLarge)) {
    for (const std::string& name : tool_names())
      if (ImGui::Selectable(name.c_str(), name == tool_name_)) {
        try {
          take_tool(name);
        } catch (const Error& error) {
          session_.say(error.what());
        }
      }
    ImGui::EndCombo();
  }
  if (tool_) {
    ImGui::PushID("tool");  // options have names of their own, such as show
    tool_->panel();
    ImGui::PopID();
    if (tool_->busy()) {
      ImGui::ProgressBar(float(tool_->fraction()), {-1, 0}, tool_->step().c_str());
      if (ImGui::Button("stop")) tool_->cancel();
    }
  }
  loading_controls();
  file_controls();
  ImGui::PopItemWidth();
  ImGui::End();
}

void Viewer::view_controls() {
  Look& look = session_.look;
  for (const char* name : {"front", "right", "back", "left", "top"}) {
    if (ImGui::SmallButton(name)) this->look(parse_view(name));
    ImGui::SameLine();
  }
  if (ImGui::SmallButton("home")) {
    home();
    home_atlas();
  }
  int paint = int(look.paint);
  if (ImGui::BeginCombo("show", paint_names[std::size_t(paint)].c_str(),
                        ImGuiComboFlags_HeightLarge)) {
    for (std::size_t i = 0; i < paint_names.size(); ++i) {
      const std::string lacking = session_.lacking_for(Look::Paint(i));
      const std::string shown = paint_names[i] + (lacking.empty() ? "" : " (no " + lacking + ")");
      if (ImGui::Selectable(shown.c_str(), int(i) == paint,
                            lacking.empty() ? 0 : ImGuiSelectableFlags_Disabled))
        look.paint = Look::Paint(i);
    }
    ImGui::EndCombo();
  }
  ImGui::Checkbox("light", &look.lit);
  ImGui::SameLine();
  ImGui::Checkbox("seams", &look.seams);
  ImGui::SameLine();
  ImGui::Checkbox("wires", &look.wires);
  ImGui::SameLine();
  ImGui::Checkbox("charts", &look.chart_tint);
  if (session_.before && session_.before->holds_light(session_.atlas.texture)) {
    auto stops = float(look.exposure);
    if (ImGui::SliderFloat("exposure", &stops, -10, 10, "%.2f stops", ImGuiSliderFlags_AlwaysClamp))
      look.exposure = stops;
  }
  if (shows_numbers(look)) number_controls();
  if (session_.compares()) {
    bool wiping = look.wipe >= 0;
    if (ImGui::Checkbox("before | after", &wiping)) look.wipe = wiping ? 0.5 : -1;
    if (wiping) {
      auto wipe = float(look.wipe);
      if (ImGui::SliderFloat("wipe", &wipe, 0, 1, "%.2f", ImGuiSliderFlags_AlwaysClamp))
        look.wipe = wipe;
    }
    if (session_.before && session_.before->size() > 1) {
      int texture = session_.atlas.texture;
      if (ImGui::SliderInt("texture", &texture, 0, session_.before->size() - 1, "%d",
                           ImGuiSliderFlags_AlwaysClamp)) {
        session_.atlas.texture = texture;
        home_atlas();
      }
    }
  }
}

void Viewer::sequence_controls() {
  const Sequence& sequence = *session_.sequence;
  int frame = session_.frame;
  ImGui::Separator();
  if (loader_.busy() && asked_frame_ >= 0 && !session_.playing) frame = asked_frame_;
  const std::string number = std::to_string(sequence.number(frame));
  if (ImGui::SliderInt("frame", &frame, 0, sequence.count() - 1, number.c_str(),
                       ImGuiSliderFlags_AlwaysClamp)) {
    try {
      open_frame(frame);
    } catch (const Error& error) {
      session_.say(error.what());
    }
  }
  if (ImGui::Button(session_.playing ? "pause" : "play")) {
    session_.playing = !session_.playing;
    if (!session_.playing) loader_.cancel();
  }
}

void Viewer::open_frame(int frame) {
  require(tool_ == nullptr,
          "a tool works on one frame: put it away, with the tool none, to go to another");
  asked_frame_ = frame;
  loader_.ask(
      "frame " + std::to_string(session_.sequence->number(frame)),
      [sequence = session_.sequence, frame, largest = TextureSet::largest_side()](
          const Progress& progress) { return load_frame(sequence, frame, largest, progress); });
}

namespace {

bool names_mesh(const std::string& file) {
  return names_model(file) || (names_sequence(file) && !names_picture(file));
}

}  // namespace

void Viewer::open(const std::vector<std::string>& files) {
  std::vector<std::string> meshes, pictures;
  for (const std::string& file : files) (names_mesh(file) ? meshes : pictures).push_back(file);
  require(meshes.size() <= 1, fmt::format("{} models were given, and one is shown", meshes.size()));
  OptionValues options(session_.opened.table());
  for (const Option& option : options.table().options())
    if (session_.opened.given(option.name) && option.name != "texture")
      options.set(option.name, session_.opened.texts(option.name));
  if (!meshes.empty()) options.set("mesh", meshes);
  if (!pictures.empty()) options.set("texture", pictures);
  session_.playing = false;
  loader_.cancel();
  loader_.ask(files.front(), [options, &terminal = session_.run.terminal(),
                              largest = TextureSet::largest_side()](const Progress& progress) {
    return load_files(options, terminal, largest, progress);
  });
}

void Viewer::take_loaded() {
  if (!loader_.ready() || !question_.empty()) return;
  const LoadedModel& loaded = loader_.peek();
  if (loaded.opened) {
    const std::string file = loaded.scene->model.path.string();
    unless_lost(
        "show " + file, [this] { adopt(loader_.take()); }, [this] { loader_.cancel(); });
    return;
  }
  // What was loaded ahead stays until its time has come; a tool may have been taken since.
  if (tool_ || loaded.sequence != session_.sequence) return loader_.cancel();
  if (session_.playing && !scripted_ && played_.seconds() < 0.04) return;
  played_ = Stopwatch();
  adopt(loader_.take());
}

void Viewer::adopt(std::unique_ptr<LoadedModel> loaded) {
  const bool other = loaded->opened.has_value();
  if (other) app::will_read_model(session_.run, loaded->scene->model);
  const bool other_mesh = other && loaded->opened->text("mesh") != session_.opened.text("mesh");
  change_tool("none");
  pick_ = {};
  session_.open(std::move(loaded));
  if (!other) return;
  app::describe_input(session_.run, *session_.scene);
  session_.say("opened " + session_.scene->model.path.string());
  place_panes();
  if (other_mesh) home();
  home_atlas();
}

/// The next frame of what is played is loaded while this one is shown, 25 a second; in scripts one
/// for each picture.
void Viewer::play() {
  if (!session_.playing || tool_ || !session_.sequence || loader_.busy()) return;
  open_frame((session_.frame + 1) % session_.sequence->count());
}

/// What dropping files and --screenshot do.
void Viewer::file_controls() {
  ImGui::Separator();
  if (ImGui::InputTextWithHint("open", "a model; pictures", &to_open_,
                               ImGuiInputTextFlags_EnterReturnsTrue))
    tried(session_, [&] {
      const std::vector<std::string> files = parted(to_open_);
      require(!files.empty(), "name a model, or pictures for this one");
      open(files);
    });
  if (ask_to_save("screenshot", screenshot_name_)) screenshot_asked_ = true;
}

/// What is on its way, once it takes longer than a moment.
void Viewer::loading_controls() {
  if (!loader_.busy() || session_.playing) return;
  ImGui::Separator();
  ImGui::TextUnformatted(("loading " + loader_.name()).c_str());
  ImGui::ProgressBar(float(loader_.fraction()), {-1, 0}, loader_.step().c_str());
  if (ImGui::Button("cancel")) loader_.cancel();
}

void Viewer::unless_lost(const std::string& what, std::function<void()> act,
                         std::function<void()> otherwise) {
  const std::string unsaved = tool_ ? tool_->unsaved() : "", saving = tool_ ? tool_->saving() : "";
  if (asking_ == Asking::person && !(unsaved.empty() && saving.empty())) {
    on_yes_ = act;
    on_no_ = otherwise;
    if (saving.empty()) {
      question_ = fmt::format("To {} loses {}, which is not saved.", what, unsaved);
    } else {
      question_ = fmt::format("{} is saved first. To {} at once gives it up.", saving, what);
      on_saved_ = [this, what, act, otherwise] { unless_lost(what, act, otherwise); };
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

void Viewer::close() {
  if (!question_.empty() && !asked_to_close_) answer(false);
  if (question_.empty()) {
    asked_to_close_ = true;
    unless_lost("close the window", [this] { closed_ = true; });
  }
  if (!closed_) display_.stay_open();
}

void Viewer::ask_before_losing() {
  constexpr const char* title = "not saved";
  if (question_.empty()) return;
  if (!ImGui::IsPopupOpen(title)) ImGui::OpenPopup(title);
  const ImVec2 middle{float(display_.width()) / 2, float(display_.height()) / 2};
  ImGui::SetNextWindowPos(middle, ImGuiCond_Always, {0.5F, 0.5F});
  if (!ImGui::BeginPopupModal(title, nullptr,
                              ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove))
    return;
  ImGui::TextUnformatted(question_.c_str());
  const bool yes = ImGui::Button("go on and lose it");
  ImGui::SameLine();
  const bool no = ImGui::Button("stay");
  if (yes || no) {
    ImGui::CloseCurrentPopup();
    answer(yes);
  }
  ImGui::EndPopup();
}

void Viewer::number_controls() {
  Look& look = session_.look;
  if (look.paint == Look::Paint::numbers && session_.before)
    ImGui::SliderInt("channel", &look.channel, 0,
                     std::max(0, std::min(session_.before->channels(0), 4) - 1), "%d",
                     ImGuiSliderFlags_AlwaysClamp);
  ImGui::Checkbox("whole range", &look.automatic_scale);
  if (!look.automatic_scale) {
    float range[2] = {float(look.scale.low), float(look.scale.high)};
    if (ImGui::DragFloat2("range", range, 0.01F) && range[0] < range[1])
      look.scale.low = range[0], look.scale.high = range[1];
  }
  int map = int(look.scale.map);
  if (ImGui::Combo("map", &map, "sequential\0diverging\0")) look.scale.map = FalseColour::Map(map);
  ImGui::SliderInt("isolines", &look.scale.isolines, 0, 100, "%d", ImGuiSliderFlags_AlwaysClamp);
}

/// All that both panes show depends on.
std::vector<double> Viewer::state_of_look(const FalseColour& scale) const {
  const Look& look = session_.look;
  return {double(look.paint),
          double(look.lit),
          double(look.seams),
          double(look.wires),
          double(look.chart_tint),
          look.exposure,
          double(look.channel),
          look.wipe,
          double(scale.map),
          scale.low,
          scale.high,
          double(scale.isolines),
          double(uploads_),
          double(session_.openings),
          double(session_.results)};
}

void Viewer::surface_pane() {
  const Look& look = session_.look;
  const FalseColour scale =
      shows_numbers(look) ? session_.pictures->scale_of(look, session_.shown()) : FalseColour{};
  surface_canvas_.resize(surface_at_.width, surface_at_.height);
  const bool here = picture_window("surface", surface_at_, surface_canvas_.picture());
  if (here || dragging_ != Dragging::nothing) use_surface_mouse();
  std::vector<double> state = state_of_look(scale);
  const Vector3 eye = session_.camera.eye(), back = session_.camera.backward();
  state.insert(state.end(), {eye.x(), eye.y(), eye.z(), back.x(), back.y(), back.z(),
                             session_.camera.view().azimuth, double(surface_at_.width),
                             double(surface_at_.height)});
  if (std::exchange(surface_of_, state) != state)
    with_graphics([&] {
      session_.pictures->draw_surface(
          session_.camera,
          {look, scale, session_.before.get(), session_.shown(), session_.result_colours},
          surface_canvas_);
    });
  mark(pick_);
  if (shows_numbers(look)) show_legend();
  ImGui::End();
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

void Viewer::use_surface_mouse() {
  const ImGuiIO& io = ImGui::GetIO();
  const ImVec2 mouse = mouse_in(surface_at_);
  Turntable& camera = session_.camera;
  pick_ =
      pick_on_surface(*session_.scene, *session_.rays, {session_.shown(), session_.shown_colours()},
                      camera.ray(mouse.x, mouse.y));
  if (pick_.chart >= 0 && pick_.texture != session_.atlas.texture &&
      dragging_ == Dragging::nothing) {
    session_.atlas.texture = pick_.texture;
    home_atlas();
  }
  if (io.MouseWheel != 0) camera.approach(std::exp(0.15 * double(io.MouseWheel)));
  const float wipe = float(session_.look.wipe) * float(surface_at_.width);
  if (ImGui::IsItemClicked(0)) {
    const bool on_wipe = session_.look.wipe >= 0 && std::abs(mouse.x - wipe) < 5;
    dragging_ = on_wipe                                  ? Dragging::wiping
                : io.KeyShift                            ? Dragging::moving
                : tool_ && pick_ && tool_->takes_mouse() ? Dragging::working
                                                         : Dragging::turning;
    if (dragging_ == Dragging::working) tool_->press(pick_);
  } else if (ImGui::IsItemClicked(1)) {
    dragging_ = Dragging::turning;
  } else if (ImGui::IsItemClicked(2)) {
    dragging_ = Dragging::moving;
  }
  const bool held = io.MouseDown[0] || io.MouseDown[1] || io.MouseDown[2];
  const bool moved = io.MouseDelta.x != 0 || io.MouseDelta.y != 0;
  // With the button up the way since the last picture is still to be gone.
  if (dragging_ == Dragging::working && moved) tool_->drag(pick_);
  if (dragging_ == Dragging::wiping && held)
    session_.look.wipe = std::clamp(double(mouse.x) / surface_at_.width, 0.0, 1.0);
  constexpr double degrees_per_pixel = 0.4;
  if (dragging_ == Dragging::turning && moved)
    camera.turn(-degrees_per_pixel * io.MouseDelta.x, degrees_per_pixel * io.MouseDelta.y);
  if (dragging_ == Dragging::moving && moved) camera.move(io.MouseDelta.x, io.MouseDelta.y);
  if (!held) {
    if (dragging_ == Dragging::working) tool_->release();
    dragging_ = Dragging::nothing;
  }
}

void Viewer::home_atlas() {
  if (!session_.scene->atlas) return;
  AtlasView& view = session_.atlas;
  const TextureSize& size = session_.scene->atlas->textures[std::size_t(view.texture)];
  view.zoom =
      0.96 * std::min(atlas_at_.width / double(size.width), atlas_at_.height / double(size.height));
  view.column = size.width / 2.0 - 0.5 - atlas_at_.width / 2.0 / view.zoom;
  view.row = size.height / 2.0 - 0.5 - atlas_at_.height / 2.0 / view.zoom;
}

void Viewer::atlas_pane() {
  const Look& look = session_.look;
  const FalseColour scale =
      shows_numbers(look) ? session_.pictures->scale_of(look, session_.shown()) : FalseColour{};
  atlas_canvas_.resize(atlas_at_.width, atlas_at_.height);
  if (picture_window("atlas", atlas_at_, atlas_canvas_.picture())) use_atlas_mouse();
  const AtlasView& view = session_.atlas;
  std::vector<double> state = state_of_look(scale);
  state.insert(state.end(), {double(view.texture), view.column, view.row, view.zoom,
                             double(atlas_at_.width), double(atlas_at_.height)});
  if (std::exchange(atlas_of_, state) != state)
    with_graphics([&] {
      session_.pictures->draw_atlas(
          view, {look, scale, session_.before.get(), session_.shown(), session_.result_colours},
          atlas_canvas_);
    });
  if (pick_.chart >= 0 && pick_.texture == view.texture) {
    ImDrawList* list = ImGui::GetWindowDrawList();
    const auto at = [&](double column, double row) {
      return ImVec2(float(atlas_at_.x + (column - view.column) * view.zoom),
                    float(atlas_at_.y + (row - view.row) * view.zoom));
    };
    const auto half = std::max(0.5, 2 / view.zoom);
    list->AddRect(at(pick_.x - half, pick_.y - half), at(pick_.x + half, pick_.y + half),
                  IM_COL32(20, 20, 24, 255), 0, 0, 3);
    list->AddRect(at(pick_.x - half, pick_.y - half), at(pick_.x + half, pick_.y + half),
                  IM_COL32(255, 255, 255, 255), 0, 0, 1);
    list->AddCircle(at(pick_.column, pick_.row), 7, IM_COL32(20, 20, 24, 255), 24, 3);
    list->AddCircle(at(pick_.column, pick_.row), 7, IM_COL32(255, 255, 255, 255), 24, 1);
  }
  ImGui::End();
}

void Viewer::use_atlas_mouse() {
  const ImGuiIO& io = ImGui::GetIO();
  const ImVec2 mouse = mouse_in(atlas_at_);
  AtlasView& view = session_.atlas;
  const double column = view.column + mouse.x / view.zoom, row = view.row + mouse.y / view.zoom;
  pick_ = pick_in_atlas(*session_.scene, *session_.triangles_at, session_.shown(), view.texture,
                        column, row);
  if (io.MouseWheel != 0) {
    const double factor = std::exp(0.15 * double(io.MouseWheel));
    view.zoom = std::clamp(view.zoom * factor, 1e-3, 200.0);
    view.column = column - mouse.x / view.zoom;
    view.row = row - mouse.y / view.zoom;
  }
  if (ImGui::IsItemActive()) {
    view.column -= io.MouseDelta.x / view.zoom;
    view.row -= io.MouseDelta.y / view.zoom;
  }
}

/// The place on the surface, the brush around it, and the wipe.
void Viewer::mark(const Pick& pick) const {
  ImDrawList* list = ImGui::GetWindowDrawList();
  double x = 0, y = 0;
  if (pick && session_.camera.shows(pick.point, x, y)) {
    const ImVec2 at{float(surface_at_.x + x), float(surface_at_.y + y)};
    const double depth = (pick.point - session_.camera.eye()).norm();
    const double brush = tool_ ? tool_->brush_radius() : 0;
    const float radius =
        brush > 0 ? float(brush / session_.camera.pixel() * session_.camera.distance() / depth) : 5;
    list->AddCircle(at, radius, IM_COL32(20, 20, 24, 255), 64, 3);
    list->AddCircle(at, radius, IM_COL32(255, 255, 255, 255), 64, 1);
  }
  if (session_.look.wipe >= 0 && session_.compares()) {
    const float column =
        float(surface_at_.x) + float(session_.look.wipe) * float(surface_at_.width);
    const auto bottom = float(surface_at_.y + surface_at_.height);
    list->AddLine({column, float(surface_at_.y)}, {column, bottom}, IM_COL32(20, 20, 24, 255), 1);
    outlined_text(list, {column - 48, float(surface_at_.y) + 6}, "before");
    outlined_text(list, {column + 8, float(surface_at_.y) + 6}, "after");
  }
}

void Viewer::show_legend() {
  const Look& look = session_.look;
  const FalseColour scale = session_.pictures->scale_of(look, session_.shown());
  const std::vector<double> now = {double(look.paint), double(look.channel),
                                   double(scale.map),  scale.low,
                                   scale.high,         double(scale.isolines)};
  if (now != legend_of_) {
    legend_of_ = now;
    LegendOptions wanted;
    wanted.height = std::max(120, surface_at_.height * 3 / 5);
    wanted.text_scale = 1;
    wanted.title = look.paint == Look::Paint::stretch   ? "stretch"
                   : look.paint == Look::Paint::density ? "log2 of area"
                                                        : fmt::format("channel {}", look.channel);
    legend_.show(legend(scale, wanted));
  }
  const ImVec2 corner{float(surface_at_.x + surface_at_.width - legend_.width() - 10),
                      float(surface_at_.y + (surface_at_.height - legend_.height()) / 2)};
  ImGui::GetWindowDrawList()->AddImage(
      reinterpret_cast<void*>(std::intptr_t(legend_.id())), corner,
      {corner.x + float(legend_.width()), corner.y + float(legend_.height())});
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
               (fixed & ~ImGuiWindowFlags_NoBringToFrontOnFocus) | ImGuiWindowFlags_NoScrollbar |
                   ImGuiWindowFlags_NoInputs | ImGuiWindowFlags_NoFocusOnAppearing);
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

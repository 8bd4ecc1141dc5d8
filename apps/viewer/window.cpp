#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <functional>
#include <limits>
#include <set>
#include <string_view>
#include <thread>
#include <utility>

#include <epoxy/gl.h>

#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>

#include "display.h"
#include "mq/base/error.h"

namespace mq::view {
namespace {

std::string last_words() {
  const char* words = nullptr;
  glfwGetError(&words);
  return words == nullptr ? "no reason is given" : words;
}

class Window : public Display {
 public:
  Window(int width, int height, const std::string& title) {
    if (glfwInit() == GLFW_FALSE)
      throw Unsupported(fmt::format(
          "no window can be opened ({}): 'marquetry view' needs a screen, X11's by its DISPLAY; "
          "with --script FILE it needs none, and 'marquetry render' draws pictures without",
          last_words()));
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    window_ = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
    if (window_ == nullptr) {
      const std::string words = last_words();
      glfwTerminate();
      throw Unsupported(fmt::format(
          "the window cannot be opened ({}): the viewer needs OpenGL 3.3; with Mesa's drivers "
          "(libgl1-mesa-dri) any machine has it, LIBGL_ALWAYS_SOFTWARE=1 if need be",
          words));
    }
    glfwSetWindowSizeLimits(window_, 640, 400, GLFW_DONT_CARE, GLFW_DONT_CARE);
    glfwMakeContextCurrent(window_);
    glfwSwapInterval(1);
    glfwSetWindowUserPointer(window_, this);
    glfwSetDropCallback(window_, [](GLFWwindow* window, int count, const char** names) {
      auto* self = static_cast<Window*>(glfwGetWindowUserPointer(window));
      self->dropped_.assign(names, names + count);
    });
    ImGui_ImplGlfw_InitForOpenGL(window_, false);
    listen();
    double x = 0, y = 0;
    glfwGetCursorPos(window_, &x, &y);
    told_ = {float(x), float(y)};
  }

  ~Window() override {
    ImGui_ImplGlfw_Shutdown();
    glfwDestroyWindow(window_);
    glfwTerminate();
  }

  void begin_frame() override {
    glfwPollEvents();
    ImGui_ImplGlfw_NewFrame();
    hand_over();
    ImGuiIO& io = ImGui::GetIO();  // in place of what mouse and buttons are by now
    io.MousePos = {mouse_.x, mouse_.y};
    for (int i = 0; i < buttons; ++i) io.MouseDown[i] = down_[i];
  }
  void end_frame() override { glfwSwapBuffers(window_); }
  unsigned framebuffer() const override { return 0; }
  int width() const override { return size(0); }
  int height() const override { return size(1); }
  bool closing() const override { return glfwWindowShouldClose(window_) != 0; }
  void stay_open() override { glfwSetWindowShouldClose(window_, GLFW_FALSE); }
  std::vector<std::string> dropped() override { return std::exchange(dropped_, {}); }
  std::vector<std::string> keys() override { return std::exchange(keys_, {}); }
  std::vector<Point> trail() override { return std::exchange(trail_, {}); }
  void resize(int width, int height) override {
    int left = 0, top = 0, wide = width, high = height;
    if (GLFWmonitor* const monitor = glfwGetPrimaryMonitor(); monitor != nullptr)
      glfwGetMonitorWorkarea(monitor, &left, &top, &wide, &high);
    glfwSetWindowSize(window_, std::min(width, wide), std::min(height, high));
  }
  void set_title(const std::string& title) override { glfwSetWindowTitle(window_, title.c_str()); }
  double scale() const override {
    float across = 1, down = 1;
    glfwGetWindowContentScale(window_, &across, &down);
    return double(across);
  }
  void wait(double seconds) override { glfwWaitEventsTimeout(seconds); }
  void rest() override {
    if (events_.empty()) glfwWaitEventsTimeout(0.25);
  }

 private:
  static Window& of(GLFWwindow* window) {
    return *static_cast<Window*>(glfwGetWindowUserPointer(window));
  }

  /// What mouse and keyboard did, in its order.
  struct Event {
    enum class What { moves, leaves, button, wheel, key, character } what;
    Point at = {};                                     ///< the mouse; of the wheel, how far
    int code = 0, scancode = 0, action = 0, with = 0;  ///< as GLFW tells them
    unsigned character = 0;
  };
  static constexpr int buttons = 3;
  static constexpr float beyond = std::numeric_limits<float>::lowest();
  static constexpr Point nowhere = {beyond, beyond};  ///< as ImGui has it

  void listen() {
    glfwSetKeyCallback(window_, [](GLFWwindow* window, int key, int scancode, int action, int with) {
      of(window).events_.push_back(
          {.what = Event::What::key, .code = key, .scancode = scancode, .action = action, .with = with});
    });
    glfwSetCharCallback(window_, [](GLFWwindow* window, unsigned character) {
      of(window).events_.push_back({.what = Event::What::character, .character = character});
    });
    glfwSetMouseButtonCallback(window_, [](GLFWwindow* window, int button, int action, int with) {
      if (button >= buttons) return;
      of(window).events_.push_back({.what = Event::What::button,
                                    .at = of(window).told_,
                                    .code = button,
                                    .action = action,
                                    .with = with});
    });
    glfwSetCursorPosCallback(window_, [](GLFWwindow* window, double x, double y) {
      of(window).told_ = {float(x), float(y)};
      of(window).events_.push_back({.what = Event::What::moves, .at = of(window).told_});
    });
    glfwSetScrollCallback(window_, [](GLFWwindow* window, double x, double y) {
      of(window).events_.push_back({.what = Event::What::wheel, .at = {float(x), float(y)}});
    });
    glfwSetCursorEnterCallback(window_, [](GLFWwindow* window, int entered) {
      ImGui_ImplGlfw_CursorEnterCallback(window, entered);
      if (entered == GLFW_FALSE) of(window).events_.push_back({.what = Event::What::leaves});
    });
    glfwSetWindowFocusCallback(window_, ImGui_ImplGlfw_WindowFocusCallback);
  }

  /// What of this picture was handed over already, which says whether the next event can be too.
  struct Handed {
    bool button = false, wheel = false, text = false;
    std::set<int> keys = {};  ///< such as write nothing
  };

  /// ImGui looks at the state of mouse and keys once for each picture. However slow pictures are, each press, letting
  /// go and key is in one of its own, at the place where the mouse was then, and keys come after what was written
  /// before them. What is written after Ctrl + O waits for the box that it opens.
  void hand_over() {
    if (pictures_until_box_ > 0 && pictures_until_box_-- > 0) return;
    Handed handed;
    while (!events_.empty() && fits(events_.front(), handed)) {
      const Event event = events_.front();
      events_.pop_front();
      take(event, handed);
    }
  }

  static bool writes(const Event& event) {
    const bool printable = event.code >= GLFW_KEY_SPACE && event.code <= GLFW_KEY_GRAVE_ACCENT;
    return printable && (event.with & (GLFW_MOD_CONTROL | GLFW_MOD_ALT | GLFW_MOD_SUPER)) == 0;
  }

  static bool is_modifier(int key) { return key >= GLFW_KEY_LEFT_SHIFT && key <= GLFW_KEY_RIGHT_SUPER; }

  static bool fits(const Event& event, const Handed& handed) {
    switch (event.what) {
      case Event::What::moves:
      case Event::What::leaves: return !handed.button && !handed.wheel;
      case Event::What::button: return !handed.button && !handed.wheel && !handed.text && handed.keys.empty();
      case Event::What::wheel: return !handed.button;
      case Event::What::character: return !handed.button && handed.keys.empty();
      case Event::What::key:
        if (writes(event) || is_modifier(event.code)) return !handed.button && handed.keys.empty();
        return !handed.button && !handed.text && !handed.keys.contains(event.code);
    }
    return true;
  }

  void take(const Event& event, Handed& handed) {
    switch (event.what) {
      case Event::What::moves:
        mouse_ = event.at;
        if (down_[0]) trail_.push_back(mouse_);
        break;
      case Event::What::leaves:
        if (std::ranges::none_of(down_, std::identity())) mouse_ = nowhere;
        break;
      case Event::What::button:
        handed.button = true;
        mouse_ = event.at;
        down_[event.code] = event.action == GLFW_PRESS;
        if (event.code == GLFW_MOUSE_BUTTON_LEFT && event.action == GLFW_PRESS) trail_ = {mouse_};
        break;
      case Event::What::wheel:
        handed.wheel = true;
        ImGui_ImplGlfw_ScrollCallback(window_, double(event.at.x), double(event.at.y));
        break;
      case Event::What::character:
        handed.text = true;
        ImGui_ImplGlfw_CharCallback(window_, event.character);
        if (event.character > ' ' && event.character < 127) keys_.emplace_back(1, char(event.character));
        break;
      case Event::What::key:
        ImGui_ImplGlfw_KeyCallback(window_, event.code, event.scancode, event.action, event.with);
        if (!writes(event) && !is_modifier(event.code)) handed.keys.insert(event.code);
        note_key(event);
        break;
    }
  }

  /// Keys of the window's own.
  void note_key(const Event& event) {
    if (event.action == GLFW_RELEASE) return;
    if (event.code == GLFW_KEY_ESCAPE) keys_.emplace_back("escape");
    if (event.code == GLFW_KEY_ENTER || event.code == GLFW_KEY_KP_ENTER) keys_.emplace_back("return");
    if (event.code == GLFW_KEY_F1) keys_.emplace_back("?");
    const char* const letter = glfwGetKeyName(event.code, event.scancode);
    if ((event.with & GLFW_MOD_CONTROL) == 0 || letter == nullptr) return;
    if (std::string_view(letter) == "o") pictures_until_box_ = 3;  // appears, has the keyboard, asks for text
    keys_.push_back(((event.with & GLFW_MOD_SHIFT) ? "ctrl+shift+" : "ctrl+") + std::string(letter));
  }

  int size(int side) const {
    int sides[2] = {0, 0};
    glfwGetFramebufferSize(window_, &sides[0], &sides[1]);
    return sides[side];
  }

  GLFWwindow* window_ = nullptr;
  std::vector<std::string> dropped_;
  std::vector<std::string> keys_;
  std::vector<Point> trail_;
  std::deque<Event> events_;  ///< that are still to be handed over
  int pictures_until_box_ = 0;
  Point mouse_ = nowhere;
  Point told_ = nowhere;  ///< by the last move; asked for, GLFW tells where the mouse is by now
  bool down_[buttons] = {};
};

}  // namespace

void Display::wait(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

/// By the names that Mesa's renderers on processors have.
bool Display::draws_on_cores() const {
  if (on_cores_ >= 0) return on_cores_ != 0;
  const auto* const name = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  const std::string_view renderer = name == nullptr ? "" : name;
  const auto is = [&](std::string_view word) { return renderer.find(word) != renderer.npos; };
  on_cores_ = int(is("llvmpipe") || is("softpipe") || is("SWR"));
  return on_cores_ != 0;
}

std::unique_ptr<Display> open_window(int width, int height, const std::string& title) {
  return std::make_unique<Window>(width, height, title);
}

}  // namespace mq::view

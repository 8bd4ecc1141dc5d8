#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
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
    listen();
    ImGui_ImplGlfw_InitForOpenGL(window_, true);  // which goes on calling these
  }

  ~Window() override {
    ImGui_ImplGlfw_Shutdown();
    glfwDestroyWindow(window_);
    glfwTerminate();
  }

  void begin_frame() override {
    glfwPollEvents();
    ImGui_ImplGlfw_NewFrame();
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
  void rest() override { glfwWaitEventsTimeout(0.25); }

 private:
  static Window& of(GLFWwindow* window) {
    return *static_cast<Window*>(glfwGetWindowUserPointer(window));
  }

  /// To what ImGui does not keep: each key, and each place of the mouse.
  void listen() {
    glfwSetKeyCallback(
        window_, [](GLFWwindow* window, int key, int scancode, int action, int with) {
          if (action == GLFW_RELEASE) return;
          if (key == GLFW_KEY_ESCAPE) of(window).keys_.emplace_back("escape");
          if (key == GLFW_KEY_ENTER || key == GLFW_KEY_KP_ENTER)
            of(window).keys_.emplace_back("return");
          if (key == GLFW_KEY_F1) of(window).keys_.emplace_back("?");
          const char* const letter = glfwGetKeyName(key, scancode);
          if ((with & GLFW_MOD_CONTROL) == 0 || letter == nullptr) return;
          of(window).keys_.push_back(((with & GLFW_MOD_SHIFT) ? "ctrl+shift+" : "ctrl+") +
                                     std::string(letter));
        });
    glfwSetCharCallback(window_, [](GLFWwindow* window, unsigned character) {
      if (character > ' ' && character < 127) of(window).keys_.emplace_back(1, char(character));
    });
    glfwSetMouseButtonCallback(window_, [](GLFWwindow* window, int button, int action, int) {
      if (button != GLFW_MOUSE_BUTTON_LEFT || action != GLFW_PRESS) return;
      double x = 0, y = 0;
      glfwGetCursorPos(window, &x, &y);
      of(window).trail_ = {{float(x), float(y)}};
    });
    glfwSetCursorPosCallback(window_, [](GLFWwindow* window, double x, double y) {
      if (glfwGetMouseButton(window, GLFW_MOUSE_BUTTON_LEFT) == GLFW_PRESS)
        of(window).trail_.push_back({float(x), float(y)});
    });
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
};

}  // namespace

std::unique_ptr<Display> open_window(int width, int height, const std::string& title) {
  return std::make_unique<Window>(width, height, title);
}

}  // namespace mq::view

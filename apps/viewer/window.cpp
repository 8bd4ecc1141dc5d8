#include <fmt/format.h>
#include <imgui.h>

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
    glfwSetKeyCallback(
        window_, [](GLFWwindow* window, int key, int scancode, int action, int with) {
          const char* const name = glfwGetKeyName(key, scancode);
          if (action == GLFW_RELEASE || (with & GLFW_MOD_CONTROL) == 0 || name == nullptr) return;
          auto* self = static_cast<Window*>(glfwGetWindowUserPointer(window));
          const std::string letter = name;
          if (letter == "z") self->keys_.push_back((with & GLFW_MOD_SHIFT) ? Key::redo : Key::undo);
          if (letter == "y") self->keys_.push_back(Key::redo);
        });
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
  std::vector<Key> keys() override { return std::exchange(keys_, {}); }
  void rest() override { glfwWaitEventsTimeout(0.25); }

 private:
  int size(int side) const {
    int sides[2] = {0, 0};
    glfwGetFramebufferSize(window_, &sides[0], &sides[1]);
    return sides[side];
  }

  GLFWwindow* window_ = nullptr;
  std::vector<std::string> dropped_;
  std::vector<Key> keys_;
};

}  // namespace

std::unique_ptr<Display> open_window(int width, int height, const std::string& title) {
  return std::make_unique<Window>(width, height, title);
}

}  // namespace mq::view

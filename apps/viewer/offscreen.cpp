// A context without a screen: EGL on Mesa's surfaceless platform, or on the first device there is.
#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <fmt/format.h>
#include <imgui.h>

#include "display.h"
#include "mq/base/error.h"

namespace mq::view {
namespace {

EGLDisplay first_display() {
  const auto start = [](EGLenum platform, void* native) -> EGLDisplay {
    const EGLDisplay display = eglGetPlatformDisplayEXT(platform, native, nullptr);
    return display != EGL_NO_DISPLAY && eglInitialize(display, nullptr, nullptr) ? display
                                                                                 : EGL_NO_DISPLAY;
  };
  if (epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless"))
    if (const EGLDisplay display = start(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY))
      return display;
  if (epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_device")) {
    EGLDeviceEXT device = nullptr;
    EGLint count = 0;
    if (eglQueryDevicesEXT(1, &device, &count) && count > 0)
      return start(EGL_PLATFORM_DEVICE_EXT, device);
  }
  return EGL_NO_DISPLAY;
}

[[noreturn]] void refuse(const std::string& what) {
  throw Unsupported(
      fmt::format("there is no OpenGL 3.3 without a screen ({}): install Mesa's drivers (libegl1, "
                  "libgl1-mesa-dri)",
                  what));
}

class Offscreen : public Display {
 public:
  Offscreen(int width, int height) : width_(width), height_(height) {
    if (!epoxy_has_egl()) refuse("libEGL is not there");
    display_ = first_display();
    if (display_ == EGL_NO_DISPLAY) refuse("EGL finds no platform that needs none");
    eglBindAPI(EGL_OPENGL_API);
    const EGLint wanted[] = {EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
    EGLConfig config = nullptr;
    EGLint count = 0;
    eglChooseConfig(display_, wanted, &config, 1, &count);
    const EGLint version[] = {EGL_CONTEXT_MAJOR_VERSION,
                              3,
                              EGL_CONTEXT_MINOR_VERSION,
                              3,
                              EGL_CONTEXT_OPENGL_PROFILE_MASK,
                              EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                              EGL_NONE};
    context_ =
        count > 0 ? eglCreateContext(display_, config, EGL_NO_CONTEXT, version) : EGL_NO_CONTEXT;
    if (context_ == EGL_NO_CONTEXT ||
        !eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_)) {
      eglTerminate(display_);
      refuse("EGL makes no context for it");
    }
    glGenFramebuffers(1, &framebuffer_);
    glGenRenderbuffers(1, &colour_);
    glBindRenderbuffer(GL_RENDERBUFFER, colour_);
    glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, width, height);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, colour_);
  }

  ~Offscreen() override {
    glDeleteFramebuffers(1, &framebuffer_);
    glDeleteRenderbuffers(1, &colour_);
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, context_);
    eglTerminate(display_);
  }

  void begin_frame() override {
    ImGuiIO& io = ImGui::GetIO();
    io.DisplaySize = {float(width_), float(height_)};
    io.DeltaTime = 1.0F / 60;  // of a frame, so that sessions are the same however long they take
  }
  void end_frame() override { glFinish(); }
  unsigned framebuffer() const override { return framebuffer_; }
  int width() const override { return width_; }
  int height() const override { return height_; }

 private:
  int width_, height_;
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
  GLuint framebuffer_ = 0, colour_ = 0;
};

}  // namespace

std::unique_ptr<Display> open_offscreen(int width, int height) {
  return std::make_unique<Offscreen>(width, height);
}

}  // namespace mq::view

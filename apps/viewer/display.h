#pragma once
/// Where the viewer draws: a window, or memory.

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace mq::view {

/// Has an OpenGL 3.3 context, current on the thread that made it, and feeds ImGui.
class Display {
 public:
  virtual ~Display() = default;

  /// Takes what mouse and keyboard did; a frame of ImGui may begin.
  virtual void begin_frame() = 0;
  /// Shows what was drawn.
  virtual void end_frame() = 0;
  /// The framebuffer of its picture, and its size in pixels.
  virtual unsigned framebuffer() const = 0;
  virtual int width() const = 0;
  virtual int height() const = 0;

  virtual bool closing() const { return false; }
  /// It was asked to close, and is not to.
  virtual void stay_open() {}
  /// Files that were dropped on it since the last call.
  virtual std::vector<std::string> dropped() { return {}; }
  /// Keys that were pressed since the last call, also where they were let go at once: what they write,
  /// "?", or their names, "escape", with "ctrl+" and "shift+" before letters that write nothing.
  virtual std::vector<std::string> keys() { return {}; }
  /// A way of the mouse with the left button down: from the place where it went down, or was last.
  struct Point {
    float x = 0, y = 0;  ///< pixels
  };
  /// All places of it since the last call, however few pictures there were meanwhile.
  virtual std::vector<Point> trail() { return {}; }
  /// So large, or as large as the screen has room for.
  virtual void resize(int, int) {}
  /// Of the window.
  virtual void set_title(const std::string&) {}
  /// Pixels of the screen for one of a common screen, 1 where nothing is known.
  virtual double scale() const { return 1; }
  /// Waits for something to happen, a moment at most.
  virtual void rest() {}
  /// So many seconds at most.
  virtual void wait(double seconds);
  /// Whether there is no graphics card: what draws wants the same cores as all else.
  bool draws_on_cores() const;

 private:
  mutable int on_cores_ = -1;  ///< 0 or 1 once it was asked for
};

/// Throws `Unsupported` with the remedy where there is no screen or no OpenGL 3.3.
std::unique_ptr<Display> open_window(int width, int height, const std::string& title);
std::unique_ptr<Display> open_offscreen(int width, int height);

}  // namespace mq::view

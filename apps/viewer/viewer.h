#pragma once
/// The window: a panel with what can be set, the surface, the texture, and a line about what is
/// under the mouse.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "display.h"
#include "gl.h"
#include "mq/base/stopwatch.h"
#include "session.h"
#include "tool.h"

namespace mq::view {

/// What a script does with mouse and wheel, in place of a person.
struct ScriptedInput {
  float x = -1, y = -1;  ///< pixels of the window
  bool left = false, right = false, middle = false;
  float wheel = 0;
};

enum class Pane { surface, atlas };

class Viewer {
 public:
  /// ImGui has a context, and the display's OpenGL context is current.
  Viewer(Session& session, Display& display);
  ~Viewer();

  /// Takes input, lets the tool work, draws everything.
  void frame(const ScriptedInput* scripted = nullptr);

  /// Writes what the last frame drew, or one pane of it. Throws as `require_screenshot` does.
  void screenshot(const std::string& path, std::optional<Pane> pane = {}) const;

  struct Rectangle {
    int x = 0, y = 0, width = 1, height = 1;
  };
  Rectangle place_of(Pane pane) const { return pane == Pane::surface ? surface_at_ : atlas_at_; }

  void home() {
    session_.camera.look(session_.scene->surface.mesh, {}, surface_at_.width, surface_at_.height);
  }
  void look(const View& view) {
    session_.camera.look(session_.scene->surface.mesh, view, surface_at_.width, surface_at_.height);
  }
  /// The whole texture.
  void home_atlas();

  /// Begins to load a model, or other textures for the one that is open, which is shown until all
  /// of it is there. Throws `InvalidInput` where the files are not one model and its textures.
  void open(const std::vector<std::string>& files);

  /// Begins to load a frame of the session's sequence, counted from 0. Throws `InvalidInput` while
  /// a tool is in hand.
  void open_frame(int frame);

  /// Takes over what is loaded. Throws why it could not be loaded; what was open stays then.
  void take_loaded();
  bool loading() const { return loader_.busy(); }
  void cancel_loading() { loader_.cancel(); }

  /// Whether something goes on that the next frame should show.
  bool busy() const { return loader_.busy() || (tool_ && tool_->busy()); }

  /// Who is asked before something unsaved is lost.
  enum class Asking { nobody, person };
  void set_asking(Asking asking) { asking_ = asking; }
  /// What a person is asked at the moment; empty: nothing.
  const std::string& question() const { return question_; }
  /// The answer: whether to go on, and lose it.
  void answer(bool go_on);

  /// Whether what a person wants goes on by itself once a file is saved.
  bool waits() const { return bool(on_saved_); }

  /// The window was asked to close: it is `closed` then, or once a person has said that it may be.
  void close();
  bool closed() const { return closed_; }

  const Pick& pick() const { return pick_; }

  /// What went wrong in a tool since the last call; empty: nothing.
  std::string error() { return std::exchange(error_, {}); }

  /// Names of the tools; "none" is looking alone.
  static const std::vector<std::string>& tool_names();
  /// Asks first where what the one in hand made is not saved.
  void take_tool(const std::string& name);
  Tool* tool() { return tool_.get(); }

 private:
  // viewer.cpp
  Image<float> picture() const;
  void layout();
  void place_panes();
  /// What is left to the graphics, in scripts measured.
  template <class Draw>
  void with_graphics(const Draw& draw) {
    const Stopwatch watch;
    draw();
    drawing_ += watch.seconds();
  }
  void upload(TextureSet& set);
  void draw() const;
  void change_tool(const std::string& name);
  void use_keys();
  void status_line(float y, float width);

  // viewer_panel.cpp
  void panel(float width, float height);
  void view_controls();
  void number_controls();
  void sequence_controls();
  void loading_controls();
  void file_controls();

  // viewer_panes.cpp
  std::vector<double> state_of_look(const FalseColour& scale) const;
  void surface_pane();
  void atlas_pane();
  void use_surface_mouse();
  void use_atlas_mouse();
  void mark(const Pick& pick) const;
  void show_legend();

  // viewer_loading.cpp
  void play();
  void adopt(std::unique_ptr<LoadedModel> loaded);

  // viewer_questions.cpp
  void ask_before_losing();
  void unless_lost(const std::string& what, std::function<void()> act,
                   std::function<void()> otherwise = {});
  void go_on_when_saved(bool failed);

  Session& session_;
  Display& display_;
  Canvas surface_canvas_, atlas_canvas_;
  Picture legend_;
  std::vector<double> legend_of_, surface_of_, atlas_of_;  ///< what is drawn there
  Stopwatch played_;                                       ///< since the last frame that was played
  double drawing_ = 0;                                     ///< seconds, of this frame
  int uploads_ = 0;                                        ///< how often textures changed
  Rectangle surface_at_, atlas_at_;
  Pick pick_;
  enum class Dragging {
    nothing,
    turning,
    moving,
    working,
    moving_atlas,
    wiping
  } dragging_ = Dragging::nothing;
  std::unique_ptr<Tool> tool_;
  std::string tool_name_ = "none";
  std::string error_;
  Loader loader_;
  int asked_frame_ = -1;  ///< of the sequence, that is being loaded
  Asking asking_ = Asking::person;
  std::string question_;
  std::function<void()> on_yes_, on_no_;
  std::function<void()>
      on_saved_;  ///< the question is whether to wait for it; nothing: it is another
  bool closed_ = false, asked_to_close_ = false;
  std::string to_open_, screenshot_name_ = Session::free_file("view.png");
  bool screenshot_asked_ = false;
  bool opened_ = false, scripted_ = false;
  bool mouse_used_since_said_ = false;  ///< by a script
  int said_ = 0;                        ///< of the session's messages, when that was found
};

/// Throws `InvalidInput` where a name is not that of a picture of 8 bits: PNG, JPEG or TIFF.
void require_screenshot(const std::string& path);

}  // namespace mq::view

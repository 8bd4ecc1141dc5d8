#pragma once
/// The window: a panel with what can be set, the surface, the texture, and a line about what is
/// under the mouse.

#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "difference_tour.h"
#include "display.h"
#include "file_chooser.h"
#include "gl.h"
#include "mq/base/stopwatch.h"
#include "mq/io/temporary_folder.h"
#include "session.h"
#include "tasks.h"
#include "theme.h"
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
  /// ImGui has a context, with sizes for `scale`, and the display's OpenGL context is current. `start` is when the
  /// program was begun.
  Viewer(Session& session, Display& display, double scale, Theme theme, const Stopwatch& start);
  ~Viewer();

  /// Takes input, lets the tool work, draws everything.
  void frame(const ScriptedInput* scripted = nullptr);

  /// Writes what the last frame drew, or one pane of it. Throws as `require_screenshot` does.
  void screenshot(const std::string& path, std::optional<Pane> pane = {}) const;
  /// Writes what a pane shows, without marks, in `times` as many pixels each way.
  void write_picture(const std::string& path, Pane pane, int times);

  struct Rectangle {
    int x = 0, y = 0, width = 1, height = 1;
  };
  Rectangle place_of(Pane pane) const { return pane == Pane::surface ? surface_at_ : atlas_at_; }

  void home() { look({}); }
  /// The whole model from there, the upright axis as it was chosen.
  void look(View view) {
    view.up = up_;
    session_.camera.look(session_.scene->surface.mesh, view, surface_at_.width, surface_at_.height);
  }
  void set_up(View::Up up) {
    up_ = up;
    home();
  }
  /// The whole texture.
  void home_atlas();
  /// A place of a texture in the middle, so many pixels per texel.
  void look_at_texel(int texture, double column, double row, double zoom);

  /// Begins to load a model, or other textures for the one that is open, which is shown until all
  /// of it is there. Throws `InvalidInput` where the files are not one model and its textures.
  void open(const std::vector<std::string>& files);

  /// No model is open then, and the window offers to open one. Asks first where something is not saved.
  void close_model();

  /// The same of the model of the command line, while the window is empty. What keeps it from being shown is thrown by
  /// `rethrow_first`, as there is nothing to show then.
  void open_first();
  void rethrow_first();

  /// What files do that are dropped on the window: cameras and photographs are for the tool in hand that asks for
  /// them, all else is opened.
  void drop(const std::vector<std::string>& files);

  /// Begins to make a sample, which is then opened.
  void open_sample(const std::string& name);

  /// Keeps what is open in mind for another day (`recent_files`).
  void remember_opened();
  const std::vector<std::string>& recent() const { return recent_; }

  /// Begins to load a frame of the session's sequence, counted from 0. Throws `InvalidInput` while
  /// a tool is in hand.
  void open_frame(int frame);

  /// Takes over what is loaded. Throws why it could not be loaded; what was open stays then.
  void take_loaded();
  bool loading() const { return loader_.busy(); }
  void cancel_loading();

  /// Between two pictures while something goes on: a renderer that draws on the processor's cores leaves two thirds of
  /// them to it, until it has something to show.
  void pace();

  /// Whether something goes on that the next frame should show.
  bool busy() const { return loader_.busy() || tour_.busy() || (tool_ && tool_->busy()); }

  /// Who is asked before something unsaved is lost.
  enum class Asking { nobody, person };
  void set_asking(Asking asking) { asking_ = asking; }
  /// What a person is asked at the moment; empty: nothing.
  const std::string& question() const { return question_; }
  /// The answer: whether to go on, and lose it.
  void answer(bool go_on);
  /// Another answer: to save it first, and then to go on. Throws `InvalidInput` where nothing is asked
  /// that saving helps with.
  void answer_save();
  /// Another one: that it becomes the model's texture first. Throws where it is no texture, or the model is left.
  void answer_keep();
  /// What the tool in hand made becomes the model's texture, and the tool begins anew with that. Throws where it
  /// made none.
  void keep();

  /// Whether what a person wants goes on by itself once a file is saved.
  bool waits() const { return bool(on_saved_); }

  /// The window was asked to close: it is `closed` then, or once a person has said that it may be.
  void close();
  bool closed() const { return closed_; }

  /// The window's: what is open, with a mark where something is not saved.
  std::string title() const;
  /// What a person wants to do; takes a tool for it where it needs another one.
  void take_task(Task task);
  Task task() const { return task_; }
  void set_theme(Theme theme);
  /// The tool in hand takes strokes back, or does them again, until so many are done.
  void go_to_stroke(std::size_t count);
  /// Looks where the textures differ most from those that were opened, and at the next such place when asked again;
  /// once it is found.
  void look_at_difference();
  bool looks_for_difference() const { return tour_.busy(); }
  /// Whether there is another texture on the right of the wipe than on its left.
  bool has_changed() const { return tool_ && tool_->has_changed(); }
  /// Takes over the place that was looked for.
  void take_difference();
  /// Puts other textures on the right of the wipe.
  void compare_with(const std::vector<std::string>& files);
  /// What a key does: "?", "ctrl+s", "f". False where it does nothing.
  bool use_key(const std::string& key);

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
  void work();
  void let_tool_work();
  void show_error(const std::string& text);
  void status_line(float y, float width);
  float scaled(float pixels) const { return pixels * float(scale_); }

  // viewer_keys.cpp
  void use_keys();
  bool use_command_key(const std::string& key);
  bool end_what_goes_on();
  void show_keys();
  void show_messages();

  // viewer_start.cpp
  void start_pane(float width, float height);
  void open_controls();
  void sample_controls();
  void recent_controls();
  using Files = std::vector<std::string>;
  void ask_for_files(FileKind kind, std::function<void(const Files&)> then);
  void ask_for_model() {
    ask_for_files(FileKind::models, [this](const Files& files) { open(files); });
  }
  void take_chosen_files();
  void path_question();
  void take_path();
  void show_refusal(float width);

  // viewer_first_look.cpp
  bool has_something_to_show();
  bool looks_at_loading();
  void look_pane(float height);
  void look_surface();
  void look_texture();
  void note_first_pictures();

  // viewer_panel.cpp
  void panel(float width, float height);
  void task_controls();
  void tool_controls();
  void history_controls();
  void loading_controls();
  void panel_footer();

  // viewer_tasks.cpp
  void look_controls();
  void more_look_controls();
  void number_controls();
  void wipe_controls();
  void compare_controls();
  void difference_controls();
  void photograph_controls();
  void play_controls();
  void picture_controls();
  void change_controls();

  // viewer_panes.cpp
  std::vector<double> state_of_look(const FalseColour& scale) const;
  void surface_pane();
  void atlas_pane();
  void use_surface_mouse();
  Pick pick_at(const Display::Point& point) const;
  void work_along();
  void use_atlas_mouse();
  void mark(const Pick& pick) const;
  void show_legend();

  // viewer_keeping.cpp
  void keep_and_go_on(std::function<void()> act);
  void open_kept(const Session::Kept& kept, std::function<void()> act);
  void adopt_kept();
  void kept_controls();

  // viewer_loading.cpp
  void play();
  void adopt(std::unique_ptr<LoadedModel> loaded);

  // viewer_questions.cpp
  void ask_before_losing();
  enum class Leaving { tool, model };  ///< what is no more once a person goes on
  void unless_lost(Leaving leaving, const std::string& what, std::function<void()> act,
                   std::function<void()> otherwise = {});
  std::string unsaved(Leaving leaving) const;
  bool can_keep() const;
  void save_kept();
  void go_on_when_saved(bool failed);
  void save_and_go_on();

  Session& session_;
  Display& display_;
  Canvas surface_canvas_, atlas_canvas_;
  Picture legend_;
  std::vector<double> legend_of_, surface_of_, atlas_of_;  ///< what is drawn there
  Stopwatch asked_to_open_;                                ///< since a model was asked for
  Stopwatch played_;                                       ///< since the last frame that was played
  double drawing_ = 0;                                     ///< seconds, of this frame
  double last_frame_ = 0;                                  ///< seconds, in all
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
  std::vector<Display::Point> trail_;  ///< of the mouse since the last picture
  Display::Point worked_at_;           ///< where the tool was with it last
  std::unique_ptr<Tool> tool_;
  std::string tool_name_ = "none";
  std::string photographs_tool_ = "texture";  ///< that was taken last for photographs
  Task task_ = Task::look;
  View::Up up_ = View::Up::y;
  double scale_;
  Theme theme_;
  std::string shown_title_;
  FileChooser chooser_;
  std::function<void(const std::vector<std::string>&)> on_chosen_;  ///< files that a person is asked for
  FileKind asked_kind_ = FileKind::models;
  std::map<FileKind, std::string> chosen_in_;  ///< the folders of files that were chosen last
  bool asking_path_ = false, keys_shown_ = false, messages_shown_ = false;
  bool wipes_for_task_ = false;  ///< the wipe is there because of the task `compare`
  bool wipe_awaited_ = false;    ///< until there is something to compare
  void wipe_for_task();
  std::string error_;
  /// A look as the graphics have it.
  struct ShownLook {
    std::unique_ptr<FirstLook> look;
    ModelPictures pictures;
    Picture picture = {};

    explicit ShownLook(std::unique_ptr<FirstLook> one) : look(std::move(one)), pictures(look->scene, std::move(*look->drawn)) {}
  };
  std::unique_ptr<ShownLook> look_;  ///< at what is being loaded
  bool turned_ = false;              ///< by hand, while a look was shown
  bool is_first_ = false;            ///< the model of the command line is being loaded
  bool tool_failed_ = false;         ///< since what waits for it was told
  std::exception_ptr first_failure_;
  Stopwatch since_start_;            ///< of the program
  Loader loader_;
  DifferenceTour tour_;
  int asked_frame_ = -1;  ///< of the sequence, that is being loaded
  Asking asking_ = Asking::person;
  std::string question_;
  std::function<void()> on_yes_, on_no_;
  Leaving leaving_ = Leaving::tool;  ///< what is asked for
  std::unique_ptr<TemporaryFolder> kept_folder_;
  int kept_ = 0;                                               ///< how often something was
  std::optional<std::pair<Session::Kept, std::function<void()>>> keeping_;  ///< on its way, and what is done then
  std::function<void()>
      on_saved_;  ///< the question is whether to wait for it; nothing: it is another
  bool closed_ = false, asked_to_close_ = false;
  bool model_to_close_ = false;  ///< before the next picture
  std::string to_open_, to_compare_, picture_name_;
  std::vector<std::string> recent_;
  int picture_of_ = 0, picture_times_ = 0;  ///< model, texture or window; 1, 2 or 4 times
  bool screenshot_asked_ = false;
  bool opened_ = false, scripted_ = false;
  bool mouse_used_since_said_ = false;  ///< by a script
  int said_ = 0;                        ///< of the session's messages, when that was found
};

/// Throws `InvalidInput` where a name is not that of a picture of 8 bits: PNG, JPEG or TIFF.
void require_screenshot(const std::string& path);

}  // namespace mq::view

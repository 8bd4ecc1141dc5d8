#pragma once
/// Any verb that makes textures, or colours at vertices: its options as sliders, its result beside
/// the textures or colours as they were.

#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "background.h"
#include "mq/io/temporary_folder.h"
#include "session.h"
#include "tool.h"

namespace mq::view {

/// The verb itself runs, behind the window, once that is asked for and whenever an option was changed.
///
/// Of models without pictures geodesic, lic and react need the shape alone, and filter, denoise and
/// shock work on colours at vertices: what verbs write into a model's file is then shown as its
/// colours.
class VerbTool : public Tool {
 public:
  /// Throws `InvalidInput`, in the verb's words, where the verb refuses the model.
  VerbTool(const std::string& verb, Session& session);
  ~VerbTool() override;

  std::string name() const override { return verb_; }
  void panel() override;
  void press(const Pick&) override {}
  void drag(const Pick&) override {}
  void release() override {}
  bool command(const std::vector<std::string>& words) override;
  void frame() override;
  std::optional<Look::Paint> shown_as() const override;
  bool busy() const override {
    return background_.busy() || (stale_ && !stopped_) || !saves_.empty();
  }
  double fraction() const override { return background_.fraction(); }
  std::string step() const override { return background_.step(); }
  std::string working() const override;
  void stop() override;
  void cancel() override;
  void save() override { save(texture_name_); }
  std::string unsaved() const override;
  bool has_changed() const override { return has_result(); }
  std::string kept_as() const override;
  void keep(const std::string& path) override;
  std::string saving() const override { return saves_.empty() ? "" : saves_.front().path; }
  nlohmann::ordered_json report() const override;

 protected:
  /// What is shown for these options; on the other thread.
  virtual void make(const OptionValues& options, const Progress& progress);
  /// Writes the result for these options, which name the output; on the other thread.
  virtual void write(const OptionValues& options, const Progress& progress);
  /// Options have changed: what is shown is not theirs any more. No values: it is not given.
  void change(const std::string& name, const std::vector<std::string>& values);
  /// What is shown is not that of what was done since.
  void make_again() {
    stale_ = true;
    stopped_ = false;
  }
  using Work = std::function<void(const Progress&)>;
  /// On the window's thread: right before `make`; what saves the result for these options, whatever
  /// is done until its turn comes; as a command.
  virtual void before_make(const OptionValues&) {}
  /// Whether what is being made takes a changed option over by itself, and need not be made again; on the window's
  /// thread, once `options_` have it.
  virtual bool follows(const std::string&) { return false; }
  /// Throws `InvalidInput` where other options would lose what was done by hand.
  virtual void require_keeps(const OptionValues&) const {}
  virtual Work saver(const OptionValues& options) {
    return [this, options](const Progress& progress) { write(options, progress); };
  }
  /// Writes a file once nothing else is to be done; `written` is then called on the window's
  /// thread.
  void save_behind(const std::string& path, Work work, std::function<void()> written = {});
  virtual std::string command_words(const OptionValues& options) const;
  const std::filesystem::path& folder() const { return folder_.path(); }
  /// Whether all is there that the verb wants.
  virtual bool complete() const;
  /// Throws `InvalidInput` where it is not.
  void require_complete() const;
  /// Whether work begins when this option is changed, before it has begun once.
  virtual bool begins_by(const std::string&) const { return false; }
  /// Whether its result is wanted for itself, and asked for before it is lost.
  virtual bool is_worth_asking() const { return true; }
  /// What is still wanted of the person, as a sentence; empty: nothing that needs to be said.
  virtual std::string missing() const { return {}; }
  /// What goes on while `make` does, as a person calls it.
  virtual std::string work_words() const { return "being worked out"; }
  /// Whether what is shown is of the options as they are.
  bool is_current() const { return !stale_ && failure_.empty() && !is_making(); }
  /// Whether that will be so without a person's doing.
  bool is_on_its_way() const { return is_making() || (stale_ && !stopped_); }
  /// Whether an option that says what is computed is in the panel.
  virtual bool shows(const Option&) const { return true; }
  /// The result, on the other thread: the model's textures, or its colours at vertices.
  void show(const Model& result) { show_stage("result", result); }
  /// Pictures that are kept and changed while they are shown, in place of other results.
  void show(std::shared_ptr<TextureSet> pictures);
  /// A result as such pictures.
  std::shared_ptr<TextureSet> pictures_of(const Model& result) const {
    return std::make_shared<TextureSet>(result.textures, largest_side_);
  }
  /// The same on its way there: it is shown until there is something newer, and can be gone back
  /// to.
  void show_stage(const std::string& name, const Model& result);
  /// Stages in the order of their times, whichever comes first: those of runs before are kept.
  void show_stage(double time, const Model& result);
  /// Shows the stage of this time, if there is one.
  bool show_again(double time);
  /// Begins anew with the next stage.
  void forget_stages();
  /// What is worked on are colours at vertices, and not textures.
  bool at_vertices() const { return at_vertices_; }

  Session& session_;
  OptionValues options_;
  nlohmann::ordered_json found_;  ///< the verb's result

 private:
  void save(const std::string& path);
  void run();
  void begin_controls();
  void show_nothing();
  bool is_making() const { return background_.busy() && !writing_; }
  void edit_option(const std::string& option);
  std::string as_command() const;
  void refuse_as_the_verb() const;
  std::vector<std::string> shown_options() const;
  std::string in_force(const std::string& option) const;
  std::vector<std::string> as_found(const std::string& option, std::vector<std::string> values) const;
  /// Whether there is something to be saved.
  bool has_result() const {
    const std::lock_guard lock(stages_mutex_);
    return has_run_ && !stages_.empty();
  }

  std::string verb_;
  bool at_vertices_ = false;
  TemporaryFolder folder_{"marquetry-view-", "results"};  ///< for results on their way to the window
  bool stale_ = false, stopped_ = false;
  bool has_run_ = false;
  int runs_ = 0, shown_run_ = 0, saved_run_ = 0;  ///< how many began; which ended last; of which the result is saved
  /// That which is of the options as they are.
  int wanted_run() const { return runs_ + (stale_ && !stopped_ ? 1 : 0); }
  std::string failure_;  ///< of the last run, if it failed
  struct Save {
    std::string path;
    Work work;
    std::function<void()> written;
  };
  std::deque<Save> saves_;  ///< the first of them is being written if `writing_`
  bool writing_ = false;
  void give_up_saves();
  struct Stage {
    std::string name;
    std::optional<double> time;
    std::shared_ptr<TextureSet> pictures;         ///< null: it is colours
    std::shared_ptr<const VertexSignal> colours;  ///< at vertices; null: it is pictures
  };
  void stage_controls();
  void choose_stage(std::size_t stage);
  OptionValues options_of_shown() const;
  Stage stage_of(const std::string& name, const Model& result) const;
  void put(Stage stage, std::size_t place);

  mutable std::mutex stages_mutex_;
  std::vector<Stage> stages_;  ///< guarded; of the last run that showed something
  bool other_run_ = false;     ///< guarded; what is shown next is not of that run
  std::size_t newest_ = 0;     ///< guarded
  std::size_t stage_ = 0;
  bool at_newest_ = true;  ///< what is newest is shown
  bool has_had_stages_ = false;  ///< more than one: their row stays, dim while there are no others
  int largest_side_ = TextureSet::largest_side();
  std::string texture_name_ = "out.png";

 protected:
  Background background_;
};

/// Distances from where the mouse is.
std::unique_ptr<Tool> make_geodesic_tool(Session& session);

/// Lines of a field, by strokes of the mouse.
std::unique_ptr<Tool> make_comb_tool(Session& session);

/// Shock filters, one time after the other.
std::unique_ptr<Tool> make_shock_tool(Session& session);

/// Which photograph wins where, of the verb stitch or texture.
std::unique_ptr<Tool> make_stitch_tool(const std::string& verb, Session& session);

/// Steps between the charts of a texture, taken out without other photographs.
std::unique_ptr<Tool> make_charts_tool(Session& session);

/// Moments between the textures and others.
std::unique_ptr<Tool> make_interpolate_tool(Session& session);

}  // namespace mq::view

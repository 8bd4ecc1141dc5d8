#pragma once
/// Any verb that makes textures: its options as sliders, its result beside the textures as they
/// were.

#include <array>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>

#include "background.h"
#include "session.h"
#include "tool.h"

namespace mq::view {

/// The verb itself runs, behind the window, whenever an option was changed.
class VerbTool : public Tool {
 public:
  /// Throws `InvalidInput` where the model has no textures.
  VerbTool(const std::string& verb, Session& session);
  ~VerbTool() override;

  std::string name() const override { return verb_; }
  void panel() override;
  void press(const Pick&) override {}
  void drag(const Pick&) override {}
  void release() override {}
  bool command(const std::vector<std::string>& words) override;
  void frame() override;
  bool busy() const override {
    return background_.busy() || (stale_ && !stopped_) || !saves_.empty();
  }
  double fraction() const override { return background_.fraction(); }
  std::string step() const override { return background_.step(); }
  void stop() override;
  void cancel() override;
  std::string saving() const override { return saves_.empty() ? "" : saves_.front().path; }
  nlohmann::ordered_json report() const override;

 protected:
  /// What is shown for these options; on the other thread.
  virtual void make(const OptionValues& options, const Progress& progress);
  /// Options have changed: what is shown is not theirs any more.
  void change(const std::string& name, const std::vector<std::string>& values);
  /// What is shown is not that of what was done since.
  void make_again() {
    stale_ = true;
    stopped_ = false;
  }
  /// On the window's thread: right before `make`; the options of a run that saves; as a command.
  virtual void before_make(const OptionValues&) {}
  virtual OptionValues options_to_save(const OptionValues& options) { return options; }
  virtual std::string command_words(const OptionValues& options) const;
  const std::filesystem::path& folder() const { return folder_; }
  /// Whether all is there that the verb wants.
  virtual bool complete() const;
  /// Throws `InvalidInput` where it is not.
  void require_complete() const;
  /// Whether an option that says what is computed is in the panel.
  virtual bool shows(const Option&) const { return true; }
  /// The result, on the other thread.
  void show(const std::vector<Texture>& pictures) { show_stage("result", pictures); }
  /// The same on its way there: it is shown until there is something newer, and can be gone back
  /// to.
  void show_stage(const std::string& name, const std::vector<Texture>& pictures);

  Session& session_;
  OptionValues options_;
  nlohmann::ordered_json found_;  ///< the verb's result

 private:
  void save(const std::string& path);
  std::vector<std::string> shown_options() const;

  std::string verb_;
  std::filesystem::path folder_;  ///< for results on their way to the window
  bool stale_ = true, stopped_ = false;
  struct Save {
    std::string path;
    OptionValues options;  ///< as they were when it was asked for
  };
  std::deque<Save> saves_;  ///< the first of them is being written if `writing_`
  bool writing_ = false;
  void give_up_saves();
  struct Stage {
    std::string name;
    std::shared_ptr<TextureSet> pictures;
  };
  void stage_controls();
  void choose_stage(std::size_t stage);

  mutable std::mutex stages_mutex_;
  std::vector<Stage> stages_;  ///< guarded; of the last run that showed something
  bool other_run_ = false;     ///< guarded; what is shown next is not of that run
  std::size_t stage_ = 0;
  bool at_newest_ = true;  ///< what is newest is shown
  int largest_side_ = TextureSet::largest_side();
  std::array<char, 256> texture_name_{"out.png"};

 protected:
  Background background_;
};

/// Distances from where the mouse is.
std::unique_ptr<Tool> make_geodesic_tool(Session& session);

/// Shock filters, one time after the other.
std::unique_ptr<Tool> make_shock_tool(Session& session);

/// Which photograph wins where.
std::unique_ptr<Tool> make_stitch_tool(Session& session);

/// Moments between the textures and others.
std::unique_ptr<Tool> make_interpolate_tool(Session& session);

}  // namespace mq::view

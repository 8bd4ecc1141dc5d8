#pragma once
/// Which photograph wins where: what the verbs stitch (--partial) and texture (--cameras) do with photographs, with
/// these and the solver kept from one choice of regions to the next.

#include <atomic>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "mq/base/length.h"
#include "mq/fem/surface_ball.h"
#include "mq/filter/stitch.h"
#include "mq/mesh/closest_point.h"
#include "options/signal_options.h"
#include "verbs/shared/partials.h"
#include "verbs/shared/photographs.h"
#include "verb_tool.h"

namespace mq::view {

/// A choice is a number per texel: of the photograph it is to come from, or `unseen` where that is left to the
/// verb. It is saved as the labels that the verb's --labels reads.
class StitchTool : public VerbTool {
 public:
  StitchTool(const std::string& verb, Session& session);
  ~StitchTool() override;

  void panel() override;

  void press(const Pick& pick) override;
  void drag(const Pick& pick) override;
  void release() override;
  bool takes_mouse() const override { return ready_ && has_photographs(); }
  std::string too_early() const override {
    if (takes_mouse() || !is_on_its_way()) return {};
    return "photographs are still being read: the brush works once they are there";
  }
  void undo() override;
  void redo() override;
  History history() const override;
  void scale_brush(double factor) override;
  double brush_radius() const override {
    return takes_mouse() && region_ == Region::brush ? brush_size() : 0;
  }

  bool command(const std::vector<std::string>& words) override;
  /// Files of cameras, or pictures that are photographs.
  bool take_files(const std::vector<std::string>& files) override;
  /// The choice and the texture, whichever is not saved.
  void save() override;
  std::string unsaved() const override;

  nlohmann::ordered_json report() const override;

 private:
  enum class Region { brush, chart };
  struct Stroke {
    std::vector<int> unknowns, before, after;
    std::string name = {};  ///< for a person
  };

  double brush_size() const;

  // On the window's thread.
  void ask_for_photographs();
  void name_photographs();
  /// In the session, which the names outlast the tool in.
  void note_photographs() const;
  void say_what_was_kept() const;
  bool has_photographs() const { return !options_.texts(photographs_option()).empty(); }
  bool complete() const override { return has_photographs() && VerbTool::complete(); }
  std::string missing() const override;
  std::string work_words() const override;
  void choices();
  std::string chosen_name() const;
  void give_at(const Vector3& place);
  void give_along(const Vector3& from, const Vector3& to);
  void give(const std::vector<int>& unknowns, const std::vector<int>& photographs);
  void begin_stroke() {
    stroke_ = {};
    last_.reset();
    met_ = Met::nothing;
  }
  void end_stroke();
  void say_nothing_given();
  void forget_others();
  void save_labels(const std::string& path);
  void write_labels(const std::vector<int>& choice, Depth depth,
                    const std::vector<std::filesystem::path>& files) const;
  Depth depth_of_labels() const { return names_.size() > 256 ? Depth::u16 : Depth::u8; }
  std::vector<int> choice_now() const {
    const std::lock_guard lock(choice_mutex_);
    return choice_;
  }
  bool is_saved() const {
    const std::lock_guard lock(choice_mutex_);
    return choice_ == saved_choice_;
  }
  void require_keeps(const OptionValues& options) const override;
  Work saver(const OptionValues& options) override;
  std::string command_words(const OptionValues& options) const override;

  // On the other one.
  void make(const OptionValues& options, const Progress& progress) override;
  void before_make(const OptionValues& options) override;
  bool shows(const Option& option) const override;
  static nlohmann::ordered_json without(const OptionValues& options,
                                        const std::vector<const char*>& names);
  /// What says which photographs there are and where they show the surface.
  static nlohmann::ordered_json photographs_of(const OptionValues& options);
  const char* photographs_option() const { return with_cameras_ ? "cameras" : "partial"; }
  void prepare(const OptionValues& options, const Progress& progress);
  void read_photographs(const OptionValues& options, const Progress& progress);
  Composite chosen(const OptionValues& options, const std::vector<int>& choice);
  Filtered stitched(const OptionValues& options, const Model& model, const Composite& composite,
                    const Progress& progress) const;
  void solve(const OptionValues& options, const Composite& composite, Model& model,
             const Progress& progress);

  const bool with_cameras_;
  int photograph_ = 0;
  Region region_ = Region::brush;
  Length size_{5, Length::Unit::percent};
  std::string labels_name_;
  std::optional<Vector3> last_;
  Stroke stroke_;
  /// What the stroke has met so far: a part of the model with a texture, such that the photograph shows it.
  enum class Met { nothing, model, photograph } met_ = Met::nothing;
  std::vector<Stroke> undo_, redo_;
  /// Guarded; what is in the files of --labels, `unseen` everywhere without them.
  std::vector<int> saved_choice_;

  std::atomic<bool> ready_ = false, dragging_ = false;
  mutable std::mutex choice_mutex_;
  std::vector<int> choice_;          ///< guarded, once `ready_` only changed by the window's thread
  std::vector<std::string> labels_;  ///< the files that it was read from or saved to
  bool other_labels_ = false;        ///< it is still to be read from them

  std::unique_ptr<app::Run> run_;
  app::Terminal silence_{"view"};
  std::unique_ptr<TextureSignal> target_;
  std::unique_ptr<ClosestPointFinder> closest_;
  std::unique_ptr<SurfaceBall> ball_;
  std::vector<Photograph> photographs_;             ///< with their cameras
  std::unique_ptr<PhotographTexturing> texturing_;  ///< of these
  std::vector<int> by_itself_;                      ///< which of them the verb takes
  std::vector<Partial> partials_;  ///< of photographs, and where it is asked for the mean of those with cameras
  std::vector<std::string> names_;
  Signal before_;
  std::unique_ptr<Stitcher> stitcher_;
  std::vector<int> grouped_;  ///< the labels that it had last
  nlohmann::ordered_json prepared_for_, solver_for_;
  double preparing_ = 0;
  int prepared_ = 0, known_ = 0;  ///< how often; and when the window's thread last looked
  std::vector<double> solving_;
};

}  // namespace mq::view

#pragma once
/// Sharpening and smoothing by a brush (thesis 5.9.1): where it painted, and how strongly, is a
/// mask, and the textures, or the colours at vertices, are what `marquetry filter --mask` makes of
/// it.

#include <atomic>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>

#include "background.h"
#include "mq/base/length.h"
#include "mq/base/stopwatch.h"
#include "mq/filter/live_modulation.h"
#include "mq/image/histogram.h"
#include "mq/linear/row_set.h"
#include "paint_target.h"
#include "session.h"
#include "tool.h"

namespace mq::view {

class FilterTool : public Tool {
 public:
  /// Where it works first: where one paints, or everywhere at once, by a button. The second is called detail.
  enum class Begins { nowhere, everywhere };
  /// Of what `can_be_painted`. Throws `InvalidInput` where the model has refused defects.
  FilterTool(Session& session, Begins begins);
  ~FilterTool() override { background_.stop(); }

  std::string name() const override { return begins_ == Begins::nowhere ? "filter" : "detail"; }
  void panel() override;
  void press(const Pick& pick) override;
  void drag(const Pick& pick) override;
  bool takes_mouse() const override { return begins_ == Begins::nowhere || !nothing_painted(); }
  std::string too_early() const override {
    return ready_ || !takes_mouse() ? "" : "the brush is still being prepared: wait a moment";
  }
  void release() override;
  void undo() override;
  void redo() override;
  History history() const override;
  double brush_radius() const override;
  void scale_brush(double factor) override;
  std::optional<Look::Paint> shown_as() const override;
  bool command(const std::vector<std::string>& words) override;
  void frame() override;
  bool busy() const override { return background_.busy() || has_work() || has_written(); }
  double fraction() const override { return ready_ ? solved_.load() : background_.fraction(); }
  std::string step() const override { return ready_ ? "solve" : background_.step(); }
  std::string working() const override;
  void stop() override;
  void cancel() override {
    background_.cancel();
    stopped_ = true;
  }
  void save() override { save_texture(texture_name_); }
  std::string saving() const override;
  std::string unsaved() const override;
  bool has_changed() const override { return !nothing_painted(); }
  std::string kept_as() const override;
  void keep(const std::string& path) override;
  nlohmann::ordered_json report() const override;

 private:
  /// A mask of 1.
  static constexpr int full = 65535;

  /// Unknowns whose mask changed, and its values before and after, in 65535ths.
  struct Stroke {
    std::vector<int> unknowns, before, after;
    std::string name = {};  ///< for a person
  };
  enum class Brush { sharpen, smooth, erase };

  /// A file that was asked for: the texture, once all is solved, or a mask as it was then.
  struct Save {
    std::string path;
    std::vector<std::filesystem::path> masks;  ///< files of a mask; empty: it is the texture
    std::vector<int> mask;
    bool smooths = false;  ///< somewhere
    int changes = 0;       ///< of the mask until then
  };

  /// What the window wants of the work behind it.
  struct Wanted {
    double weight = 0;                      ///< of the equation
    double gain = 0;                        ///< beta − 1
    std::vector<std::pair<int, int>> mask;  ///< changes, in order
    int version = 0;                        ///< how often something was changed
  };

  /// Seconds that one change of the mask took.
  struct Timing {
    std::size_t unknowns = 0;
    double update = 0, solve = 0, show = 0;
    int cycles = 0;
  };

  // On the window's thread.

  // filter_tool.cpp
  double require_weight(const OptionValues& options) const;
  void want();
  void choose(Brush brush);
  std::vector<Vector3> places_of(const std::vector<std::string>& words) const;
  bool brush_command(const std::vector<std::string>& words);
  void set(const std::string& name, const std::string& value);
  void take(const OptionValues& options);
  void require_beta_for(const std::vector<int>& mask) const;
  std::string as_command();
  void require_ready() const;
  bool is_settled() const;
  bool has_work() const;
  bool has_written() const {
    const std::lock_guard lock(mutex_);
    return !written_.empty();
  }
  bool nothing_painted() const { return painted_ == 0; }
  bool at_vertices() const { return !session_.before; }

  // filter_tool_panel.cpp
  void whole_controls();
  void strength_controls();
  void brush_controls();
  void more_controls();
  void histogram_controls() const;

  // filter_tool_strokes.cpp
  void change(const std::vector<int>& unknowns, const std::vector<int>& values);
  void dab(const Vector3& place);
  void dabs_to(const Vector3& place);
  void fill(int value);
  int painted_with(int before, double paint) const;
  void begin_stroke() { stroke_ = Stroke(), touched_ = false; }
  void end_stroke(const std::string& name);
  void end_brush_stroke();
  std::string brush_name() const;

  // filter_tool_saving.cpp
  void save_texture(const std::string& path);
  void save_mask(const std::string& path);
  static void require_other_files(const std::vector<std::filesystem::path>& files,
                                  const std::vector<std::filesystem::path>& others);
  void take_note_of_written();
  void give_up_saving();
  Outputs outputs(const std::string& path) const;

  // On the other one.

  // filter_tool_saving.cpp
  bool write_mask();
  bool write_texture(int version, const Progress& progress);

  // filter_tool_solving.cpp
  void prepare(const Progress& progress);
  void work(const Progress& progress);
  bool step_on(Wanted wanted, const Progress& progress);
  void make_live(const Wanted& wanted, const Progress& progress);
  void settle(const Progress& progress);
  void begin_solving();
  /// A part of what is solved for since something was changed last: how far it is from `from` to `to`, by its own
  /// progress.
  Progress solving(double from, double to, const Progress& progress);
  void follow(const Wanted& wanted);
  Followed follow_on();
  enum class Extent { all, followed };
  void show(Extent extent);
  void count_values(const ShownSignal& values);
  ShownSignal shown() const {
    return {before_, live_->signal(), gain_, limit_ ? &*limit_ : nullptr};
  }

  Session& session_;
  const Begins begins_;
  OptionValues options_;  ///< of the verb
  std::unique_ptr<app::Run> run_;
  SurfaceScale scale_{1, 1};  ///< of what the unknowns cover, once `ready_`

  Brush brush_ = Brush::sharpen;
  Length size_{3, Length::Unit::percent};
  double strength_ = 0.5, hardness_ = 0;
  std::vector<int> mask_;      ///< per unknown
  std::int64_t painted_ = 0;   ///< how many of them are not 0
  std::int64_t smoothed_ = 0;  ///< how many are below 0
  Stroke stroke_;
  bool touched_ = false;  ///< the stroke came near an unknown, changed or not
  std::optional<Vector3> last_dab_;
  std::vector<Stroke> undo_, redo_;
  int changes_ = 0;         ///< of the mask
  std::string saved_mask_;  ///< where the mask was saved as it is now; empty: nowhere
  std::vector<std::filesystem::path> mask_files_, texture_files_;  ///< asked for last
  std::string mask_name_, texture_name_;

  std::atomic<bool> ready_ = false, settled_ = false, stopped_ = false;
  std::atomic<bool> brushing_ = false;  ///< the button is down: what is far from the brush can wait
  std::atomic<int> saved_version_ = 0;  ///< of what was wanted, of the texture last saved
  int noted_version_ = 0;               ///< the same, as the window's thread last looked
  std::atomic<bool> hurry_ = false;     ///< something new is wanted while the whole is being solved
  mutable std::mutex mutex_;
  Wanted wanted_;  ///< guarded
  std::atomic<double> solved_ = 0;  ///< what part of all that was changed last
  Stopwatch solving_since_;         ///< guarded
  double reduction_ = 1;            ///< of the residual, since then
  std::vector<Timing> timings_;
  std::vector<double> touches_;  ///< seconds, of finding what is under the brush
  int rounds_ = 0;
  double settling_ = 0, preparing_ = 0;

  std::unique_ptr<PaintTarget> paint_target_;
  Signal before_;
  std::optional<HaloLimit> limit_;      ///< none: halos as the equation has them
  std::optional<LiveModulation> live_;  ///< of β = 1 + mask
  Histogram values_before_, values_after_;  ///< guarded, once `ready_`; of colours, all together
  std::vector<int> followed_;
  RowSet of_touches_;             ///< empty between calls
  std::int64_t unfinished_ = 0;   ///< unknowns that are solved for on while nothing new is wanted
  Stopwatch since_followed_;  ///< the last change of the mask
  double weight_ = 0, gain_ = 0;
  std::deque<Save> saves_;     ///< guarded; the first is being written, or will be
  std::vector<Save> written_;  ///< guarded; masks, for the window's thread to take note of
  Background background_;      ///< last: it ends before what it works on
};

}  // namespace mq::view

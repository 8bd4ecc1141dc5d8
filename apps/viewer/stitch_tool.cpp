// What the verb stitch does with photographs, with these and the solver kept from one choice of
// regions to the next.
//
// A choice is a number per texel: of the photograph it is to come from, or `unseen` where the one
// that shows it best is taken. It is saved as the labels that `stitch --labels` reads.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <optional>
#include <set>

#include "shell/arguments.h"
#include "controls.h"
#include "mq/base/error.h"
#include "mq/base/stopwatch.h"
#include "mq/base/words.h"
#include "mq/fem/surface_ball.h"
#include "mq/filter/stitch.h"
#include "mq/io/image_file.h"
#include "mq/mesh/closest_point.h"
#include "shell/results.h"
#include "partials.h"
#include "options/signal_options.h"
#include "options/solver_options.h"
#include "verb_tool.h"

namespace mq::view {
namespace {

class StitchTool : public VerbTool {
 public:
  explicit StitchTool(Session& session) : VerbTool("stitch", session) {}
  ~StitchTool() override { background_.stop(); }

  void panel() override {
    if (ready_) {
      forget_others();
      choices();
    }
    VerbTool::panel();
  }

  void choices() {
    const std::string now = photograph_ == unseen ? "best" : names_[std::size_t(photograph_)];
    if (ImGui::BeginCombo("photograph", now.c_str())) {
      if (ImGui::Selectable("best", photograph_ == unseen)) photograph_ = unseen;
      for (int i = 0; i < int(names_.size()); ++i)
        if (ImGui::Selectable(names_[std::size_t(i)].c_str(), photograph_ == i)) photograph_ = i;
      ImGui::EndCombo();
    }
    int region = int(region_);
    ImGui::RadioButton("brush", &region, 0);
    ImGui::SameLine();
    ImGui::RadioButton("chart", &region, 1);
    region_ = Region(region);
    if (region_ == Region::brush) edit_brush(size_, brush_size(), session_.scene->surface.area);
    if (ImGui::Button("undo")) undo();
    ImGui::SameLine();
    if (ImGui::Button("redo")) redo();
    if (ask_to_save("labels", labels_name_)) tried(session_, [&] { save_labels(labels_name_); });
    ImGui::Separator();
  }

  void press(const Pick& pick) override {
    if (!ready_) return;
    forget_others();
    begin_stroke();
    dragging_ = true;
    drag(pick);
  }
  void drag(const Pick& pick) override {
    if (!ready_ || pick.chart < 0) return;
    if (last_ && region_ == Region::brush)
      give_along(*last_, pick.point);
    else
      give_at(pick.point);
    last_ = pick.point;
  }
  void release() override {
    dragging_ = false;
    end_stroke();
  }
  bool takes_mouse() const override { return ready_; }
  void undo() override;
  void redo() override;
  double brush_radius() const override {
    return ready_ && region_ == Region::brush ? brush_size() : 0;
  }

  bool command(const std::vector<std::string>& words) override;
  std::string unsaved() const override {
    return is_saved() ? "" : "which photographs were chosen for the tool stitch";
  }

  nlohmann::ordered_json report() const override {
    nlohmann::ordered_json report = VerbTool::report();
    report["prepare_seconds"] = preparing_;
    report["solve_seconds"] = solving_;
    report["prepared"] = prepared_;
    return report;
  }

 private:
  enum class Region { brush, chart };
  struct Stroke {
    std::vector<int> unknowns, before, after;
  };

  double brush_size() const {
    const TexturedModel& scene = *session_.scene;
    return std::sqrt(weight_from_length(size_, {scene.surface.area, scene.atlas->texel_spacing()}));
  }

  // On the window's thread.
  void give_at(const Vector3& place);
  void give_along(const Vector3& from, const Vector3& to);
  void give(const std::vector<int>& unknowns, const std::vector<int>& photographs);
  void begin_stroke() {
    stroke_ = {};
    last_.reset();
  }
  void end_stroke();
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
  std::string command_words(const OptionValues& options) const override {
    require(
        is_saved(),
        "the command names the labels' file, and what was chosen is not saved as it is now: save "
        "the labels first");
    return VerbTool::command_words(options);
  }

  // On the other one.
  void make(const OptionValues& options, const Progress& progress) override;
  void before_make(const OptionValues& options) override;
  static nlohmann::ordered_json without(const OptionValues& options,
                                        const std::vector<const char*>& names) {
    nlohmann::ordered_json asked = app::options_json(options);
    for (const char* name : names) asked.erase(name);
    return asked;
  }
  /// What says which photographs there are and where they show the surface.
  static nlohmann::ordered_json photographs_of(const OptionValues& options) {
    return without(options, {"labels", "unseen", "output", "alpha", "length", "solver", "tolerance",
                             "cycles", "depth"});
  }
  void prepare(const OptionValues& options, const Progress& progress);
  void solve(const OptionValues& options, const Composite& composite, Model& model,
             const Progress& progress);

  int photograph_ = 0;
  Region region_ = Region::brush;
  Length size_{5, Length::Unit::percent};
  std::string labels_name_ = "labels.png";
  std::optional<Vector3> last_;
  Stroke stroke_;
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
  std::vector<Partial> partials_;
  std::vector<std::string> names_;
  Signal before_;
  std::unique_ptr<Stitcher> stitcher_;
  nlohmann::ordered_json prepared_for_, solver_for_;
  double preparing_ = 0;
  int prepared_ = 0, known_ = 0;  ///< how often; and when the window's thread last looked
  std::vector<double> solving_;
};

bool StitchTool::command(const std::vector<std::string>& words) {
  const std::string& what = words[0];
  static const std::set<std::string> own = {"photograph", "region", "size",       "stroke",
                                            "undo",       "redo",   "save-labels"};
  if (!own.contains(what)) return VerbTool::command(words);
  require(
      ready_,
      "stitch chooses between photographs: name them first, with 'set partial FILE ...' or 'set "
      "views FILE'");
  forget_others();
  if (what == "photograph") {
    const auto number = app::parse_numbers(words[1], 1);
    const int count = int(names_.size());
    require(words[1] == "best" || (number && number->front() >= 0 && number->front() < count &&
                                   number->front() == std::floor(number->front())),
            fmt::format("found '{}', wanted best or a number from 0 to {}", words[1], count - 1));
    photograph_ = words[1] == "best" ? unseen : int(number->front());
  } else if (what == "region") {
    require(words[1] == "brush" || words[1] == "chart",
            fmt::format("found '{}', wanted brush or chart", words[1]));
    region_ = words[1] == "brush" ? Region::brush : Region::chart;
  } else if (what == "size") {
    const Length size = parse_length(words[1]);
    require(size.value > 0, fmt::format("found '{}', wanted a length above 0", words[1]));
    size_ = size;
  } else if (what == "stroke") {
    begin_stroke();
    for (std::size_t i = 1; i < words.size(); ++i) {
      const auto place = app::parse_numbers(words[i], 3);
      require(place.has_value(), fmt::format("found '{}', wanted X,Y,Z", words[i]));
      const Vector3 next((*place)[0], (*place)[1], (*place)[2]);
      if (last_ && region_ == Region::brush)
        give_along(*last_, next);
      else
        give_at(next);
      last_ = next;
    }
    end_stroke();
  } else if (what == "undo") {
    undo();
  } else if (what == "redo") {
    redo();
  } else {
    save_labels(words[1]);
  }
  return true;
}

/// With other photographs neither the one chosen nor what was done means what it did.
void StitchTool::forget_others() {
  if (known_ == prepared_) return;
  known_ = prepared_;
  undo_.clear();
  redo_.clear();
  if (photograph_ >= int(names_.size())) photograph_ = 0;
}

void StitchTool::give_along(const Vector3& from, const Vector3& to) {
  const int count = std::max(1, int(std::ceil((to - from).norm() / (brush_size() / 3))));
  for (int i = 1; i <= count; ++i) give_at(from + double(i) / count * (to - from));
}

void StitchTool::give_at(const Vector3& place) {
  const ClosestPoint at = (*closest_)(place);
  const int chart = session_.scene->atlas->chart[std::size_t(at.triangle)];
  if (chart < 0) return;
  std::vector<int> unknowns;
  if (region_ == Region::brush) {
    unknowns = ball_->reach(at.triangle, at.barycentric, place, brush_size());
  } else {
    const std::vector<int>& charts = target_->space().texels().chart;
    for (int k = 0; k < int(charts.size()); ++k)
      if (charts[std::size_t(k)] == chart) unknowns.push_back(k);
  }
  std::erase_if(unknowns, [&](int k) {
    return photograph_ != unseen &&
           !(partials_[std::size_t(photograph_)].confidence[std::size_t(k)] > 0);
  });
  give(unknowns, std::vector<int>(unknowns.size(), photograph_));
}

void StitchTool::give(const std::vector<int>& unknowns, const std::vector<int>& photographs) {
  bool changed = false;
  {
    const std::lock_guard lock(choice_mutex_);
    for (std::size_t i = 0; i < unknowns.size(); ++i) {
      int& now = choice_[std::size_t(unknowns[i])];
      if (now == photographs[i]) continue;
      stroke_.unknowns.push_back(unknowns[i]);
      stroke_.before.push_back(now);
      stroke_.after.push_back(photographs[i]);
      now = photographs[i];
      changed = true;
    }
  }
  if (!changed) return;
  if (saving().empty()) background_.cancel();
  make_again();
}

void StitchTool::end_stroke() {
  last_.reset();
  if (stroke_.unknowns.empty()) return;
  undo_.push_back(std::move(stroke_));
  stroke_ = {};
  redo_.clear();
  make_again();
}

void StitchTool::undo() {
  if (undo_.empty()) return;
  Stroke stroke = std::move(undo_.back());
  undo_.pop_back();
  // The last change of a texel is taken back first: a stroke may meet it several times.
  give({stroke.unknowns.rbegin(), stroke.unknowns.rend()},
       {stroke.before.rbegin(), stroke.before.rend()});
  stroke_ = {};
  redo_.push_back(std::move(stroke));
}

void StitchTool::redo() {
  if (redo_.empty()) return;
  Stroke stroke = std::move(redo_.back());
  redo_.pop_back();
  give(stroke.unknowns, stroke.after);
  stroke_ = {};
  undo_.push_back(std::move(stroke));
}

/// Grey and alpha: the number of the photograph, transparent where the best is taken.
void StitchTool::write_labels(const std::vector<int>& choice, Depth depth,
                              const std::vector<std::filesystem::path>& files) const {
  std::vector<Image<float>> pictures;
  for (const TextureSize& size : session_.scene->texture_sizes)
    pictures.emplace_back(size.width, size.height, 2);
  const Texels& texels = target_->space().texels();
  const int most = depth == Depth::u16 ? 65535 : 255;
  for (int k = 0; k < texels.size(); ++k) {
    const int chosen = choice[std::size_t(k)];
    if (chosen == unseen) continue;
    const Texels::Place& at = texels.places[std::size_t(k)];
    pictures[std::size_t(at.texture)](at.x, at.y, 0) = float(chosen) / float(most);
    pictures[std::size_t(at.texture)](at.x, at.y, 1) = 1;
  }
  for (std::size_t i = 0; i < pictures.size(); ++i) write_image(files[i], pictures[i], depth);
}

void StitchTool::save_labels(const std::string& path) {
  const Outputs outputs(path, session_.scene->model, Outputs::Kind::pictures);
  for (const auto& file : outputs.paths()) {
    const std::string extension = file.extension().string();
    require(extension == ".png" || extension == ".tif" || extension == ".tiff",
            fmt::format("{}: labels want no loss: name a .png or a .tif", file.string()));
  }
  for (const char* option : {"partial", "views"})
    for (const std::string& name : options_.texts(option)) session_.run.will_read(name);
  session_.run.will_write(outputs.paths(), outputs.folder());
  const std::vector<std::filesystem::path> files = outputs.paths();
  save_behind(
      path,
      [this, files, depth = depth_of_labels(), choice = choice_now()](const Progress&) {
        write_labels(choice, depth, files);
      },
      [this, files, choice = choice_now()] {
        {
          const std::lock_guard lock(choice_mutex_);
          saved_choice_ = choice;
        }
        if (!is_saved()) return;  // others were chosen since
        std::vector<std::string> names;
        for (const auto& file : files) names.push_back(file.string());
        options_.set("labels", names);
        labels_ = names;
      });
}

/// What was chosen goes with the command, saved or not.
VerbTool::Work StitchTool::saver(const OptionValues& options) {
  if (is_saved()) return VerbTool::saver(options);
  std::vector<std::filesystem::path> files;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < session_.scene->texture_sizes.size(); ++i) {
    files.push_back(folder() / fmt::format("labels{}.png", i));
    names.push_back(files.back().string());
  }
  OptionValues labelled = options;
  labelled.set("labels", names);
  return [this, files, labelled, depth = depth_of_labels(),
          choice = choice_now()](const Progress& progress) {
    write_labels(choice, depth, files);
    write(labelled, progress);
  };
}

/// Neither other labels nor other photographs take the place of what is not saved.
void StitchTool::require_keeps(const OptionValues& options) const {
  if (photographs_of(options) == photographs_of(options_) &&
      options.texts("labels") == options_.texts("labels"))
    return;
  require(is_saved(),
          "what was chosen would be lost, and is not saved: save the labels first, or undo it");
}

/// Other labels than those that were read or saved last take the place of what was chosen; without
/// any nothing is.
void StitchTool::before_make(const OptionValues& options) {
  if (photographs_of(options) != prepared_for_) ready_ = false;
  if (options.texts("labels") == labels_) return;
  labels_ = options.texts("labels");
  other_labels_ = true;
  ready_ = false;
  undo_.clear();
  redo_.clear();
}

// ---- the work behind it

void StitchTool::prepare(const OptionValues& options, const Progress& progress) {
  const nlohmann::ordered_json photographs = photographs_of(options),
                               solver = without(options, {"labels", "output", "depth"});
  if (target_ && photographs == prepared_for_) {
    if (solver != solver_for_) stitcher_.reset();
    solver_for_ = solver;
    return;
  }
  const Stopwatch watch;
  stitcher_.reset();
  silence_.set_voice(app::Terminal::Voice::quiet);
  run_ = std::make_unique<app::Run>(options, silence_, progress);
  const TexturedModel& scene = *session_.scene;
  about(scene.model, [&] {
    app::check_partials(options, scene);
    target_ = app::make_texture_signal(*run_, scene, {.values = app::value_space(options)},
                                       progress.step("assemble", 0.4));
    before_ = target_->values();
    partials_ = app::read_partials(*run_, scene, *target_, progress.step("photographs", 0.4));
    ball_ = std::make_unique<SurfaceBall>(target_->space());
  });
  closest_ = std::make_unique<ClosestPointFinder>(scene.surface.mesh);
  const bool views = app::has_views(options);
  const std::size_t before = names_.size();
  names_.clear();
  for (std::size_t i = 0; i < partials_.size(); ++i) {
    const std::filesystem::path file =
        views ? run_->result["views"][i]["picture"].get<std::string>()
              : options.texts("partial")[i * scene.texture_sizes.size()];
    names_.push_back(fmt::format("{}: {}", i, file.filename().string()));
  }
  {
    const std::lock_guard lock(choice_mutex_);
    const auto count = std::size_t(target_->space().size());
    if (choice_.size() != count || before != names_.size()) {
      choice_.assign(count, unseen);
      saved_choice_ = choice_;
      other_labels_ = true;
    }
  }
  prepared_for_ = photographs;
  solver_for_ = solver;
  preparing_ = watch.seconds();
  ++prepared_;
}

void StitchTool::solve(const OptionValues& options, const Composite& composite, Model& model,
                       const Progress& progress) {
  const Stopwatch watch;
  const TexelSpace& space = target_->space();
  const double weight = app::spread_weight(options, space.scale());
  app::Run run(options, silence_, progress);
  Filtered result;
  int attempts = 0;
  app::solve_as_asked(
      run, *target_, [&](const SolverFactory& factory, const app::SolvingShares& shares) {
        if (attempts++ > 0 || !stitcher_) {
          stitcher_.reset();
          const app::Step step(run, "prepare", shares.prepare);
          stitcher_ = std::make_unique<Stitcher>(space, weight, composite.labels, factory, step);
        } else {
          stitcher_->regroup(composite.labels);
        }
        const app::Step step(run, "solve", shares.solve);
        const Signal psi = stitcher_->fill(composite.values, step.progress().step("fill", 0.3));
        const Signal change = stitcher_->change(partials_, {psi, composite.labels});
        result = stitcher_->solve(psi, change, step.progress().step("stitch", 0.7));
        return result.report;
      });
  // A factorisation of a second attempt is not what the next choice should begin with.
  if (attempts > 1) stitcher_.reset();
  target_->put(composite.values, result.signal, model);
  solving_.push_back(watch.seconds());
}

void StitchTool::make(const OptionValues& options, const Progress& progress) {
  if (!app::has_partials(options)) {
    ready_ = false;
    return VerbTool::make(options, progress);
  }
  prepare(options, progress.step("prepare", 0.5));
  const TexelSpace& space = target_->space();
  if (other_labels_) {
    std::vector<int> asked(std::size_t(space.size()), unseen);
    if (options.has("labels"))
      asked = app::asked_photographs(options, *session_.scene, space, int(partials_.size()));
    const std::lock_guard lock(choice_mutex_);
    choice_ = saved_choice_ = std::move(asked);
    other_labels_ = false;
  }
  ready_ = true;
  std::vector<int> choice;
  {
    const std::lock_guard lock(choice_mutex_);
    choice = choice_;
  }
  const Composite composite = best_of(partials_, choice);
  Model model;
  model.textures = session_.scene->model.textures;
  target_->put(before_, composite.values, model);
  show_stage("photographs", model);
  if (dragging_) return;  // the borders go once the mouse lets go
  progress.check();
  std::set<int> regions(composite.labels.begin(), composite.labels.end());
  found_ = {{"regions", regions.size() - regions.count(unseen)}};
  require(regions.size() > regions.count(unseen), "no photograph shows anything of the model");
  if (regions.size() > 1) solve(options, composite, model, progress);
  app::set_depth(options, model);
  show(model);
}

}  // namespace

std::unique_ptr<Tool> make_stitch_tool(Session& session) {
  return std::make_unique<StitchTool>(session);
}

}  // namespace mq::view

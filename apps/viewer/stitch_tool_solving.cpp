// The work behind the window: photographs are read once, and their borders taken away for each
// choice.
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "mq/base/error.h"
#include "mq/base/stopwatch.h"
#include "mq/model/texture_fill.h"
#include "options/solver_options.h"
#include "shell/results.h"
#include "stitch_tool.h"
#include "verbs/shared/partials.h"

namespace mq::view {

/// Not what makes another model, nor a page, nor what is for work without a window.
bool StitchTool::shows(const Option& option) const {
  return !with_cameras_ ||
         (option.name != "size" && option.name != "unwrap" && option.name != "picture" && option.name != "resume");
}

nlohmann::ordered_json StitchTool::without(const OptionValues& options,
                                           const std::vector<const char*>& names) {
  nlohmann::ordered_json asked = app::options_json(options);
  for (const char* name : names) asked.erase(name);
  return asked;
}

nlohmann::ordered_json StitchTool::photographs_of(const OptionValues& options) {
  return without(options, {"labels", "unseen", "output", "alpha", "length", "solver", "tolerance",
                           "cycles", "depth", "blend"});
}

void StitchTool::prepare(const OptionValues& options, const Progress& progress) {
  const nlohmann::ordered_json photographs = photographs_of(options),
                               solver = without(options, {"labels", "output", "depth", "blend"});
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
    if (!with_cameras_) app::check_partials(options, scene);
    target_ = app::make_texture_signal(*run_, scene, {.values = app::value_space(options)},
                                       progress.step("assemble", 0.4));
    before_ = target_->values();
    read_photographs(options, progress.step("photographs", 0.4));
    ball_ = std::make_unique<SurfaceBall>(target_->space());
  });
  closest_ = std::make_unique<ClosestPointFinder>(scene.surface.mesh);
  const std::size_t before = names_.size();
  names_.clear();
  for (std::size_t i = 0; i < partials_.size(); ++i) {
    const std::filesystem::path file =
        with_cameras_ ? photographs_[i].picture.string() : options.texts("partial")[i * scene.texture_sizes.size()];
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

/// Of photographs with cameras every one is held as it shows the whole surface, for any choice to be seen at once.
void StitchTool::read_photographs(const OptionValues& options, const Progress& progress) {
  const TexturedModel& scene = *session_.scene;
  if (!with_cameras_) {
    partials_ = app::read_partials(options, scene, *target_);
    return;
  }
  partials_.clear();
  texturing_.reset();  // together with the mean, which comes last and must not move the others under the mouse
  photographs_ = app::read_photographs(*run_).photographs;
  texturing_ = std::make_unique<PhotographTexturing>(scene, *target_, photographs_,
                                                     app::asked_photograph_options(options), silence_,
                                                     progress.step("look", 0.5));
  partials_.reserve(photographs_.size() + 1);
  for (std::size_t v = 0; v < photographs_.size(); ++v)
    partials_.push_back(texturing_->partial(
        int(v), progress.step(photographs_[v].picture.filename().string(), 0.4 / double(photographs_.size()))));
  by_itself_ = texturing_->labels({}, progress.step("choose", 0.1));
}

/// What is chosen where that photograph shows it; else what the verb takes by itself, also nothing where cameras are
/// given and no photograph shows it well. The mean of all is one more photograph.
Composite StitchTool::chosen(const OptionValues& options, const std::vector<int>& choice) {
  if (!with_cameras_) return best_of(partials_, choice);
  const bool means = options.text("blend") == "mean";
  if (means && partials_.size() == photographs_.size()) partials_.push_back(texturing_->mean(partials_, by_itself_));
  const auto shows = [&](int photograph, std::size_t i) {
    return photograph != unseen && partials_[std::size_t(photograph)].confidence[i] > 0;
  };
  std::vector<int> labels = choice;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (!shows(labels[i], i)) labels[i] = means && by_itself_[i] != unseen ? int(photographs_.size()) : by_itself_[i];
    if (!shows(labels[i], i)) labels[i] = unseen;
  }
  return composite_of(partials_, std::move(labels));
}

Filtered StitchTool::stitched(const OptionValues& options, const Model& model, const Composite& composite,
                              const Progress& progress) const {
  if (!with_cameras_)
    return stitcher_->stitch(composite.values, partials_,
                             app::asked_levels(options, model, *stitcher_, composite.values), progress);
  const int channels = int(composite.values.cols());
  BeyondBorders beyond(target_->space(), composite.labels, channels);
  for (std::size_t v = 0; v < partials_.size(); ++v)
    for (const int i : beyond.unknowns_of(int(v)))
      if (partials_[v].confidence[std::size_t(i)] > 0) beyond.put(int(v), i, partials_[v].values.row(i));
  const Signal offset = options.text("blend") == "detail"
                            ? texturing_->offset(composite.labels)
                            : Signal(Signal::Zero(composite.values.rows(), channels));
  return stitcher_->stitch(composite.values, beyond, offset, progress);
}

void StitchTool::solve(const OptionValues& options, const Composite& composite, Model& model,
                       const Progress& progress) {
  const Stopwatch watch;
  const TexelSpace& space = target_->space();
  const double weight = app::spread_weight(options, space.scale());
  app::Run run(options, silence_, progress);
  Filtered result;
  int attempts = 0;
  if (!std::ranges::equal(composite.labels, grouped_, {}, [](int label) { return label == unseen; },
                          [](int label) { return label == unseen; }))
    stitcher_.reset();  // what is unseen is in its equations
  grouped_ = composite.labels;
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
        result = stitched(options, model, composite, step);
        return result.report;
      });
  // A factorisation of a second attempt is not what the next choice should begin with.
  if (attempts > 1) stitcher_.reset();
  target_->put(composite.values, result.signal, model);
  if (!with_cameras_) spread_past_unseen(composite.labels, space, *session_.scene, model);  // as the verb stitch
  solving_.push_back(watch.seconds());
}

void StitchTool::make(const OptionValues& options, const Progress& progress) {
  prepare(options, progress.step("prepare", 0.5));
  const TexelSpace& space = target_->space();
  if (other_labels_) {
    std::vector<int> asked(std::size_t(space.size()), unseen);
    if (!options.texts("labels").empty())
      asked = app::asked_photographs(options, *session_.scene, *target_, int(names_.size()));
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
  const Composite composite = chosen(options, choice);
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

}  // namespace mq::view

#include "verb_tool.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "shell/arguments.h"
#include "shell/command_words.h"
#include "controls.h"
#include "mq/base/error.h"
#include "mq/base/length.h"
#include "mq/filter/reaction_diffusion.h"
#include "mq/io/atomic_file.h"
#include "shell/results.h"
#include "mq/model/model_shock.h"
#include "options/signal_options.h"
#include "shell/verb.h"
#include "tasks.h"
#include "theme.h"

namespace mq::view {
namespace {

app::Verb verb_named(const std::string& name) {
  std::vector<app::Verb> verbs = app::all_verbs();
  return *std::ranges::find_if(verbs, [&](const app::Verb& v) { return v.table.verb() == name; });
}

/// Those that need no signal, and those that work on colours at vertices where there are no
/// textures.
constexpr std::array<std::string_view, 3> verbs_of_shape = {"geodesic", "lic", "react"};
constexpr std::array<std::string_view, 2> verbs_of_signals = {"denoise", "shock"};

/// Options that verbs refuse at vertices.
constexpr std::array<std::string_view, 8> of_textures = {
    "from-mask", "guide", "guide-edge", "space", "normals", "normal-space", "longest-edge", "method"};

}  // namespace

VerbTool::VerbTool(const std::string& verb, Session& session)
    : session_(session), options_(options_for(verb, session)), verb_(verb) {
  const TexturedModel& scene = *session.scene;
  if (!session.before) {
    const bool of_shape = std::ranges::count(verbs_of_shape, verb) > 0;
    at_vertices_ = !scene.atlas && (of_shape || (std::ranges::count(verbs_of_signals, verb) > 0 &&
                                                 scene.model.colors.channels > 0));
    if (!of_shape && !at_vertices_) refuse_as_the_verb();
  }
  require_usable(scene.defects(), scene.model.path.string());
  texture_name_ = at_vertices_ ? session.free_name("out.ply", Outputs::Kind::model)
                               : session.free_name(session.texture_file("out"), Outputs::Kind::pictures);
}

/// What the verb refuses it says itself, before it works.
void VerbTool::refuse_as_the_verb() const {
  OptionValues trying = options_;
  trying.set("output", {(folder_ / "%s.png").string()});
  trying.set("dry-run", {"true"});
  trying.set("json", {"true"});
  if (verb_ == "filter") trying.set("beta", {"3"});  // which it wants first of all
  app::Terminal silence("view");
  silence.set_voice(app::Terminal::Voice::quiet);
  app::Run run(trying, silence, {});
  verb_named(verb_).run(run);
  throw InvalidInput(fmt::format("{}: has no textures for the tool {} to work on",
                                 session_.scene->model.path.string(), verb_));
}

VerbTool::~VerbTool() { background_.stop(); }

/// Those that say what is computed, in the order of the table.
std::vector<std::string> VerbTool::shown_options() const {
  std::vector<std::string> names;
  for (const Option& option : options_.table().options())
    if (option.place == Option::Place::named && option.group != "Running" &&
        option.group != "Model" && option.group != "Sequences" && option.name != "output" &&
        option.name != "vertices" && option.name != "geometry" && option.group != "Shape" &&
        !(at_vertices_ && std::ranges::count(of_textures, option.name) > 0) && shows(option))
      names.push_back(option.name);
  return names;
}

/// alpha says what length does, each on its own way; presets say rates.
std::string VerbTool::in_force(const std::string& option) const {
  const TexturedModel& scene = *session_.scene;
  const SurfaceScale scale{scene.surface.area, scene.atlas ? scene.atlas->texel_spacing() : 0};
  const auto has = [&](const char* name) {
    return std::ranges::count(options_.table().options(), name, &Option::name) > 0;
  };
  if ((option == "length" || option == "alpha") && has("length") && has("alpha")) {
    const Length spread = app::spread(options_);
    if (spread.unit == Length::Unit::texels && !(scale.texel_spacing > 0)) return {};
    const double alpha = weight_from_length(spread, scale) / scale.area;
    return option == "alpha" ? fmt::format("{:.4g}", alpha)
                             : fmt::format("{:.3g}%", 100 * std::sqrt(alpha));
  }
  if (verb_ == "shock" && option == "time") return plain(ShockRequest{}.time.value);
  if (verb_ == "shock" && (option == "smooth" || option == "smooth-potential")) {
    const Length usual = usual_shock_smoothing(scale);
    return usual.unit == Length::Unit::texels ? fmt::format("{:g}tx", usual.value) : fmt::format("{:g}%", usual.value);
  }
  if ((option == "feed" || option == "kill") && has("preset")) {
    const auto& presets = gray_scott_presets();
    const auto preset = std::ranges::find(presets, options_.text("preset"), &GrayScottPreset::name);
    if (preset != presets.end())
      return fmt::format("{:.4g}", option == "feed" ? preset->rates.feed : preset->rates.kill);
  }
  return {};
}

void VerbTool::edit_option(const std::string& option) {
  tried(session_, [&] {
    OptionValues edited = options_;
    if (edit(edited, option, in_force(option), option_words(name(), option)))
      change(option, edited.given(option) ? edited.texts(option) : std::vector<std::string>{});
  });
}

void VerbTool::panel() {
  const std::vector<std::string>& first = first_options(name());
  const std::vector<std::string> shown = shown_options();
  for (const std::string& option : first)
    if (std::ranges::count(shown, option) > 0) edit_option(option);
  begin_controls();
  stage_controls();
  if (!failure_.empty())
    remark((has_result() ? "What is shown has other options: " : "It could not be made: ") + failure_);
  ImGui::BeginDisabled(!has_result());
  if (ask_to_save(session_, at_vertices_ ? "model" : "texture", texture_name_))
    tried(session_, [&] { save(texture_name_); });
  ImGui::EndDisabled();
  if (!ImGui::CollapsingHeader("more")) return;
  for (const std::string& option : shown)
    if (std::ranges::count(first, option) == 0) edit_option(option);
  copy_button(session_, [&] { return as_command(); });
}

/// Dim while something is missing that only the person has, and once it has begun: what is below stays where it is.
void VerbTool::begin_controls() {
  const bool can = complete(), was_stopped = has_run_ && stale_ && stopped_ && can && !busy();
  if (!can && missing().empty()) return;
  if (was_stopped) remark("It was stopped: what is shown is as it was before.");
  ImGui::BeginDisabled(!can || busy() || (has_run_ && !was_stopped));
  if (ImGui::Button(was_stopped ? "go on" : run_words(name()).c_str(), {-1, 0})) tried(session_, [&] { run(); });
  ImGui::EndDisabled();
  if (!can) remark(missing());
}

/// With the options as they are.
void VerbTool::run() {
  require_complete();
  failure_.clear();
  make_again();
}

std::string VerbTool::as_command() const {
  require_complete();
  OptionValues named = options_;
  named.set("output", {texture_name_});
  return command_words(named);
}

std::string VerbTool::command_words(const OptionValues& options) const {
  return app::command_line(options);
}

void VerbTool::change(const std::string& name, const std::vector<std::string>& values) {
  OptionValues changed = options_;
  for (const auto& group : options_.table().exclusives())
    if (std::ranges::count(group, name) > 0)  // what excludes it is forgotten
      for (const std::string& other : group) changed.reset(other);
  if (values.empty())
    changed.reset(name);
  else
    changed.set(name, as_found(name, values));
  require_keeps(changed);
  options_ = changed;
  failure_.clear();
  if (is_making() && !stale_ && follows(name)) return;
  if (has_run_ || begins_by(name)) make_again();
}

/// Files that are not where the program was started are those beside the model.
std::vector<std::string> VerbTool::as_found(const std::string& option, std::vector<std::string> values) const {
  if (options_.table().find(option).type == Option::Type::path)
    for (std::string& file : values) file = session_.found(file);
  return values;
}

bool VerbTool::complete() const {
  OptionValues values = options_;
  values.set("output", {"out.png"});
  try {
    values.check();
    return true;
  } catch (const InvalidInput&) {
    return false;
  }
}

bool VerbTool::command(const std::vector<std::string>& words) {
  if (words[0] == "set") {
    const Option& option = options_.table().find(words[1]);
    require(option.scope == Option::Scope::result && option.place == Option::Place::named &&
                option.name != "output" && option.name != "vertices",
            fmt::format("'{}' is not an option that the viewer sets", words[1]));
    if (words.size() == 3 && words[2].empty())
      change(words[1], {});
    else
      change(words[1], {words.begin() + 2, words.end()});
    make_again();
  } else if (words[0] == "run") {
    run();
  } else if (words[0] == "stage") {
    std::size_t newest = 0;
    {
      const std::lock_guard lock(stages_mutex_);
      newest = std::max<std::size_t>(1, stages_.size()) - 1;
    }
    const auto number = app::parse_numbers(words[1], 1);
    require(
        words[1] == "last" ||
            (number && number->front() >= 0 && number->front() <= double(newest) &&
             number->front() == std::floor(number->front())),
        fmt::format("found '{}', wanted a whole number from 0 to {}, or last", words[1], newest));
    choose_stage(words[1] == "last" ? newest : std::size_t(number->front()));
  } else if (words[0] == "save-texture") {
    save(words[1]);
  } else if (words[0] == "copy-command") {
    copy_command(session_, words, as_command());
  } else {
    return false;
  }
  return true;
}

void VerbTool::require_complete() const {
  if (complete()) return;
  const std::string wanted = missing();
  throw InvalidInput(fmt::format("{} lacks what it works with: say it first, with 'set' or 'with'{}", name(),
                                 wanted.empty() ? "" : ". " + wanted));
}

void VerbTool::save(const std::string& path) {
  require_complete();
  const Outputs outputs(
      path, session_.scene->model,
      at_vertices_ ? Outputs::Kind::model : Outputs::Kind::pictures);
  session_.run.will_write(outputs.paths(), outputs.folders());
  texture_name_ = path;
  OptionValues saving = options_of_shown();
  saving.set("output", {path});
  saving.set("json", {"true"});  // nothing on standard output
  save_behind(path, saver(saving), [this, of = wanted_run()] {
    saved_run_ = of;
    session_.kept = {};
  });
}

/// Also of what is on its way, which took its time.
std::string VerbTool::unsaved() const {
  if (!has_run_ || !is_worth_asking()) return {};
  if (is_on_its_way())
    return wanted_run() == saved_run_ ? "" : fmt::format("what '{}' is making", tool_words(name()));
  return !has_result() || shown_run_ == saved_run_ ? "" : fmt::format("what '{}' made", tool_words(name()));
}

std::string VerbTool::kept_as() const {
  const bool can = session_.before && !session_.sequence && has_run_ && is_worth_asking() && (has_result() || is_on_its_way());
  return can ? session_.texture_file("out") : "";
}

void VerbTool::keep(const std::string& path) {
  require_complete();
  OptionValues keeping = options_of_shown();
  keeping.set("output", {path});
  keeping.set("json", {"true"});
  save_behind(path, saver(keeping));
}

void VerbTool::save_behind(const std::string& path, Work work, std::function<void()> written) {
  saves_.push_back({path, std::move(work), std::move(written)});
}

void VerbTool::give_up_saves() {
  if (saves_.empty()) return;
  std::vector<std::string> paths;
  for (const Save& save : saves_) paths.push_back(save.path);
  session_.say(fmt::format("not saved: {}", fmt::join(paths, ", ")));
  saves_.clear();
  writing_ = false;
}

/// Of what takes so long that a person wonders.
std::string VerbTool::working() const {
  constexpr double a_while = 0.5;  // seconds
  if (!background_.busy() || background_.seconds() < a_while) return {};
  const std::string what = writing_ ? saving() + " is being written" : work_words();
  return fmt::format("{}: {} (Escape stops it)", what, background_.how_far());
}

void VerbTool::cancel() {
  if (is_making()) stale_ = true;
  background_.cancel();
  stopped_ = true;
  give_up_saves();
}

void VerbTool::frame() {
  {
    const std::lock_guard lock(stages_mutex_);
    if (at_newest_ && !stages_.empty()) {
      stage_ = newest_;
      session_.show(stages_[stage_].pictures, stages_[stage_].colours);
    }
  }
  if (background_.busy()) return;
  const bool has_written = std::exchange(writing_, false);
  if (const std::string error = background_.error(); !error.empty()) {
    if (has_written) {
      saves_.pop_front();
    } else {
      stopped_ = true;
      stale_ = false;
      failure_ = error;
      give_up_saves();
    }
    throw SolverError(error);
  }
  if (has_written) {
    const Save save = std::move(saves_.front());
    saves_.pop_front();
    if (save.written) save.written();
  } else if (has_run_ && !stopped_) {
    shown_run_ = runs_;
  }
  if (stale_ && !stopped_ && !complete()) show_nothing();
  if (stale_ && !stopped_) {
    stale_ = false;
    {
      const std::lock_guard lock(stages_mutex_);
      other_run_ = at_newest_ = true;
    }
    has_run_ = true;
    ++runs_;
    before_make(options_);
    background_.start(
        [this, options = options_](const Progress& progress) { make(options, progress); });
  } else if (!saves_.empty()) {
    writing_ = true;
    background_.start(saves_.front().work);
  }
}

/// Until something is set: nothing is made of options that lack something.
void VerbTool::show_nothing() {
  stopped_ = true;
  has_run_ = false;
  forget_stages();
  session_.show(nullptr, nullptr);
}

/// Pictures of numbers where the model's are.
void VerbTool::make(const OptionValues& options, const Progress& progress) {
  OptionValues making = options;
  making.set("output", {(folder_ / (at_vertices_                           ? "out.ply"
                                    : holds_numbers(session_.scene->model) ? "%s.exr"
                                                                           : "%s.png"))
                            .string()});
  making.set("json", {"true"});
  app::Terminal silence("view");
  silence.set_voice(app::Terminal::Voice::quiet);
  app::Run run(making, silence, progress);
  run.onlooker = [this](const std::string& what, const Model& model) { show_stage(what, model); };
  std::optional<Model> made;
  run.receiver = [&](Model model) { made = std::move(model); };
  verb_named(verb_).run(run);
  found_ = run.result;
  if (made) show(*made);
}

void VerbTool::write(const OptionValues& options, const Progress& progress) {
  app::Run run(options, session_.run.terminal(), progress);
  verb_named(verb_).run(run);
}

std::optional<Look::Paint> VerbTool::shown_as() const {
  if (session_.before) return {};
  return at_vertices_ ? Look::Paint::vertex_colours : Look::Paint::texture;
}

void VerbTool::stop() {
  if (is_making()) stale_ = true;
  background_.stop();
  stopped_ = true;
  give_up_saves();
}

nlohmann::ordered_json VerbTool::report() const {
  nlohmann::ordered_json stages = nlohmann::ordered_json::array();
  const std::lock_guard lock(stages_mutex_);
  for (const Stage& stage : stages_) stages.push_back(stage.name);
  return {{"name", name()}, {"found", found_}, {"stages", stages}};
}

}  // namespace mq::view

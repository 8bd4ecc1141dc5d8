#include "verb_tool.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <imgui.h>
#include <stdlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "arguments.h"
#include "command_words.h"
#include "controls.h"
#include "mq/base/error.h"
#include "mq/io/atomic_file.h"
#include "outputs.h"
#include "verb.h"

namespace mq::view {
namespace {

namespace fs = std::filesystem;

/// Of all stages of a run together, at 4 or 16 bytes each; the first ones are let go.
constexpr std::int64_t most_texels_kept = 256 << 20;

fs::path temporary_folder() {
  std::string name = (fs::temp_directory_path() / "marquetry-view-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw IoError(name + ": no temporary folder can be made");
  return name;
}

app::Verb verb_named(const std::string& name) {
  std::vector<app::Verb> verbs = app::all_verbs();
  return *std::ranges::find_if(verbs, [&](const app::Verb& v) { return v.table.verb() == name; });
}

}  // namespace

VerbTool::VerbTool(const std::string& verb, Session& session)
    : session_(session), options_(options_for(verb, session)), verb_(verb) {
  require(session.before != nullptr, fmt::format("{}: has no textures for the tool {} to work on",
                                                 session.scene->model.path.string(), verb));
  app::require_usable(app::scene_defects(*session.scene), session.scene->model.path.string());
  folder_ = temporary_folder();
}

VerbTool::~VerbTool() {
  background_.stop();
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

/// Those that say what is computed, in the order of the table.
std::vector<std::string> VerbTool::shown_options() const {
  std::vector<std::string> names;
  for (const Option& option : options_.table().options())
    if (option.place == Option::Place::named && option.group != "Running" &&
        option.group != "Model" && option.group != "Sequences" && option.name != "output" &&
        option.name != "vertices" && option.name != "geometry" && option.group != "Shape" &&
        shows(option))
      names.push_back(option.name);
  return names;
}

void VerbTool::panel() {
  for (const std::string& option : shown_options()) {
    OptionValues edited = options_;
    if (edit(edited, option)) change(option, edited.texts(option));
  }
  stage_controls();
  const auto tried = [&](const auto& what) {
    try {
      what();
    } catch (const Error& error) {
      session_.say(error.what());
    }
  };
  ImGui::InputText("##texture", texture_name_.data(), texture_name_.size());
  ImGui::SameLine();
  if (ImGui::Button("save texture")) tried([&] { save(texture_name_.data()); });
  if (ImGui::Button("copy as command"))
    tried([&] {
      OptionValues named = options_;
      named.set("output", {texture_name_.data()});
      const std::string line = command_words(named);
      ImGui::SetClipboardText(line.c_str());
      session_.say(line);
    });
}

std::string VerbTool::command_words(const OptionValues& options) const {
  return app::command_line(options);
}

void VerbTool::change(const std::string& name, const std::vector<std::string>& values) {
  OptionValues changed = options_;
  for (const auto& group : options_.table().exclusives())
    if (std::ranges::count(group, name) > 0) {
      // What excludes it is forgotten.
      changed = options_for(verb_, session_);
      for (const Option& option : options_.table().options())
        if (options_.given(option.name) && std::ranges::count(group, option.name) == 0)
          changed.set(option.name, options_.texts(option.name));
      break;
    }
  changed.set(name, values);
  options_ = changed;
  stale_ = true;
  stopped_ = false;
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
                option.name != "output",
            fmt::format("'{}' is not an option that the viewer sets", words[1]));
    change(words[1], {words.begin() + 2, words.end()});
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
    require_complete();
    OptionValues named = options_;
    named.set("output", {"out.png"});
    const std::string line = command_words(named) + "\n";
    require(words.size() == 2, "wanted: copy-command FILE");
    session_.run.will_write({words[1]});
    write_file(words[1], std::as_bytes(std::span(line.data(), line.size())));
  } else {
    return false;
  }
  return true;
}

void VerbTool::require_complete() const {
  require(complete(),
          fmt::format("{} lacks what it works with: say it first, with 'set' or 'with'", verb_));
}

void VerbTool::save(const std::string& path) {
  require_complete();
  const app::Outputs outputs(path, session_.scene->model, app::Outputs::Kind::pictures);
  session_.run.will_write(outputs.paths(), outputs.folder());
  saves_.push_back({path, options_});
}

void VerbTool::give_up_saves() {
  if (saves_.empty()) return;
  std::vector<std::string> paths;
  for (const Save& save : saves_) paths.push_back(save.path);
  session_.say(fmt::format("not saved: {}", fmt::join(paths, ", ")));
  saves_.clear();
  writing_ = false;
}

void VerbTool::cancel() {
  background_.cancel();
  stopped_ = true;
  give_up_saves();
}

void VerbTool::frame() {
  {
    const std::lock_guard lock(stages_mutex_);
    if (at_newest_ && !stages_.empty()) {
      stage_ = stages_.size() - 1;
      session_.result = stages_[stage_].pictures;
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
      give_up_saves();
    }
    throw SolverError(error);
  }
  if (has_written) {
    session_.say("saved " + saves_.front().path);
    saves_.pop_front();
  }
  if (stale_ && !stopped_ && !complete()) stopped_ = true;  // until something is set
  if (stale_ && !stopped_) {
    stale_ = false;
    {
      const std::lock_guard lock(stages_mutex_);
      other_run_ = at_newest_ = true;
    }
    before_make(options_);
    background_.start(
        [this, options = options_](const Progress& progress) { make(options, progress); });
  } else if (!saves_.empty()) {
    writing_ = true;
    OptionValues saving = options_to_save(saves_.front().options);
    saving.set("output", {saves_.front().path});
    saving.set("json", {"true"});  // nothing on standard output
    background_.start([this, saving](const Progress& progress) {
      app::Run run(saving, session_.run.terminal(), progress);
      verb_named(verb_).run(run);
    });
  }
}

void VerbTool::make(const OptionValues& options, const Progress& progress) {
  OptionValues making = options;
  const bool numbers =
      std::ranges::any_of(session_.scene->model.textures, [](const Texture& texture) {
        return texture.format.depth == Depth::half || texture.format.depth == Depth::f32;
      });
  making.set("output", {(folder_ / (numbers ? "%s.exr" : "%s.png")).string()});
  making.set("json", {"true"});
  app::Terminal silence("view");
  silence.set_voice(app::Terminal::Voice::quiet);
  app::Run run(making, silence, progress);
  run.onlooker = [this](const std::string& what, const std::vector<Texture>& textures) {
    show_stage(what, textures);
  };
  verb_named(verb_).run(run);
  found_ = run.result;
  found_.erase("outputs");
  std::vector<Texture> pictures;
  const app::Outputs outputs(making.text("output"), session_.scene->model,
                             app::Outputs::Kind::pictures);
  for (const fs::path& path : outputs.paths()) pictures.push_back(read_texture(path));
  show(pictures);
}

void VerbTool::show_stage(const std::string& name, const std::vector<Texture>& pictures) {
  auto set = std::make_shared<TextureSet>(pictures, largest_side_);
  std::int64_t texels = 0;
  for (const Texture& picture : pictures) texels += picture.pixels.pixel_count();
  const std::lock_guard lock(stages_mutex_);
  if (std::exchange(other_run_, false)) stages_.clear();
  stages_.push_back({name, std::move(set)});
  while (stages_.size() > 1 && std::int64_t(stages_.size()) * texels > most_texels_kept)
    stages_.erase(stages_.begin());
}

/// Where work is shown on its way, what is shown of it.
void VerbTool::stage_controls() {
  int stage = int(stage_), count = 0;
  std::string name;
  {
    const std::lock_guard lock(stages_mutex_);
    count = int(stages_.size());
    if (stage < count) name = stages_[stage_].name;
  }
  if (count > 1 && ImGui::SliderInt("stage", &stage, 0, count - 1, name.c_str()))
    choose_stage(std::size_t(stage));
}

void VerbTool::choose_stage(std::size_t stage) {
  const std::lock_guard lock(stages_mutex_);
  require(stage < stages_.size(),
          fmt::format("there is no stage {}: {} to {} are there", stage, 0, stages_.size() - 1));
  stage_ = stage;
  at_newest_ = stage + 1 == stages_.size();
  session_.result = stages_[stage].pictures;
}

void VerbTool::stop() {
  background_.stop();
  stopped_ = true;
  give_up_saves();
}

nlohmann::ordered_json VerbTool::report() const {
  nlohmann::ordered_json stages = nlohmann::ordered_json::array();
  const std::lock_guard lock(stages_mutex_);
  for (const Stage& stage : stages_) stages.push_back(stage.name);
  return {{"name", verb_}, {"found", found_}, {"stages", stages}};
}

}  // namespace mq::view

#include "verb_tool.h"

#include <fmt/format.h>
#include <imgui.h>
#include <stdlib.h>

#include <algorithm>
#include <cstring>

#include "command_words.h"
#include "controls.h"
#include "mq/base/error.h"
#include "mq/io/atomic_file.h"
#include "outputs.h"
#include "verb.h"

namespace mq::view {
namespace {

namespace fs = std::filesystem;

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
  if (ImGui::Button("copy as command")) {
    OptionValues named = options_;
    named.set("output", {texture_name_.data()});
    const std::string line = app::command_line(named);
    ImGui::SetClipboardText(line.c_str());
    session_.say(line);
  }
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
  } else if (words[0] == "save-texture") {
    save(words[1]);
  } else if (words[0] == "copy-command") {
    OptionValues named = options_;
    named.set("output", {"out.png"});
    const std::string line = app::command_line(named) + "\n";
    require(words.size() == 2, "wanted: copy-command FILE");
    session_.run.will_write({words[1]});
    write_file(words[1], std::as_bytes(std::span(line.data(), line.size())));
  } else {
    return false;
  }
  return true;
}

void VerbTool::save(const std::string& path) {
  const app::Outputs outputs(path, session_.scene->model, app::Outputs::Kind::pictures);
  session_.run.will_write(outputs.paths(), outputs.folder());
  to_save_ = path;
  stale_ = true;
  stopped_ = false;
}

void VerbTool::frame() {
  if (background_.busy()) return;
  if (const std::string error = background_.error(); !error.empty()) {
    stopped_ = true;
    stale_ = false;
    throw SolverError(error);
  }
  if (made_) session_.result = std::move(made_);
  if (!stale_ || stopped_) return;
  if (!complete()) {
    stopped_ = true;  // until something is set
    return;
  }
  stale_ = false;
  const std::string path = std::exchange(to_save_, {});
  background_.start([this, path, options = options_](const Progress& progress) {
    if (path.empty()) return make(options, progress);
    OptionValues saving = options;
    saving.set("output", {path});
    saving.set("json", {"true"});  // nothing on standard output
    app::Run run(saving, session_.run.terminal(), progress);
    verb_named(verb_).run(run);
  });
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
  verb_named(verb_).run(run);
  found_ = run.result;
  found_.erase("outputs");
  std::vector<Texture> pictures;
  const app::Outputs outputs(making.text("output"), session_.scene->model,
                             app::Outputs::Kind::pictures);
  for (const fs::path& path : outputs.paths()) pictures.push_back(read_texture(path));
  show(pictures);
}

void VerbTool::show(const std::vector<Texture>& pictures) {
  made_ = std::make_unique<TextureSet>(pictures, largest_side_);
}

void VerbTool::stop() {
  background_.stop();
  stopped_ = true;
}

nlohmann::ordered_json VerbTool::report() const { return {{"name", verb_}, {"found", found_}}; }

}  // namespace mq::view

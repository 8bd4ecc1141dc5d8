// What a tool made as the model's texture, which the next one begins with: written to files of the window's own, and
// the model opened with these, so that what tools do, and the verbs behind them, is what they do with any files.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>

#include "controls.h"
#include "mq/base/error.h"
#include "mq/io/path_status.h"
#include "theme.h"
#include "viewer.h"

namespace mq::view {

namespace fs = std::filesystem;

void Viewer::keep() {
  require(tool_ && !tool_->kept_as().empty(), "there is nothing to keep: no tool in hand made textures for this model");
  keep_and_go_on([this, name = tool_name_, task = task_] {
    change_tool(name);
    task_ = task;
  });
}

/// Once the tool has written it.
void Viewer::keep_and_go_on(std::function<void()> act) {
  if (!kept_folder_) kept_folder_ = std::make_unique<TemporaryFolder>("marquetry-view-", "what is kept on the model");
  const fs::path folder = *kept_folder_ / std::to_string(++kept_), file = folder / tool_->kept_as();
  fs::create_directory(folder);
  Session::Kept kept;
  kept.files = Outputs(file.string(), session_.scene->model, Outputs::Kind::pictures).paths();
  kept.words = fmt::format("what '{}' made", tool_words(tool_name_));
  if (const std::string before = session_.kept.words; !before.empty() && !before.ends_with(kept.words))
    kept.words = before + " and " + kept.words;
  tool_->keep(file.string());
  question_ = "It becomes the model's texture as soon as it is worked out.";
  on_yes_ = on_no_ = {};
  on_saved_ = [this, kept, act = std::move(act)] {
    if (std::ranges::all_of(kept.files, [](const fs::path& path) { return is_there(path); })) open_kept(kept, act);
  };
}

void Viewer::open_kept(const Session::Kept& kept, std::function<void()> act) {
  std::vector<std::string> files;
  for (const fs::path& path : kept.files) files.push_back(path.string());
  OptionValues options = session_.opened;
  options.set("texture", files);
  cancel_loading();
  keeping_.emplace(kept, std::move(act));
  loader_.ask("what is kept on the model", [options, &terminal = session_.run.terminal(),
                                            largest = TextureSet::largest_side()](const Progress& progress) {
    return load_files(options, terminal, largest, progress);
  });
}

/// In the task and with the view that there are.
void Viewer::adopt_kept() {
  const auto [kept, act] = *std::exchange(keeping_, std::nullopt);
  change_tool("none");
  tour_.stop();
  pick_ = {};
  auto photographs = session_.photographs;  // stay as long as the model
  session_.open(loader_.take());
  session_.photographs = std::move(photographs);
  session_.kept = kept;
  session_.say("kept on the model, and not saved: " + kept.words);
  act();
}

/// Copies are what saving would have written.
void Viewer::save_kept() {
  const Outputs outputs(session_.free_name(session_.texture_file("out"), Outputs::Kind::pictures),
                        session_.scene->model, Outputs::Kind::pictures);
  session_.run.will_write(outputs.paths(), outputs.folders());
  std::vector<std::string> files;
  for (std::size_t i = 0; i < outputs.paths().size(); ++i) {
    const fs::path& path = outputs.paths()[i];
    std::error_code failure;
    fs::copy_file(session_.kept.files[i], path, fs::copy_options::overwrite_existing, failure);
    if (failure) throw IoError(fmt::format("{}: cannot be written: {}", path.string(), failure.message()));
    files.push_back(path.string());
    session_.say("wrote " + path.string());
  }
  session_.opened.set("texture", files);
  session_.kept = {};
}

void Viewer::kept_controls() {
  if (session_.kept.words.empty()) return;
  ImGui::Separator();
  remark("On the model: " + session_.kept.words + ", not saved.");
  if (!(tool_ && tool_->has_changed()) && ImGui::SmallButton("save it")) tried(session_, [&] { save_kept(); });
}

}  // namespace mq::view

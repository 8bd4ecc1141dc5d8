// marquetry-view [MESH] [TEXTURE...]: what `marquetry view` becomes.
#include <imgui.h>

#include <backends/imgui_impl_opengl3.h>
#include <algorithm>
#include <cmath>
#include <optional>

#include "shell/arguments.h"
#include "mq/base/error.h"
#include "mq/base/stopwatch.h"
#include "mq/io/model.h"
#include "shell/program.h"
#include "options/model_options.h"
#include "script.h"
#include "viewer.h"

namespace mq::view {
namespace {

/// ImGui's state, as long as there is a window.
struct Interface {
  Interface() {
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;
  }
  ~Interface() { ImGui::DestroyContext(); }
};

struct Drawing {
  Drawing() { ImGui_ImplOpenGL3_Init("#version 330 core"); }
  ~Drawing() { ImGui_ImplOpenGL3_Shutdown(); }
};

/// Until the window is closed.
void attend(Viewer& viewer, Session& session, Display& display) {
  while (!viewer.closed()) {
    session.run.progress().check();
    viewer.frame();
    if (display.closing()) viewer.close();
    viewer.rethrow_first();
    if (viewer.busy())
      viewer.pace();
    else if (!session.playing)
      display.rest();
  }
}

/// What is shown first; null where no model was named.
std::unique_ptr<LoadedModel> first_model(app::Run& run, std::shared_ptr<Sequence> sequence,
                                         std::optional<TexturedModel> scene) {
  if (!scene) return nullptr;
  auto first =
      std::make_unique<LoadedModel>(std::move(*scene), TextureSet::largest_side(), Progress());
  if (sequence) first->drawn->triangle_colours = sequence->lifespans(0);
  first->sequence = std::move(sequence);
  first->opened = run.options();
  return first;
}

app::Exit view(app::Run& run) {
  const Stopwatch start;
  const OptionValues& options = run.options();
  std::optional<Script> script;
  if (options.given("script")) script.emplace(options.text("script"));
  const bool alone = script || options.given("screenshot");
  require(script || !options.flag("in-window"),
          "--in-window shows a script's session: give --script too");
  std::shared_ptr<Sequence> sequence;
  std::optional<TexturedModel> scene;
  // A person sees what there is of a model while it is read; scripts and pictures are of all of it.
  const bool at_once = !alone && !run.dry_run() && options.given("mesh");
  if (options.given("mesh") && !at_once) {
    if (names_sequence(options.text("mesh"))) sequence = open_sequence(run);
    scene = sequence ? sequence->scene(0, {})
                     : app::read_textured_model(run, MissingPictures::assume, 1);
    warn_of(run, *scene);
  }
  if (options.given("screenshot")) {
    require_screenshot(options.text("screenshot"));
    run.will_write({options.text("screenshot")});
  }
  if (run.dry_run()) return app::Exit::done;

  const auto size = *app::parse_size(options.text("size"));
  const Interface interface;
  const std::unique_ptr<Display> display = alone && !options.flag("in-window")
                                               ? open_offscreen(size[0], size[1])
                                               : open_window(size[0], size[1], "marquetry");
  const double scale = options.given("scale") ? options.number("scale") : display->scale();
  if (!options.given("size"))
    display->resize(int(std::lround(size[0] * scale)), int(std::lround(size[1] * scale)));
  set_sizes(scale);
  const Drawing drawing;
  Session session(run, first_model(run, std::move(sequence), std::move(scene)));
  Viewer viewer(session, *display, scale,
                options.text("theme") == "light" ? Theme::light : Theme::dark, start);
  if (at_once) viewer.open_first();
  if (script) {
    script->play(viewer, session);
  } else if (alone) {
    viewer.frame();
    viewer.frame();
  } else {
    attend(viewer, session, *display);
  }
  if (viewer.tool()) {
    viewer.tool()->stop();
    run.result["tool"] = viewer.tool()->report();
  }
  for (const Session::Upload& upload : session.uploads) {
    run.result["uploads"].push_back({{"texels", upload.texels}, {"seconds", upload.seconds}});
  }
  const Session::FirstPictures& first = session.first_pictures;
  run.result["first_pictures"] = {{"window", first.window}, {"shape", first.shape}, {"coarse", first.coarse}, {"all", first.all}};
  run.result["title"] = viewer.title();
  if (options.given("screenshot")) {
    viewer.screenshot(options.text("screenshot"));
    run.result["outputs"] = {options.text("screenshot")};
  }
  return app::Exit::done;
}

}  // namespace
}  // namespace mq::view

int main(int argc, char** argv) {
  std::vector<mq::app::Verb> verbs = mq::app::all_verbs();
  std::erase_if(verbs, [](const mq::app::Verb& verb) { return verb.table.verb() != "view"; });
  verbs.front().run = mq::view::view;
  std::vector<std::string> words = {"view"};
  words.insert(words.end(), argv + 1, argv + argc);
  return mq::app::run_program(verbs, words);
}

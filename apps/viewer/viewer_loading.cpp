// Models, textures and frames of a sequence that are loaded while others are shown.
#include <fmt/format.h>

#include "controls.h"
#include "mq/base/error.h"
#include "recent.h"
#include "shell/results.h"
#include "viewer.h"

namespace mq::view {
namespace {

bool names_mesh(const std::string& file) {
  return names_model(file) || (names_sequence(file) && !names_picture(file));
}

}  // namespace

void Viewer::open_frame(int frame) {
  require(tool_ == nullptr,
          "a tool works on one frame: put it away, with the tool none, to go to another");
  asked_frame_ = frame;
  loader_.ask(
      "frame " + std::to_string(session_.sequence->number(frame)),
      [sequence = session_.sequence, frame, largest = TextureSet::largest_side()](
          const Progress& progress) { return load_frame(sequence, frame, largest, progress); });
}

namespace {

/// Options of the verb view as they were given, without files.
OptionValues without_files(const OptionValues& given) {
  OptionValues options(given.table());
  for (const Option& option : options.table().options())
    if (given.given(option.name) && option.name != "texture" && option.name != "mesh")
      options.set(option.name, given.texts(option.name));
  return options;
}

}  // namespace

/// The first of pictures without a model is the model, as on the command line.
void Viewer::open(const std::vector<std::string>& files) {
  std::vector<std::string> meshes, pictures;
  for (const std::string& file : files) (names_mesh(file) ? meshes : pictures).push_back(file);
  require(meshes.size() <= 1, fmt::format("{} models were given, and one is shown", meshes.size()));
  if (meshes.empty() && session_.empty) {
    meshes = {pictures.front()};
    pictures.erase(pictures.begin());
  }
  OptionValues options = without_files(session_.opened);
  if (meshes.empty()) meshes = session_.opened.texts("mesh");
  options.set("mesh", meshes);
  if (!pictures.empty()) options.set("texture", pictures);
  session_.playing = false;
  asked_to_open_ = Stopwatch();
  cancel_loading();
  TakeLook take_look;
  if (session_.empty) take_look = [this](std::unique_ptr<FirstLook> look) { loader_.give(std::move(look)); };
  loader_.ask(files.front(), [options, take_look, &terminal = session_.run.terminal(),
                              largest = TextureSet::largest_side()](const Progress& progress) {
    return load_files(options, terminal, largest, progress, take_look);
  });
}

void Viewer::open_first() {
  const OptionValues options = session_.run.options();
  for (const char* name : {"mesh", "texture"}) session_.opened.reset(name);
  is_first_ = true;
  loader_.ask(options.text("mesh"), [this, options, &terminal = session_.run.terminal(),
                                     largest = TextureSet::largest_side()](const Progress& progress) {
    return load_files(
        options, terminal, largest, progress, [this](std::unique_ptr<FirstLook> look) { loader_.give(std::move(look)); },
        MissingPictures::assume);
  });
}

void Viewer::rethrow_first() {
  if (first_failure_) std::rethrow_exception(first_failure_);
}

void Viewer::open_sample(const std::string& name) {
  session_.playing = false;
  asked_to_open_ = Stopwatch();
  cancel_loading();
  loader_.ask("the sample " + name,
              [name, options = without_files(session_.opened), &terminal = session_.run.terminal(),
               largest = TextureSet::largest_side()](const Progress& progress) {
                return load_sample(name, options, terminal, largest, progress);
              });
}

void Viewer::cancel_loading() {
  loader_.cancel();
  keeping_.reset();
  is_first_ = false;
}

void Viewer::take_loaded() {
  if (!loader_.ready() || !question_.empty()) return;
  const LoadedModel& loaded = loader_.peek();
  if (keeping_) return adopt_kept();
  if (loaded.opened) {
    const std::string file = loaded.scene->model.path.string();
    unless_lost(
        Leaving::model, "show " + file, [this] { adopt(loader_.take()); }, [this] { loader_.cancel(); });
    return;
  }
  // What was loaded ahead stays until its time has come; a tool may have been taken since.
  if (tool_ || loaded.sequence != session_.sequence) return loader_.cancel();
  if (session_.playing && !scripted_ && played_.seconds() < 0.04) return;
  played_ = Stopwatch();
  adopt(loader_.take());
}

void Viewer::adopt(std::unique_ptr<LoadedModel> loaded) {
  const bool other = loaded->opened.has_value();
  if (other) app::will_read_model(session_.run, loaded->scene->model);
  const bool other_mesh =
      other && (session_.empty || loaded->opened->texts("mesh") != session_.opened.texts("mesh"));
  const bool turned = std::exchange(look_, nullptr) != nullptr && turned_;
  const std::string cameras = loaded->cameras.string();
  change_tool("none");
  tour_.stop();
  pick_ = {};
  session_.open(std::move(loaded));
  if (!other) return;
  session_.refusal.clear();
  if (other_mesh) photographs_tool_ = "texture";
  const double before = asked_to_open_.seconds();
  std::erase_if(session_.news, [&](const Session::News& one) { return one.since.seconds() > before; });
  picture_name_ = session_.free_file("view.png");
  app::describe_input(session_.run, *session_.scene);
  if (std::exchange(is_first_, false)) session_.run.found(session_.scene->defects());
  opened_ = true;
  if (other_mesh && session_.sequence) task_ = Task::play;
  if (task_ == Task::play && !session_.sequence) task_ = Task::look;
  if (!scripted_) remember_opened();
  session_.say("opened " + session_.scene->model.path.string());
  place_panes();
  if (other_mesh && !turned) home();
  home_atlas();
  if (cameras.empty()) return;
  session_.photographs[{"texture", "cameras"}] = {cameras};
  change_tool("texture");
}

void Viewer::close_model() {
  require(!session_.empty, "there is no model to close");
  unless_lost(Leaving::model, "close the model", [this] {
    loader_.cancel();
    change_tool("none");
    tour_.stop();
    pick_ = {};
    session_.close();
    task_ = Task::look;
    wipes_for_task_ = opened_ = false;
  });
}

void Viewer::remember_opened() {
  if (session_.empty) return;
  tried(session_, [&] { remember(session_.opened.text("mesh")); });
  recent_ = recent_files();
}

/// The next frame of what is played is loaded while this one is shown, 25 a second; in scripts one
/// for each picture.
void Viewer::play() {
  if (!session_.playing || tool_ || !session_.sequence || loader_.busy()) return;
  open_frame((session_.frame + 1) % session_.sequence->count());
}

}  // namespace mq::view

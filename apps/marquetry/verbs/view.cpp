// marquetry view [MESH] [TEXTURE...]: look at a model, and work on it with brushes and sliders.
//
// The viewer is a program of its own, marquetry-view, which this verb becomes: so that marquetry
// itself needs no OpenGL, and runs where there is none.
#include <fmt/format.h>
#include <unistd.h>

#include <cstring>

#include "shell/arguments.h"
#include "shell/command_words.h"
#include "mq/base/error.h"
#include "shell/run.h"
#include "options/model_options.h"
#include "shell/verb.h"

namespace mq::app {
namespace {

/// Beside this program.
std::filesystem::path viewer() {
  std::error_code failure;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", failure);
  return failure ? "marquetry-view" : self.parent_path() / "marquetry-view";
}

/// Does not return where the viewer can be started.
Exit become_viewer(Run& run) {
  const std::filesystem::path program = viewer();
  std::error_code ignored;
  if (!std::filesystem::exists(program, ignored))
    throw Unsupported(fmt::format(
        "{}: is not there: this marquetry was built without its viewer; install libglfw3-dev, "
        "libimgui-dev and libepoxy-dev (scripts/install_packages does) and build again",
        program.string()));
  std::vector<std::string> words = command_words(run.options());
  words[0] = program.string();
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  execv(program.c_str(), argv.data());
  throw IoError(fmt::format("{}: cannot be started: {}", program.string(), std::strerror(errno)));
}

}  // namespace

Verb view_verb() {
  using Type = Option::Type;
  OptionTable table(
      "view",
      "Look at a model in a window, and work on its textures with a brush, sliders and "
      "the mouse.");
  table.example("", "a window to open models in, with samples");
  table.example("scan.obj", "a window on a model");
  table.example("scan.obj sharp.png", "the same with another texture");
  OptionTable model("view", "");
  add_model_options(model,
                    "the model: OBJ, PLY, glTF or GLB; a picture; or a sequence. Without one the "
                    "window offers to open one");
  for (Option option : model.options()) {
    option.required = false;
    table.add(option);
  }
  table.add({.name = "script",
             .type = Type::path,
             .group = "Without a person",
             .help = "do what this file says, one command a line, and end",
             .details =
                 "Nothing is shown on a screen, and none is needed. The page of this verb lists "
                 "the commands."});
  table.add({.name = "screenshot",
             .type = Type::path,
             .group = "Without a person",
             .help = "write a picture of the window at the end of the script",
             .details = "PNG, JPEG or TIFF. Without a script of the window as it opens."});
  table.add({.name = "in-window",
             .group = "Without a person",
             .help = "show the script's session in a window while it runs"});
  table.add({.name = "size",
             .letter = 's',
             .type = Type::text,
             .default_value = "1400x800",
             .accepts =
                 [](const std::string& text) {
                   const auto size = parse_size(text);
                   return size && (*size)[0] >= 640 && (*size)[1] >= 400 && (*size)[0] <= 8192 &&
                          (*size)[1] <= 8192;
                 },
             .wanted = "pixels, such as 1400x800: at least 640x400, at most 8192 a side",
             .metavar = "WxH",
             .group = "Window",
             .help = "pixels of the window",
             .details = "The default is times --scale where the window is on a screen."});
  table.add({.name = "scale",
             .type = Type::number,
             .least = 0.5,
             .most = 4,
             .metavar = "N",
             .group = "Window",
             .help = "size of letters, sliders and buttons; 2 for screens of very small pixels",
             .details = "Otherwise what the screen is set to, and 1 without one."});
  table.add({.name = "theme",
             .type = Type::choice,
             .default_value = "dark",
             .choices = {"dark", "light"},
             .group = "Window",
             .help = "colours of the panels"});
  return {table, become_viewer};
}

}  // namespace mq::app

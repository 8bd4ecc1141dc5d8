#include "shell/results.h"

#include <algorithm>
#include <utility>

#include "mq/io/document.h"
#include "mq/io/file_names.h"
#include "mq/io/held_files.h"

namespace mq::app {

namespace {

/// glTF has green up: of a normal map whose green is down it is turned over, where a file of another
/// format becomes glTF.
void turn_green_up(Run& run, const Outputs& outputs, Model& model) {
  const OptionValues& options = run.options();
  const bool processes_normals = std::ranges::any_of(
      options.table().options(), [](const Option& option) { return option.name == "normals"; });
  if (!processes_normals || !options.has("normal-space") || options.text("normal-space") != "directx") return;
  const bool becomes_gltf = !outputs.paths().empty() && names_gltf(outputs.paths().front()) &&
                            !(model.document && model.document->is_gltf());
  if (!becomes_gltf) return;
  for (Texture& texture : model.textures) {
    if (texture.pixels.channels() < 3) continue;
    for (int y = 0; y < texture.pixels.height(); ++y)
      for (int x = 0; x < texture.pixels.width(); ++x) {
        float& green = texture.pixels.pixel(x, y)[1];
        green = 1 - green;
      }
  }
  run.terminal().remark("green of the normal map points up now, as glTF has it");
}

}  // namespace

void write_outputs(Run& run, const Outputs& outputs, Model model, const Progress& progress) {
  if (run.receiver) return run.receiver(std::move(model));
  turn_green_up(run, outputs, model);
  for (const std::string& note : outputs.write(std::move(model), progress))
    run.terminal().remark(note);
  say_written(run, outputs.paths());
}

void remark_written(Run& run, const std::filesystem::path& path) {
  if (!names_standard_output(path)) run.terminal().remark("wrote " + path.string());
}

void say_written(Run& run, const std::vector<std::filesystem::path>& paths) {
  Json written = Json::array();
  for (const std::filesystem::path& path : paths) {
    written.push_back(path.string());
    remark_written(run, path);
  }
  run.result["outputs"] = written;
}

}  // namespace mq::app

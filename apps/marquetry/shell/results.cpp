#include "shell/results.h"

namespace mq::app {

void write_outputs(Run& run, const Outputs& outputs, Model model, const Progress& progress) {
  if (run.receiver) return run.receiver(std::move(model));
  for (const std::string& note : outputs.write(std::move(model), progress))
    run.terminal().remark(note);
  say_written(run, outputs.paths());
}

void say_written(Run& run, const std::vector<std::filesystem::path>& paths) {
  Json written = Json::array();
  for (const std::filesystem::path& path : paths) {
    written.push_back(path.string());
    run.terminal().remark("wrote " + path.string());
  }
  run.result["outputs"] = written;
}

}  // namespace mq::app

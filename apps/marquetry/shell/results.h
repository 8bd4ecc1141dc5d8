#pragma once
/// Results written, and said.

#include <filesystem>
#include <vector>

#include "mq/model/outputs.h"
#include "shell/run.h"

namespace mq::app {

/// Writes, remarks what is worth telling and which files there are now, and puts these into the
/// result as "outputs". Where the run has a receiver, that is given the model instead.
void write_outputs(Run& run, const Outputs& outputs, Model model, const Progress& progress);

/// Remarks that this file was written; not of what is on its way to standard output, which is said once it is there.
void remark_written(Run& run, const std::filesystem::path& path);

/// Remarks that these files were written and puts them into the result as "outputs".
void say_written(Run& run, const std::vector<std::filesystem::path>& paths);

}  // namespace mq::app

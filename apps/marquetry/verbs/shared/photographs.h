#pragma once
/// Photographs with their cameras: which, and how a texture is made of them.

#include <vector>

#include "mq/io/cameras.h"
#include "mq/model/photograph_texture.h"
#include "shell/run.h"

namespace mq::app {

/// Adds --cameras, --images and all that says what photographs show and which are chosen.
void add_photograph_options(OptionTable& table);

/// Those that --cameras names; remarks on what is left out. Refuses pictures that cannot be read, unless they are to be
/// skipped, or do not fit their cameras, before any work. Throws `InvalidInput` or `IoError` naming the file.
std::vector<Photograph> read_photographs(Run& run);

/// What the options say.
PhotographTextureOptions asked_photograph_options(const OptionValues& options);

}  // namespace mq::app

#pragma once
/// Photographs with their cameras: which, and how a texture is made of them.

#include <string>
#include <vector>

#include "mq/io/cameras.h"
#include "mq/model/photograph_texture.h"
#include "shell/run.h"

namespace mq::app {

/// Adds --cameras, --images and all that says what photographs show and which are chosen.
void add_photograph_options(OptionTable& table);

struct GivenPhotographs {
  std::vector<Photograph> photographs;
  struct LeftOut {
    std::string picture, why;
  };
  std::vector<LeftOut> left_out;  ///< where that was asked

  std::size_t count() const { return photographs.size() + left_out.size(); }
};

/// Those that --cameras names, each once; warns of what is left out. Refuses pictures that are not there, cannot be read,
/// or do not fit their cameras, before any work, all of them at once, unless they are to be skipped. Throws `InvalidInput`
/// or `IoError` naming the files.
GivenPhotographs read_photographs(Run& run);

/// What the options say.
PhotographTextureOptions asked_photograph_options(const OptionValues& options);

}  // namespace mq::app

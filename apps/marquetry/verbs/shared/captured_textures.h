#pragma once
/// export X.evolving --from SEQUENCE: what was captured, as textures of an evolving mesh's atlas,
/// or where it has none as colours at its vertices.

#include <filesystem>
#include <string>
#include <vector>

#include "mq/io/evolving_file.h"
#include "mq/model/film_video.h"
#include "shell/run.h"
#include "shell/verb.h"

namespace mq::app {

/// Options of other names than the library's fields have (see `Verb`).
OptionFields captured_fields();

/// Adds --from and what is of it: --texture, --size, --samples, --stitch, --images, --steady.
void add_captured_texture_options(OptionTable& table);

/// The files that frames with these numbers make. Throws `InvalidInput` where --output cannot hold
/// what is captured: without an atlas only models do.
std::vector<std::filesystem::path> captured_paths(const OptionValues& options,
                                                  const EvolvingReader& reader,
                                                  const std::vector<int>& numbers);

/// Says that the captured frames with these numbers are read, and the material libraries and pictures that
/// they name: see `Run::will_read`. `outputs` are the files that will be written.
void will_read_captured(Run& run, const std::vector<int>& numbers,
                        const std::vector<std::filesystem::path>& outputs);

/// Writes what the captured frames that --from names show to `to`, at the rate of `how` where it has one, and a video
/// kept as that says: see `write_captured`. Adds
/// `textures` to the result: of each frame its number, texels of charts and those of them that
/// nothing was captured for, or vertices.
void write_captured_textures(Run& run, const EvolvingReader& reader, const std::vector<int>& frames,
                             const std::string& to, const VideoOptions& how);

/// The same as a texture video for a film, kept as `how` says.
FilmVideo captured_video(Run& run, const EvolvingReader& reader, const std::vector<int>& frames,
                         const VideoOptions& how);

}  // namespace mq::app

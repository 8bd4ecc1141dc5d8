#pragma once
/// Sessions of the viewer, as scripts in a folder of their own.

#include <string>
#include <vector>

#include "cli/models.h"
#include "cli/program.h"
#include "mq/io/model.h"

namespace mq::test {

inline const std::vector<std::string> small_window = {"--size", "900x460"};
inline constexpr int surface_width = 358, surface_height = 436;  ///< of its surface pane
inline constexpr int atlas_width = 240, atlas_height = 436;

/// Samples and files opened before lie in the folder, and not in a person's.
inline const RunOptions own_places = {.environment = {{"XDG_CACHE_HOME", "cache"}, {"XDG_STATE_HOME", "state"}}};

/// marquetry view WORDS... of this script, off the screen.
inline Result view(const Folder& folder, const std::string& script, std::vector<std::string> words,
                   const RunOptions& options = {}) {
  write_bytes(folder / "session.txt", script);
  words.insert(words.begin(), "view");
  words.insert(words.end(), small_window.begin(), small_window.end());
  words.insert(words.end(), {"--script", "session.txt", "--json"});
  return marquetry(folder, words, options);
}

/// sphere.obj and sphere.png: six charts, so many texels a side.
inline void write_sphere(const Folder& folder, const std::string& size = "256") {
  marquetry(folder, {"sample", "sphere", "-o", "sphere.obj", "--size", size});
}

inline Image<float> picture(const Folder& folder, const std::string& name) {
  return read_texture(folder / name).pixels;
}

}  // namespace mq::test

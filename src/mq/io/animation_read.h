#pragma once
/// Files that move, of `write_animation` and of other programs, as an evolving mesh.
///
///     const OpenAnimation walk = open_animation("walk.usdz");
///     const Film film = make_film(walk.reader, frames, lifespan_colour);
///
/// USD as text (`.usda`, `.usdz`): a mesh whose points have time samples; of several one is visible at a time.
/// Polygons are cut into triangles, holes left out, transforms that stay are applied, Z is turned up to Y; of what is
/// subdivided the cage is taken, and lengths stay in the file's unit, which the reader knows. glTF (`.glb`, `.gltf`,
/// also compressed by meshopt or Draco): a mesh whose morph targets an animation shows; of several one at a time, by
/// scales that step between 0 and 1. A frame is a time sample, or a key. What else moves (bones, nodes,
/// connectivity that changes) is refused.

#include <filesystem>
#include <string>
#include <vector>

#include "mq/base/progress.h"
#include "mq/image/image.h"
#include "mq/io/evolving_file.h"

namespace mq {

struct OpenAnimation {
  /// Positions are read from the file when they are asked for. Triangles of two segments are the same where their
  /// texture coordinates are (`match_ids`); vertices that are in one place in all frames are one in glTF. Frames have
  /// the numbers that they were written with, time codes of USD, or where these are not whole or below 0 others,
  /// which a remark says.
  EvolvingReader reader;
  double frames_per_second = 0;   ///< their mean
  double numbers_per_second = 0;  ///< frame n is seen (n − n_first) / this seconds after the first

  /// Of each segment the picture of its base colour; without pixels: none.
  std::vector<Image<float>> pictures;
  std::vector<std::filesystem::path> files = {};  ///< that were read beside it: pictures, buffers
  std::vector<std::string> notes;    ///< what was left out, or may not be as it was meant
  std::vector<std::string> remarks;  ///< what a user may want to know
};

/// Whether a name ends like a file that `open_animation` reads.
bool names_moving_file(const std::filesystem::path& path);

/// Reads all frames once, so that later nothing is refused. Throws `IoError` with the line, or the place in the JSON,
/// where the file is damaged or cut short, or cannot be read, and `Unsupported`, saying what was found and what is
/// wanted, for what is none of the above: binary USD among others.
OpenAnimation open_animation(const std::filesystem::path& path, const Progress& progress = {});

}  // namespace mq

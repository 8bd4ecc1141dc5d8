#pragma once
/// An evolving mesh as a page in a browser plays it (apps/player): a description in JSON, and a store of its frames
/// (docs/evolving_format.md), a block of bytes per group of frames.
///
/// `lives` says which colour each triangle has, by how long its texture coordinates stay; whole numbers of seven bits a
/// byte, the lowest first, of which the highest bit says that another follows:
///
///   K, 3K numbers   red, green, blue of each colour, from 0 to 255
///   for each segment, until all of its triangles are told: how many triangles in a row have a colour, and which.

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "mq/base/progress.h"
#include "mq/io/evolving_file.h"

namespace mq {

struct Film {
  std::string description = {};    ///< JSON: frames, box (low, high), and of each segment its first frame and counts
  std::string manifest = {};       ///< of the store
  std::vector<Bytes> blocks = {};  ///< of the store, one after the other: those of each group of frames
  Bytes lives = {};
};

/// The colour of what lives from frame `first` to `last` of `count`.
using LifeColour = std::function<std::array<float, 3>(int first, int last, int count)>;

struct FilmOptions {
  std::string blocks_name = "film.blocks";  ///< as the manifest has it
  /// How far positions may be off, as a share of the diagonal of all frames. Without it 1/65536 of their largest extent,
  /// which is less than a pixel of any screen. Those of the reader are not rounded to less than its step, nor to less
  /// than floats have, which graphics cards compute in.
  std::optional<double> error = {};
};

/// Frames of the store (indices, increasing). Lives are counted in all its frames, whichever are
/// asked for. Throws `InvalidInput` where none is, `IoError` where the store is broken,
/// `Unsupported` where a vertex is too far away for a graphics card (1e18).
Film make_film(const EvolvingReader& reader, const std::vector<int>& frames, const LifeColour& colour,
               const FilmOptions& options = {}, const Progress& progress = {});

}  // namespace mq

#pragma once
/// An evolving mesh as a page in a browser plays it (apps/player/player.js): a description in JSON,
/// and a block of bytes per segment.
///
/// A segment's block is compressed (zlib's format, RFC 1950) and holds, numbers with their lowest
/// byte first, for V vertices, P points, T triangles, B edges of charts and F frames:
///
///   points     P × 32 bits   the vertex of each; a vertex is one point in each chart it belongs to
///   uvs        2P × floats   u, v; nothing where the segment has no texture coordinates
///   colours    3P × 8 bits   red, green, blue, by how long texture coordinates stay
///   triangles  3T × 32 bits  points
///   edges      2B × 32 bits  points
///   positions  F × 6V bytes  a frame: the low bytes of x of all vertices, then of y, of z, then
///   the
///                            high bytes likewise
///
/// A coordinate is a whole number from 0 to 65535 between the sides of the box that holds all
/// frames. It is kept as the difference to the frame before (modulo 65536; the first to 0), folded:
/// 0, −1, 1, −2, … are 0, 1, 2, 3, …

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "mq/base/progress.h"
#include "mq/io/evolving_file.h"

namespace mq {

struct Film {
  std::string description;    ///< JSON: frames, box, and of each segment the counts above
  std::vector<Bytes> blocks;  ///< one per segment that has any of the frames
};

/// The colour of what lives from frame `first` to `last` of `count`.
using LifeColour = std::function<std::array<float, 3>(int first, int last, int count)>;

/// Frames of the store (indices, increasing). Lives are counted in all its frames, whichever are
/// asked for. Throws `InvalidInput` where none is, `IoError` where the store is broken,
/// `Unsupported` where a vertex is too far away for a graphics card (1e18).
Film make_film(const EvolvingReader& reader, const std::vector<int>& frames,
               const LifeColour& colour, const Progress& progress = {});

}  // namespace mq

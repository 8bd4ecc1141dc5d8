#pragma once
/// An evolving mesh as an animated glTF file.

#include <filesystem>
#include <functional>

#include "mq/base/progress.h"
#include "mq/image/image.h"
#include "mq/io/evolving_file.h"

namespace mq {

/// Writes frames `first` to `last` (indices, inclusive) of a store as GLB. A segment is a mesh with
/// a morph target for each frame but its first; an animation mixes two neighbouring frames and
/// shows one segment at a time, by scaling the others to nothing. Positions are floats. Frame f of
/// number n is shown at (n − n_first) / frames_per_second seconds.
/// `pictures`, where it is given, is asked for the texture of every segment, by the index of the
/// first of its frames that is shown; it stays until the segment ends, as glTF moves no textures.
/// Throws `IoError` as reader and files do, `InvalidInput` on frames out of range and a rate that is
/// not positive, `Unsupported` beyond 4 GB.
void write_animation(const std::filesystem::path& path, const EvolvingReader& reader, int first,
                     int last, double frames_per_second,
                     const std::function<Image<float>(int frame)>& pictures = {},
                     const Progress& progress = {});

}  // namespace mq

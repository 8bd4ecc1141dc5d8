#pragma once
/// An evolving mesh as one file that moves: glTF or USD.

#include <filesystem>
#include <functional>
#include <vector>

#include "mq/base/progress.h"
#include "mq/image/image.h"
#include "mq/io/evolving_file.h"
#include "mq/io/model.h"

namespace mq {

/// Frames `first` to `last` of a store (indices, inclusive). Frame f of number n is shown at
/// (n − n_first) / frames_per_second seconds; in USD its time code is n.
struct AnimationPart {
  int first = 0, last = 0;
  double frames_per_second = 30;
  Compression compression = Compression::none;  ///< of a `.glb`: none or meshopt
};

/// The texture of a segment, asked for by the index of the first of its frames that is shown; without pixels: none.
using PictureOfFrame = std::function<Image<float>(int frame)>;

/// Writes a part of a store in the format of the extension.
///
/// `.glb`: a segment is a mesh with a morph target for each frame but its first; an animation mixes two
/// neighbouring frames and shows one segment at a time, by scaling the others to nothing.
///
/// `.usda`, USD as text, and `.usdz`, the same packed with its pictures: a segment is a mesh whose points
/// have a time sample for each frame, with face-varying texture coordinates, visible while it lasts. Y is up,
/// and its unit that of the reader; in glTF all is in metres.
///
/// Positions are floats. `pictures`, where they are given, stay until their segment ends; `.usda` has them
/// beside it. Throws `IoError` as reader and files do, `InvalidInput` on frames out of range, a rate that is
/// not positive, another extension, and a compression that it has not, `Unsupported` beyond 4 GB in one file,
/// but for `.usda`.
void write_animation(const std::filesystem::path& path, const EvolvingReader& reader, const AnimationPart& part,
                     const PictureOfFrame& pictures = {}, const Progress& progress = {});

/// The files that it makes: the animation, and the pictures beside it. Whether a segment has one is asked as its
/// picture is.
std::vector<std::filesystem::path> animation_files(const std::filesystem::path& path, const EvolvingReader& reader,
                                                   const AnimationPart& part,
                                                   const std::function<bool(int frame)>& has_picture);

/// Frames [begin, end) that are of one segment.
struct FrameRange {
  int begin = 0, end = 0;
};
std::vector<FrameRange> ranges_of_segments(const EvolvingReader& reader, const AnimationPart& part);

}  // namespace mq

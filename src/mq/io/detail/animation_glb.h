#pragma once
/// An evolving mesh as an animated glTF file.

#include <functional>

#include "mq/io/animation.h"

namespace mq {

/// The file that `write_animation` describes; the part was checked. Throws `IoError` as the reader does,
/// `Unsupported` beyond 4 GB.
Bytes animation_glb(const EvolvingReader& reader, const AnimationPart& part, const PictureOfFrame& pictures,
                    const Progress& progress);

}  // namespace mq

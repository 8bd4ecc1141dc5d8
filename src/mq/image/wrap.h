#pragma once

namespace mq {

/// What a texture lookup outside [0,1] finds.
enum class Wrap {
  unspecified,  ///< the file does not say
  clamp,        ///< the nearest border texel
  repeat        ///< the texture again
};

}  // namespace mq

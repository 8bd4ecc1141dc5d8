// No codec of pictures, for the fuzz targets that read none.

#include <cstdlib>

#include "mq/io/detail/picture_codec.h"

namespace mq {

const PictureCodec& picture_codec() { std::abort(); }

}  // namespace mq

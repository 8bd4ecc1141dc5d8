// The codec of pictures, linked with the fuzz targets in place of its module.

#include "mq/io/detail/picture_codec.h"

extern "C" const mq::PictureCodec* marquetry_picture_codec(const char* version);

namespace mq {

const PictureCodec& picture_codec() { return *marquetry_picture_codec(MARQUETRY_VERSION); }

}  // namespace mq

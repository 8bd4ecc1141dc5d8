#pragma once
/// The picture of a photograph as its camera means it.
///
/// Cameras and phones store pictures lying on their side with a tag (EXIF, TIFF) that says how to turn
/// them. Some programs find cameras of the pictures as they are stored (COLMAP), others of them turned.
/// Sizes tell which where the tag exchanges width and height: then the picture is taken as the camera's
/// size has it. A tag that does not (2, 3, 4), and one of a square picture, is not heeded, as COLMAP and
/// most others do not heed it.

#include "mq/io/cameras.h"
#include "mq/io/image_file.h"

namespace mq {

enum class PictureTurn { as_stored, upright };

/// A camera for its picture as it is, which may have been made smaller or larger as a whole since the
/// camera was found.
struct FittedCamera {
  PinholeCamera camera;  ///< of the picture's size, turned where `turn` says so
  PictureTurn turn = PictureTurn::as_stored;
};

/// Of a picture whose head says this (`picture_info`). Throws `InvalidInput` naming the picture, its size
/// and the camera's where their proportions differ by more than a pixel.
FittedCamera fitted_camera(const Photograph& photograph, const PictureInfo& picture);

/// The picture, turned so. Throws what `read_texture` throws.
Texture read_photograph(const Photograph& photograph, PictureTurn turn, const Progress& progress = {});

}  // namespace mq

#pragma once
/// Of pictures whose sizes a file of cameras does not say, those that its cameras may not have been found for.

#include <span>
#include <vector>

namespace mq {

/// A picture as its head and its camera say.
struct UnsizedPicture {
  int width, height;
  bool lies = false;  ///< its tag says that width and height are to be exchanged
  double focal = 0;   ///< pixels
};

enum class SizeVerdict {
  as_stored,    ///< nothing speaks against it
  upright,      ///< turned by its tag it has the size of the others
  scaled,       ///< its camera is of a picture as large as the others
  on_its_side,  ///< it alone lies where the others stand, or the other way round; it may have been taken so
  unlike,       ///< it alone has other proportions, and another focal length too: perhaps of another camera
  cropped,      ///< it alone has other proportions, and the focal length of the others
};

/// The size that more than half of the pictures have, which the others are held against.
struct UsualSize {
  int width = 0, height = 0;  ///< 0: there is none
  double focal = 0;           ///< the median of theirs

  explicit UsualSize(std::span<const UnsizedPicture> pictures);
};

/// Of each picture; `as_stored` of all where none is usual. Focal lengths are alike within 5 %.
std::vector<SizeVerdict> judged_sizes(std::span<const UnsizedPicture> pictures, const UsualSize& usual);

}  // namespace mq

#pragma once
/// Vector fields on an image in the colours of the optical flow benchmarks [baker2011database]: the
/// hue says where to, the saturation how far.

#include <string>

#include "mq/image/colour.h"
#include "mq/image/image.h"

namespace mq {

/// The colour of a vector (right, down) whose length is given relative to the longest shown: white
/// at 0, the full hue at 1, darker beyond. Right is red, down yellow-green, left cyan-blue, up
/// violet: once around through red, yellow, green, cyan, blue, magenta, with more room where eyes
/// tell more hues apart (15 : 6 : 4 : 11 : 13 : 6).
Colour flow_colour(double right, double down);

/// The longest of the vectors of a field (two channels) that are finite; 0 where there is none.
double longest(const Image<float>& field);

/// The field in these colours, lengths relative to `longest`; black where it is not finite. All
/// white where `longest` is 0.
Image<float> flow_picture(const Image<float>& field, double longest);

/// The disc of all directions and lengths, with what its rim stands for: "12.5 px".
Image<float> flow_wheel(double longest, const std::string& unit = "px", int side = 160);

/// The picture of a field with the wheel to its right.
Image<float> flow_picture_with_wheel(const Image<float>& field, double longest);

}  // namespace mq

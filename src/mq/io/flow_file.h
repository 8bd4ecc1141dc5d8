#pragma once
/// Files of optical flow in the field's formats.

#include <filesystem>
#include <string>
#include <vector>

#include "mq/image/image.h"

namespace mq {

/// Reads by extension a field of two channels: right and down, pixels, of the pixels of the first
/// image. Where a file says that the flow is not known both are NaN.
///
/// - .flo: Baker et al. (A database and evaluation methodology for optical flow, 2011): the float
///   202021.25, width and height (32-bit integers), pairs of floats row by row, little-endian;
///   10⁹ and beyond, or not a number, is unknown;
/// - .png: KITTI (Menze and Geiger, Object scene flow for autonomous vehicles, 2015): 16 bits, red
///   and green (value − 2¹⁵)/64, blue 0 where unknown;
/// - .exr: two or three channels, of which the first two count (U and V, or R and G); unknown is
///   10⁹ and beyond; as in all pictures what is not finite is refused.
///
/// Throws `IoError` naming the file, what was found and what was wanted.
Image<float> read_flow(const std::filesystem::path& path);

/// Writes such a field by extension; what is not finite is unknown. A .png holds ±511 pixels in
/// steps of 1/64. Returns what is worth telling. Throws `InvalidInput` where the field has other
/// than two channels, the extension is none of these or a vector is too long for .png; `IoError`.
std::vector<std::string> write_flow(const std::filesystem::path& path, const Image<float>& field);

}  // namespace mq

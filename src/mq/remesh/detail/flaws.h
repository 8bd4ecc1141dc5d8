#pragma once
/// What makes a triangle too bad to keep.

namespace mq {

inline constexpr double thinnest = 1e-3;      ///< height over longest edge, below which it lies in no plane
inline constexpr double least_cosine = 0.17;  ///< between its normal and the surface's: 80 degrees

}  // namespace mq

#pragma once
/// Texture coordinates of a segment, those that are new since the segment before (docs/evolving_format.md).

#include <vector>

#include "mq/evolving/evolving_mesh.h"
#include "mq/io/detail/symbol_streams.h"

namespace mq {

inline constexpr int new_place = -1;  ///< of what was not there before
inline constexpr int uv_streams = 16;

/// Texture coordinates as multiples of a step; as they are where one has more than 2⁵⁰ of them.
std::vector<Vector2> rounded_uvs(std::vector<Vector2> uvs, double step);

/// Of each texture coordinate, where `before` has one of the same bits.
std::vector<int> uvs_before(const std::vector<Vector2>& uvs, const std::vector<Vector2>& before);

/// How they are stored goes to one stream, their values to `uv_streams` from another one on. They are multiples of the
/// step, or are stored to the bit.
void put_uvs(SymbolWriter& to, int head_stream, int first_stream, const EvolvingSegment& segment,
             const std::vector<int>& places, double step);

/// Those that are new; the others, and what corners have, are there already.
void get_uvs(SymbolReader& from, int head_stream, int first_stream, EvolvingSegment& segment,
             const std::vector<int>& places);

}  // namespace mq

#include "mq/atlas/footprint.h"

#include <algorithm>

#include "mq/atlas/clip.h"
#include "mq/base/parallel.h"

namespace mq {
namespace {

void widen(TexelSpan& span, int first, int end) {
  if (span.first == span.end)
    span.first = first, span.end = end;
  else
    span.first = std::min(span.first, first), span.end = std::max(span.end, end);
}

}  // namespace

Footprints::Footprints(const Atlas& atlas, const Progress& progress) {
  const std::size_t triangles = atlas.chart.size();
  offsets_.assign(triangles + 1, 0);
  for (std::size_t t = 0; t < triangles; ++t) {
    offsets_[t + 1] = offsets_[t];
    if (atlas.chart[t] < 0) continue;
    const auto [first, end] = rows_of(atlas.corners[t]);
    offsets_[t + 1] += std::size_t(end - first + 1);
  }
  spans_.resize(offsets_.back());
  parallel_for(
      std::int64_t(triangles),
      [&](std::int64_t t) {
        if (atlas.chart[std::size_t(t)] < 0) return;
        if (t % 64 == 0) progress.check();
        const auto& corners = atlas.corners[std::size_t(t)];
        const auto [first, end] = rows_of(corners);
        TexelSpan* const spans = spans_.data() + offsets_[std::size_t(t)];
        for (int row = first; row <= end; ++row) spans[row - first].row = row;
        for (int row = first; row < end; ++row) {
          // A row of cells has texels at its upper and at its lower line.
          const auto add = [&](int from, int to) {
            widen(spans[row - first], from, to + 2);
            widen(spans[row + 1 - first], from, to + 2);
          };
          clip_row(
              corners, row,
              [&](const Piece& piece) {
                if (piece.area() >= smallest_piece) add(piece.column, piece.column);
              },
              [&](int, int from, int to) { add(from, to); });
        }
      },
      64);
  progress.at(1);
}

}  // namespace mq

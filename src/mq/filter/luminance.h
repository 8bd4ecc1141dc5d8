#pragma once
/// What is bright and what is dark in colours, filtered without their hues.
///
/// A filter that works on red, green and blue by themselves overshoots in each of them by another
/// amount where they differ, which shows as coloured fringes beside edges. Filtered by its luminance
/// Y alone, c' = c + (Y' − Y)·(1, 1, 1), a colour keeps its differences of channels.

#include "mq/linear/matrix.h"

namespace mq {

/// Y = 0.2126 R + 0.7152 G + 0.0722 B of each row (Rec. 709), in the values as they are given: of
/// display values it is luma. Of one or two channels (grey, grey and alpha) it is the first. A signal
/// of one channel. Throws `InvalidInput` for a signal without channels.
Signal luminance(const Signal& colours);

/// The colours with the luminance `after` instead of `before`, as much added to each of their
/// colour channels; an alpha (the last of two or four) is kept. Rows where both are equal are bit for
/// bit those of `colours`.
Signal with_luminance(const Signal& colours, const Signal& before, const Signal& after);

}  // namespace mq

#pragma once
/// Work that cannot be interrupted, on a thread of its own, so that whoever waits for it need not.

#include <functional>

#include "mq/base/progress.h"

namespace mq {

/// Runs `work` on another thread and returns when it is done, with its exception where it throws.
/// Meanwhile `progress` comes as far as the clock says of `expected_seconds`: nine tenths of the
/// way at an even pace, then ever slower. When it is asked to stop, this throws `Cancelled` within
/// a tenth of a second, and `work` goes on with nobody waiting: all it touches must be its own
/// (held by shared pointers). A process that ends by returning from `main` waits for what was left
/// so; one that ends by `_exit` does not.
void run_apart(std::function<void()> work, const Progress& progress, double expected_seconds);

}  // namespace mq

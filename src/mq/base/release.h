#pragma once
/// Memory that is given back before its owner ends.

namespace mq {

/// Lets go of what a vector or matrix holds. (`= {}` makes it empty and keeps its memory, of sparse matrices too.)
template <class Holder>
void release(Holder& held) {
  Holder empty;
  held.swap(empty);
}

}  // namespace mq

#pragma once
/// Room for values that are all about to be written.

#include <memory>
#include <utility>
#include <vector>

namespace mq {

/// Leaves numbers that are not given a value as memory holds them, so that `resize` does not touch it: each page
/// is touched first by the thread that fills it, where one thread would else fill all with zeros before.
template <class T>
struct ForOverwriting : std::allocator<T> {
  template <class U>
  struct rebind {
    using other = ForOverwriting<U>;
  };
  ForOverwriting() = default;
  template <class U>
  ForOverwriting(const ForOverwriting<U>&) {}

  template <class U>
  void construct(U* at) {
    ::new (static_cast<void*>(at)) U;
  }
  template <class U, class... Arguments>
  void construct(U* at, Arguments&&... arguments) {
    ::new (static_cast<void*>(at)) U(std::forward<Arguments>(arguments)...);
  }
};

/// A vector of numbers whose `resize` leaves new ones to be written.
template <class T>
using OverwrittenVector = std::vector<T, ForOverwriting<T>>;

}  // namespace mq

#pragma once
/// The processes that share the work on a model.

#include <mpi.h>

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace mq::shared {

class Processes {
 public:
  Processes();

  int rank() const { return rank_; }
  int count() const { return count_; }
  bool is_first() const { return rank_ == 0; }

  /// Work that every process does by itself, without talking to others. Where it throws in any process, it throws in
  /// all: `InvalidInput` (or `Cancelled`) with the message of the first of them. Every process must call it.
  void together(const std::function<void()>& work) const;

  /// Work in which processes talk to each other. Where it throws in one, the others may wait for it for ever: the
  /// message is said and all are ended, with the exit status of an error.
  void talking(const std::function<void()>& work) const;

  /// Work that one process after another does.
  void in_turns(const std::function<void()>& work) const;

  /// The sums over all processes, and the largest, in place, the same bits everywhere.
  void sum(std::span<double> values) const;
  void largest(std::span<double> values) const;
  double largest(double value) const;

  /// to[p] goes to process p; what process p sent comes back as [p].
  template <class T>
  std::vector<std::vector<T>> exchange(const std::vector<std::vector<T>>& to) const {
    static_assert(std::is_trivially_copyable_v<T>);
    std::vector<std::span<const std::byte>> parts;
    for (const std::vector<T>& part : to) parts.push_back(std::as_bytes(std::span(part)));
    const std::vector<int> counts = exchange_counts(parts, sizeof(T));
    std::vector<std::vector<T>> from(to.size());
    std::vector<std::span<std::byte>> places;
    for (std::size_t p = 0; p < from.size(); ++p) {
      from[p].resize(std::size_t(counts[p]));
      places.push_back(std::as_writable_bytes(std::span(from[p])));
    }
    exchange_bytes(parts, places);
    return from;
  }

  /// What every process has, in the order of processes.
  std::vector<std::string> gather(const std::string& text) const;
  /// The lines of all of them, one after another.
  std::vector<std::string> gather_lines(const std::vector<std::string>& lines) const;

 private:
  std::vector<int> exchange_counts(const std::vector<std::span<const std::byte>>& parts, std::size_t size) const;
  void exchange_bytes(const std::vector<std::span<const std::byte>>& to,
                      const std::vector<std::span<std::byte>>& from) const;

  int rank_ = 0, count_ = 1;
};

/// Standard output and error of all but the first process lead nowhere, so that everything is said once; what ends all
/// processes is still said by `Processes::talking`.
void silence_others(const Processes& processes);

}  // namespace mq::shared

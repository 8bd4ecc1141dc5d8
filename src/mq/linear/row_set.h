#pragma once
/// Rows of a matrix, some of many, in increasing order.

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

namespace mq {

/// A set of rows 0 … size − 1. To ask for a row or to add one costs a few instructions, to walk through
/// them no more than their number and 1/64 of the rows between the first and the last.
class RowSet {
 public:
  /// Consecutive rows.
  struct Segment {
    int first = 0;
    int count = 0;
  };

  explicit RowSet(std::int64_t size = 0) : words_(std::size_t(size + 63) / 64, 0) {}

  bool has(int row) const { return words_[std::size_t(row) / 64] >> (row % 64) & 1; }

  /// Returns whether the row is a new one.
  bool add(int row) {
    std::uint64_t& word = words_[std::size_t(row) / 64];
    const std::uint64_t bit = std::uint64_t(1) << (row % 64);
    if (word & bit) return false;
    word |= bit;
    begin_ = std::min(begin_, std::int64_t(row / 64));
    end_ = std::max(end_, std::int64_t(row / 64) + 1);
    ++count_;
    return true;
  }

  /// Consecutive rows, of which some may be in it.
  void add(const Segment& rows) {
    if (rows.count <= 0) return;
    const std::int64_t first = rows.first, last = first + rows.count - 1;
    begin_ = std::min(begin_, first / 64);
    end_ = std::max(end_, last / 64 + 1);
    for (std::int64_t w = first / 64; w <= last / 64; ++w) {
      std::uint64_t bits = ~std::uint64_t(0);
      if (w == first / 64) bits &= ~std::uint64_t(0) << (first % 64);
      if (w == last / 64) bits &= ~std::uint64_t(0) >> (63 - last % 64);
      count_ += std::popcount(bits & ~words_[std::size_t(w)]);
      words_[std::size_t(w)] |= bits;
    }
  }

  void clear() {
    if (begin_ < end_) std::fill(words_.begin() + begin_, words_.begin() + end_, 0);
    begin_ = none, end_ = 0, count_ = 0;
  }

  std::int64_t count() const { return count_; }

  std::vector<int> rows() const {
    std::vector<int> result;
    result.reserve(std::size_t(count_));
    for (std::int64_t w = begin_; w < end_; ++w)
      for (std::uint64_t word = words_[w]; word != 0; word &= word - 1)
        result.push_back(int(64 * w) + std::countr_zero(word));
    return result;
  }

 private:
  static constexpr std::int64_t none = INT64_MAX;

  std::vector<std::uint64_t> words_;
  std::int64_t begin_ = none, end_ = 0;  ///< words outside are 0
  std::int64_t count_ = 0;
};

/// Rows in increasing order, cut into pieces of consecutive ones.
inline std::vector<RowSet::Segment> segments_of(const std::vector<int>& rows) {
  std::vector<RowSet::Segment> segments;
  for (const int row : rows) {
    if (segments.empty() || segments.back().first + segments.back().count != row)
      segments.push_back({row, 0});
    ++segments.back().count;
  }
  return segments;
}

}  // namespace mq

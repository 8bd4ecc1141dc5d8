#pragma once
/// The unknowns that one of several processes has, and how it hears of the others'.

#include <functional>
#include <span>
#include <vector>

#include "mq/linear/matrix.h"

namespace mq {

/// A process has complete rows of its own unknowns, and around these a halo of others', whose rows are not complete.
/// What an algorithm needs of the rest it gets here; every process must ask as often as the others do. By default
/// all unknowns are one's own, and there is nobody to ask.
class SharedUnknowns {
 public:
  using Reduce = std::function<void(std::span<double>)>;

  SharedUnknowns() = default;

  /// `own` holds 1 or 0 per unknown. `fill_halo` gives the others the values that their owners have, and those that
  /// no own row couples to NaN; `sum` and `largest` are over all processes, in place, the same bits everywhere.
  SharedUnknowns(std::vector<char> own, Reduce fill_halo, Reduce sum, Reduce largest)
      : own_(std::move(own)), fill_(std::move(fill_halo)), sum_(std::move(sum)), largest_(std::move(largest)) {}

  /// All of them are one's own.
  static const SharedUnknowns& alone() {
    static const SharedUnknowns all;
    return all;
  }

  bool is_alone() const { return own_.empty() && !fill_; }
  bool is_own(std::int64_t i) const { return own_.empty() || own_[std::size_t(i)] != 0; }

  void fill_halo(Vector& values) const {
    if (fill_) fill_({values.data(), std::size_t(values.size())});
  }
  void fill_halo(std::vector<char>& marks) const {
    if (!fill_) return;
    Vector values(std::ssize(marks));
    for (std::size_t i = 0; i < marks.size(); ++i) values[Eigen::Index(i)] = marks[i];
    fill_halo(values);
    for (std::size_t i = 0; i < marks.size(); ++i) marks[i] = values[Eigen::Index(i)] > 0;
  }
  void sum(std::span<double> values) const {
    if (sum_) sum_(values);
  }
  void largest(std::span<double> values) const {
    if (largest_) largest_(values);
  }
  double largest(double value) const {
    largest(std::span(&value, 1));
    return value;
  }

  /// The unknowns that are not one's own.
  std::vector<int> halo() const {
    std::vector<int> others;
    for (std::size_t i = 0; i < own_.size(); ++i)
      if (own_[i] == 0) others.push_back(int(i));
    return others;
  }

 private:
  std::vector<char> own_;
  Reduce fill_, sum_, largest_;
};

}  // namespace mq

#include "mq/video/detail/change_leaders.h"

#include <algorithm>

namespace mq {

std::vector<int> change_leaders(const SparseMatrix& coupled, const Vector& mass) {
  std::vector<int> leaders(std::size_t(mass.size()), -1);
  for (int i = 0; i < coupled.rows(); ++i) {
    int most = i;
    for (SparseMatrix::InnerIterator entry(coupled, i); entry; ++entry)
      if (mass[entry.col()] > mass[most]) most = int(entry.col());
    if (mass[i] < 0.5 * mass[most]) leaders[std::size_t(i)] = most;
  }
  for (int& leader : leaders)  // each has more mass than the one that it leads
    while (leader >= 0 && leaders[std::size_t(leader)] >= 0) leader = leaders[std::size_t(leader)];
  return leaders;
}

TimeLinks led_links(const TimeLinks& links, const std::vector<int>& leaders,
                    const std::vector<int>& leaders_before) {
  TimeLinks led;
  for (int t = 0; t < links.rows(); ++t) {
    const bool same = links.same(t) >= 0;
    if (same || leaders[std::size_t(t)] < 0)
      for (int e = links.starts[t]; e < links.starts[t + 1]; ++e) {
        TimeLinks::Entry entry = links.entries[e];
        if (const int leader = leaders_before[std::size_t(entry.column)]; !same && leader >= 0)
          entry.column = leader;
        led.entries.push_back(entry);
      }
    led.starts.push_back(int(led.entries.size()));
  }
  return led;
}

void add_differences(const std::vector<char>& chosen, const Vector& mass, double strength, SparseMatrix& K) {
  for (int i = 0; i < K.rows(); ++i) {
    double sum = 0;
    for (SparseMatrix::InnerIterator entry(K, i); entry; ++entry) {
      const auto j = entry.col();
      if (j == i || !(chosen[std::size_t(i)] || chosen[std::size_t(j)])) continue;
      const double held = strength * std::min(mass[i], mass[j]);
      entry.valueRef() -= held;
      sum += held;
    }
    if (sum > 0) K.coeffRef(i, i) += sum;
  }
}

}  // namespace mq

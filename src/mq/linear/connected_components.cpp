#include "mq/linear/connected_components.h"

#include <algorithm>

namespace mq {

std::vector<int> connected_components(const SparseMatrix& A, Joining by) {
  std::vector<int> component(A.rows(), -1), stack;
  int count = 0;
  for (int seed = 0; seed < A.rows(); ++seed) {
    if (component[seed] >= 0) continue;
    component[seed] = count;
    stack.push_back(seed);
    while (!stack.empty()) {
      const int i = stack.back();
      stack.pop_back();
      for (SparseMatrix::InnerIterator entry(A, i); entry; ++entry)
        if ((entry.value() != 0 || by == Joining::pattern) && component[entry.col()] < 0) {
          component[entry.col()] = count;
          stack.push_back(int(entry.col()));
        }
    }
    ++count;
  }
  return component;
}

Signal component_sums(const std::vector<int>& component, const Signal& values) {
  const int count =
      component.empty() ? 0 : 1 + *std::max_element(component.begin(), component.end());
  Signal sum = Signal::Zero(count, values.cols());
  for (Eigen::Index i = 0; i < values.rows(); ++i) sum.row(component[i]) += values.row(i);
  return sum;
}

}  // namespace mq

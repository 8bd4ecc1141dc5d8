// A_FF δ = −A_F· ψ of the free texels of all processes (filter/seam_values.cpp): each has its own rows, and of what
// these couple to the values that others have.
#include "seam_texels.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "direct_system.h"
#include "mq/base/stopwatch.h"
#include "mq/linear/connected_components.h"

namespace mq::shared {
namespace {

class SeamTexels {
 public:
  SeamTexels(const Processes& processes, const TexelPart& part, const Numbering& numbering, const Signal& psi)
      : processes_(processes), part_(part), numbering_(numbering), psi_(psi) {
    processes_.together([&] {
      if (!part_.empty()) A_ = part_.space().regularised_system(0, 1);
    });
  }

  /// The same marks where others own texels.
  void fill(std::vector<char>& marks) const {
    Signal values(std::ssize(marks), 1);
    for (std::size_t i = 0; i < marks.size(); ++i) values(Eigen::Index(i), 0) = marks[i];
    processes_.talking([&] { numbering_.fill_halo(values); });
    for (std::size_t i = 0; i < marks.size(); ++i) marks[i] = values(Eigen::Index(i), 0) > 0;
  }

  std::vector<int> regularised_rows(const std::vector<char>& free) const;
  Signal imbalance(const std::vector<int>& rows, Smooth what) const;
  void solve(const Signal& right, const std::vector<int>& rows, Signal& phi, SolveReport& report) const;
  std::vector<int> bring_back(const std::vector<char>& counts, const std::vector<int>& rows, Signal& phi) const;

 private:
  Signal neighbour_ranges(const std::vector<char>& counts) const;

  const Processes& processes_;
  const TexelPart& part_;
  const Numbering& numbering_;
  const Signal& psi_;
  SparseMatrix A_;
};

/// The own free texels of components in which something is held, whichever process has that.
std::vector<int> SeamTexels::regularised_rows(const std::vector<char>& free) const {
  std::vector<int> component;
  processes_.together([&] {
    if (!part_.empty()) component = connected_components(A_);
  });
  std::vector<char> held;
  for (const char is_free : free) held.push_back(!is_free);
  for (double changes = 1; changes > 0;) {
    std::vector<char> holds(free.size(), 0), before = held;
    for (std::size_t i = 0; i < held.size(); ++i)
      if (held[i]) holds[std::size_t(component[i])] = 1;
    for (std::size_t i = 0; i < held.size(); ++i) held[i] = holds[std::size_t(component[i])];
    fill(held);
    changes = processes_.largest(before == held ? 0.0 : 1.0);
  }
  std::vector<int> rows;
  for (const int i : part_.own())
    if (free[std::size_t(i)] && held[std::size_t(i)]) rows.push_back(i);
  return rows;
}

Signal SeamTexels::imbalance(const std::vector<int>& rows, Smooth what) const {
  Signal right = Signal::Zero(psi_.rows(), psi_.cols());
  processes_.together([&] {
    if (!part_.empty()) right = seam_imbalance(part_.space(), A_, psi_, rows, what);
  });
  return right;
}

/// Solves for the rows, with what φ − ψ is at all others.
void SeamTexels::solve(const Signal& right, const std::vector<int>& rows, Signal& phi, SolveReport& report) const {
  Signal numbers = Signal::Constant(psi_.rows(), 1, -1);
  std::vector<double> counts(std::size_t(processes_.count()), 0);
  counts[std::size_t(processes_.rank())] = double(rows.size());
  processes_.sum(counts);
  double first = 0;
  for (int p = 0; p < processes_.rank(); ++p) first += counts[std::size_t(p)];
  for (std::size_t k = 0; k < rows.size(); ++k) numbers(rows[k], 0) = first + double(k);
  processes_.talking([&] {
    numbering_.fill_halo(numbers);
    numbering_.fill_halo(phi);
    Signal B(std::ssize(rows), psi_.cols());
    for (std::size_t k = 0; k < rows.size(); ++k) {
      B.row(Eigen::Index(k)) = right.row(rows[k]);
      for (SparseMatrix::InnerIterator it(A_, rows[k]); it; ++it)
        if (numbers(it.col(), 0) < 0) B.row(Eigen::Index(k)) -= it.value() * (phi.row(it.col()) - psi_.row(it.col()));
    }
    const Stopwatch preparing;
    const DirectSystem system(processes_, int(rows.size()), [&](int k) {
      std::vector<RowEntry> entries;
      for (SparseMatrix::InnerIterator it(A_, rows[std::size_t(k)]); it; ++it)
        if (const double number = numbers(it.col(), 0); number >= 0)
          entries.push_back({std::int64_t(number), it.value()});
      return entries;
    });
    report.setup_seconds += preparing.seconds();
    const Stopwatch solving;
    const Signal delta = system.solve(B);
    report.solve_seconds += solving.seconds();
    for (std::size_t k = 0; k < rows.size(); ++k) phi.row(rows[k]) = psi_.row(rows[k]) + delta.row(Eigen::Index(k));
  });
}

/// Per unknown the least and the greatest around it, NaN where nothing counts.
Signal SeamTexels::neighbour_ranges(const std::vector<char>& counts) const {
  const Eigen::Index channels = psi_.cols();
  Signal ranges = Signal::Constant(psi_.rows(), 2 * channels, std::numeric_limits<double>::quiet_NaN());
  for (const int i : part_.own()) {
    ValueRange range;
    range.extend(A_, psi_, counts, i);
    if (range.any()) ranges.row(i) << range.low, range.high;
  }
  processes_.talking([&] { numbering_.fill_halo(ranges); });
  return ranges;
}

/// See `smooth_at_seams`.
std::vector<int> SeamTexels::bring_back(const std::vector<char>& counts, const std::vector<int>& rows,
                                        Signal& phi) const {
  const ValueRange all = shared_range(processes_, part_, psi_, counts);
  const Signal ranges = neighbour_ranges(counts);
  const Eigen::Index channels = psi_.cols();
  const auto around = [&](int i) {
    ValueRange range;
    if (!std::isnan(ranges(i, 0))) range = {ranges.row(i).head(channels), ranges.row(i).tail(channels)};
    return range;
  };
  std::vector<int> brought;
  for (const int i : rows) {
    ValueRange range = around(i);
    if (!range.any())
      for (SparseMatrix::InnerIterator it(A_, i); it; ++it) range.extend(around(int(it.col())));
    if (!range.any()) range = all;
    if (range.bring_back(phi, i)) brought.push_back(i);
  }
  return brought;
}

}  // namespace

ValueRange shared_range(const Processes& processes, const TexelPart& part, const Signal& values,
                        const std::vector<char>& counts) {
  const auto channels = std::size_t(values.cols());
  std::vector<double> most(2 * channels, -std::numeric_limits<double>::infinity());
  for (const int i : part.own())
    for (std::size_t c = 0; counts[std::size_t(i)] && c < channels; ++c) {
      const double value = values(i, Eigen::Index(c));
      most[c] = std::max(most[c], -value);
      most[channels + c] = std::max(most[channels + c], value);
    }
  processes.largest(most);
  ValueRange range;
  if (std::isinf(most.front())) return range;
  range.low.resize(values.cols());
  range.high.resize(values.cols());
  for (std::size_t c = 0; c < channels; ++c) {
    range.low[Eigen::Index(c)] = -most[c];
    range.high[Eigen::Index(c)] = most[channels + c];
  }
  return range;
}

Filtered shared_smooth_at_seams(const Processes& processes, const TexelPart& part, const Numbering& numbering,
                                const Signal& psi, const std::vector<char>& free, Smooth what) {
  const SeamTexels texels(processes, part, numbering, psi);
  Filtered result{psi, nothing_to_solve()};
  std::vector<char> still_free = free;
  texels.fill(still_free);
  std::vector<char> counts(free.size(), 1);  // whose ψ means something
  if (what == Smooth::values)
    for (std::size_t i = 0; i < counts.size(); ++i) counts[i] = !still_free[i];
  std::vector<int> rows = texels.regularised_rows(still_free);
  if (processes.largest(double(rows.size())) == 0) return result;
  const Signal right = texels.imbalance(rows, what);
  result.report.method = "direct, by all processes (MUMPS)";
  texels.solve(right, rows, result.signal, result.report);
  const std::vector<int> held = texels.bring_back(counts, rows, result.signal);
  if (processes.largest(double(held.size())) == 0) return result;
  for (const int i : held) still_free[std::size_t(i)] = 0;
  texels.fill(still_free);
  rows = texels.regularised_rows(still_free);
  if (processes.largest(double(rows.size())) == 0) return result;
  texels.solve(right, rows, result.signal, result.report);
  texels.bring_back(counts, rows, result.signal);
  return result;
}

}  // namespace mq::shared

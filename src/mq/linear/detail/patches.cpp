#include "mq/linear/detail/patches.h"

#include <algorithm>
#include <utility>

#include "mq/base/parallel.h"
#include "mq/linear/kernels/patch_kernels.h"

namespace mq {

namespace {

constexpr int max_patch = PatchList::max_members;  // a row with more neighbours keeps the first of them
constexpr int max_cluster = PatchList::max_members;  // members of a patch of strong couplings
constexpr double strong = 0.25;    // of the largest coupling of a row
constexpr int patch_block = 32;    // patches handed to a thread at once
constexpr int single_block = 256;  // rows handed to a thread at once
constexpr double shift = 1e-6;     // of the diagonal, see the header
// A whole component in one row of a coarse level, which holds no more than this where finest rows
// hold 1: its constants are the null space or as good, and what to divide by would be rounding.
constexpr double null_below = 1e-7;

/// Per row its position among the listed ones, −1 for the others.
std::vector<int> positions_of(const StencilLayout& layout) {
  std::vector<int> position(layout.rows, -1);
  for (int p = 0; p < layout.listed_count(); ++p) position[layout.listed(p)] = p;
  return position;
}

/// Orders rows (positions) in each block so that consecutive ones do not couple where that can be
/// had: by greedy colours within the block. A processor then overlaps their updates.
void interleave(const SparseMatrix& A, const StencilLayout& layout,
                const std::vector<int>& position, std::vector<int>& members) {
  const int count = int(members.size());
  std::vector<int> colour(count, -1);
  parallel_blocks(count, single_block, [&](std::int64_t begin, std::int64_t end) {
    std::vector<char> taken;
    for (std::int64_t p = begin; p < end; ++p) {
      taken.assign(taken.size() + 1, 0);
      for (SparseMatrix::InnerIterator entry(A, layout.listed(int(p))); entry; ++entry) {
        const int q = position[entry.col()];
        if (q < begin || q >= p) continue;
        if (std::size_t(colour[q]) >= taken.size()) taken.resize(colour[q] + 1, 0);
        taken[colour[q]] = 1;
      }
      colour[p] = int(std::find(taken.begin(), taken.end(), 0) - taken.begin());
    }
    std::stable_sort(members.begin() + begin, members.begin() + end,
                     [&](int a, int b) { return colour[a] < colour[b]; });
  });
}

/// The listed row at position p and those to which strong couplings lead from it, the nearest ones
/// first.
std::vector<int> cluster_around(int p, const SparseMatrix& A, const StencilLayout& layout,
                                const std::vector<int>& position) {
  std::vector<int> members = {p};
  for (std::size_t i = 0; i < members.size() && members.size() < max_cluster; ++i) {
    const int k = layout.listed(members[i]);
    double largest = 0;
    for (SparseMatrix::InnerIterator entry(A, k); entry; ++entry)
      if (entry.col() != k) largest = std::max(largest, std::abs(entry.value()));
    for (SparseMatrix::InnerIterator entry(A, k); entry && members.size() < max_cluster; ++entry) {
      const int q = position[entry.col()];
      if (q >= 0 && std::abs(entry.value()) >= strong * largest &&
          std::find(members.begin(), members.end(), q) == members.end())
        members.push_back(q);
    }
  }
  return members;
}

}  // namespace

PatchSmoother::PatchSmoother(const SparseMatrix& A, const StencilLayout& layout, Kind kind)
    : kind_(kind) {
  const std::vector<int> position = positions_of(layout);
  if (kind == Kind::neighbours)
    cover_by_neighbours(A, layout, position);
  else
    for (int p = 0; p < int(layout.irregular.size()); ++p) add_patch({&p, 1});
  cover_by_clusters(A, layout, position);
  if (kind == Kind::single) interleave(A, layout, position, members_);
  std::vector<int> unknowns(members_.size());
  for (std::size_t i = 0; i < members_.size(); ++i) unknowns[i] = layout.listed(members_[i]);
  order_ = order_blocks(A, starts_, unknowns, kind == Kind::single ? single_block : patch_block);

  inverses_.assign(1, 0);
  if (kind == Kind::neighbours)
    for (std::size_t p = 0; p + 1 < starts_.size(); ++p) {
      const std::int64_t n = starts_[p + 1] - starts_[p];
      inverses_.push_back(inverses_.back() + n * n);
    }
}

void PatchSmoother::add_patch(std::span<const int> members) {
  members_.insert(members_.end(), members.begin(), members.end());
  starts_.push_back(int(members_.size()));
}

namespace {

/// Patches in an order in which consecutive ones share rows, so that they find them in the cache: each
/// beside one before it, the latest first. `first`, per position: the patch that begins there, or −1;
/// `around(patch, visit)` visits the positions around one.
template <class Around>
std::vector<int> along_seams(const std::vector<int>& first, int count, const Around& around) {
  std::vector<int> order, ahead;
  order.reserve(std::size_t(count));
  std::vector<char> taken(std::size_t(count), 0);
  for (int patch = 0; patch < count; ++patch) {
    ahead.push_back(patch);
    while (!ahead.empty()) {
      const int at = ahead.back();
      ahead.pop_back();
      if (std::exchange(taken[at], 1)) continue;
      order.push_back(at);
      around(at, [&](int position) {
        if (const int other = first[position]; other >= 0 && !taken[other]) ahead.push_back(other);
      });
    }
  }
  return order;
}

}  // namespace

/// The patches are chosen row by row of the picture, and then put into an order along seams.
void PatchSmoother::cover_by_neighbours(const SparseMatrix& A, const StencilLayout& layout,
                                        const std::vector<int>& position) {
  const int count = int(layout.irregular.size());
  std::vector<char> covered(layout.listed_count(), 0);
  std::vector<int> first(layout.listed_count(), -1), starts = {0}, members;
  for (int p = 0; p < count; ++p) {
    if (covered[p]) continue;
    const std::size_t begin = members.size();
    members.push_back(p);
    for (SparseMatrix::InnerIterator entry(A, layout.listed(p)); entry; ++entry) {
      const int q = position[entry.col()];
      if (q >= 0 && q != p && members.size() - begin < max_patch) members.push_back(q);
    }
    for (std::size_t i = begin; i < members.size(); ++i) covered[members[i]] = 1;
    first[p] = int(starts.size()) - 1;
    starts.push_back(int(members.size()));
  }
  const auto members_of = [&](int patch) {
    return std::span(members).subspan(std::size_t(starts[patch]),
                                      std::size_t(starts[patch + 1] - starts[patch]));
  };
  patch_of_.assign(layout.listed_count(), -1);
  for (const int patch :
       along_seams(first, int(starts.size()) - 1, [&](int at, const auto& visit) {
         for (const int member : members_of(at))
           for (SparseMatrix::InnerIterator entry(A, layout.listed(member)); entry; ++entry)
             if (const int q = position[entry.col()]; q >= 0) visit(q);
       })) {
    patch_of_[members_of(patch).front()] = this->count();
    add_patch(members_of(patch));
  }
  // Clusters begin where none of these patches reaches.
  for (int p = count; p < layout.listed_count(); ++p)
    if (covered[p]) patch_of_[p] = -2;
}

void PatchSmoother::cover_by_clusters(const SparseMatrix& A, const StencilLayout& layout,
                                      const std::vector<int>& position) {
  const int first = int(layout.irregular.size());
  std::vector<char> covered(layout.listed_count(), 0);
  if (!patch_of_.empty())
    for (int p = first; p < layout.listed_count(); ++p) covered[p] = patch_of_[p] == -2;
  for (int p = first; p < layout.listed_count(); ++p) {
    if (covered[p]) continue;
    const std::vector<int> cluster = cluster_around(p, A, layout, position);
    for (std::size_t i = 0; i < (cluster.size() + 1) / 2; ++i) covered[cluster[i]] = 1;
    if (!patch_of_.empty()) patch_of_[p] = count();
    add_patch(cluster);
  }
}

void PatchSmoother::set_values(const SparseMatrix& A, const StencilLayout& layout,
                               const Scaling& scaling) {
  if (kind_ == Kind::single) {
    values_.resize(layout.listed_count());
    parallel_for(layout.listed_count(), [&](std::int64_t p) {
      const int k = layout.listed(int(p));
      const double diagonal = scaling(k, k) * A.coeff(k, k);
      const bool alone = A.outerIndexPtr()[k + 1] - A.outerIndexPtr()[k] == 1;
      values_[p] = diagonal > (alone ? null_below : 0.0) ? float(1 / diagonal) : 0;
    });
    return;
  }
  values_.resize(inverses_.back() + PatchList::margin);
  parallel_for(
      count(),
      [&](std::int64_t p) {
        const int begin = starts_[p], n = starts_[p + 1] - begin;
        const int stride = (n + PatchList::row_step - 1) / PatchList::row_step * PatchList::row_step;
        thread_local std::vector<std::pair<int, int>> places;  // unknowns of the patch, ascending, with their index in it
        thread_local std::vector<double> block;
        block.assign(std::size_t(n) * stride, 0);
        places.clear();
        for (int i = 0; i < n; ++i) places.emplace_back(layout.listed(members_[begin + i]), i);
        std::ranges::sort(places);
        for (const auto& [k, i] : places) {
          auto place = places.begin();
          for (int e = A.outerIndexPtr()[k]; e < A.outerIndexPtr()[k + 1]; ++e) {
            const int column = A.innerIndexPtr()[e];
            while (place != places.end() && place->first < column) ++place;
            if (place == places.end()) break;
            if (place->first == column) block[i * stride + place->second] = scaling(k, column) * A.valuePtr()[e];
          }
        }
        for (int i = 0; i < n; ++i) {
          double& diagonal = block[i * stride + i];
          diagonal = diagonal > 0 ? diagonal * (1 + shift) : 1;
        }
        patch_kernels().invert(block.data(), n, stride);
        float* const values = values_.data() + inverses_[p];
        for (int i = 0; i < n; ++i)  // symmetric to the last bit, as kernels rely on
          for (int j = 0; j <= i; ++j) values[i * n + j] = values[j * n + i] = float(block[i * stride + j]);
      },
      64);
}

PatchSmoother::Within PatchSmoother::within(const RowSet& rows, const std::vector<int>& positions,
                                            const StencilLayout& layout) const {
  std::vector<int> found;
  RowSet covered(layout.listed_count());
  const auto take = [&](int patch) {
    for (int i = starts_[patch]; i < starts_[patch + 1]; ++i)
      if (!rows.has(layout.listed(members_[i]))) return;
    found.push_back(patch);
    for (int i = starts_[patch]; i < starts_[patch + 1]; ++i) covered.add(members_[i]);
  };
  if (kind_ == Kind::single) {
    // Single rows are in the order of positions but for those of a block, which are mixed.
    int end = 0;
    for (const int p : positions) {
      if (p < end) continue;
      const int begin = p / single_block * single_block;
      end = std::min(begin + single_block, count());
      for (int patch = begin; patch < end; ++patch) take(patch);
    }
  } else {
    for (const int p : positions)
      if (patch_of_[p] >= 0) take(patch_of_[p]);
    std::ranges::sort(found);
  }
  Within result{order_.part(found), {}};
  for (const int p : positions)
    if (p < int(layout.irregular.size()) && !covered.has(p))
      result.alone.push_back(p);
  return result;
}

void PatchSmoother::relax(const BlockOrder& some, const StencilMatrix& A, int lanes, const float* b,
                          float* x, Order order) const {
  const auto relax =
      kind_ == Kind::single ? patch_kernels().relax_rows : patch_kernels().relax_patches;
  const ListedRows rows = A.listed_rows();
  const PatchList patches{starts_.data(), members_.data(), inverses_.data(), values_.data()};
  some.run(order, [&](int begin, int end) {
    const int* items = some.items.empty() ? nullptr : some.items.data();
    relax(lanes, rows, patches, {{items, begin, end}, order == Order::backward}, b, x);
  });
}

std::int64_t PatchSmoother::bytes() const {
  return std::int64_t(sizeof(int)) *
             std::int64_t(starts_.size() + members_.size() + patch_of_.size()) +
         std::int64_t(sizeof(std::int64_t)) * std::int64_t(inverses_.size()) +
         std::int64_t(sizeof(float)) * std::int64_t(values_.size());
}

}  // namespace mq

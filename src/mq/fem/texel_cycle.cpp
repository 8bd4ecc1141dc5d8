// The levels hold common·D·A·D (detail of `Hierarchy`): with Â⁻¹ ≈ Ĉ it is A⁻¹ ≈ common·D·Ĉ·D.

#include "mq/fem/texel_cycle.h"

#include <algorithm>
#include <array>
#include <vector>

#include "mq/base/parallel.h"
#include "mq/fem/texel_hierarchy.h"

namespace mq {

struct TexelCycle::Data {
  Hierarchy hierarchy;
  mutable std::unique_ptr<Multigrid::Workspace> workspace;  ///< of `lanes`, made when first wanted
  mutable LaneVector b, x;
  mutable int lanes = 0;
};

TexelCycle::TexelCycle(const SparseMatrix& A, const Texels& texels, const MultigridOptions& options,
                       const Progress& progress)
    : data_(std::make_unique<Data>(Data{texel_hierarchy(A, texels, options, progress), nullptr, {}, {}, 0})) {
  data_->hierarchy.keep_cycle_only();
}

TexelCycle::~TexelCycle() = default;
TexelCycle::TexelCycle(TexelCycle&&) noexcept = default;

namespace {

using Terms = std::vector<WeightedIndex>;

/// row += term's row of P, scaled by it.
void add_parents(const LevelTransfer& transfer, const WeightedIndex& term, Terms& row) {
  std::array<WeightedIndex, 4> parents;
  const int count = transfer.parents(term.index, parents);
  for (int k = 0; k < count; ++k) {
    const WeightedIndex& parent = parents[std::size_t(k)];
    const auto at = std::ranges::find(row, parent.index, &WeightedIndex::index);
    if (at == row.end())
      row.push_back({parent.index, term.weight * parent.weight});
    else
      at->weight += term.weight * parent.weight;
  }
}

/// Leaves out what is hardly there, so that the rest sums to 1, and sorts.
void keep_large(Terms& row) {
  constexpr float least = 0.01F;
  std::erase_if(row, [](const WeightedIndex& term) { return term.weight < least; });
  float sum = 0;
  for (const WeightedIndex& term : row) sum += term.weight;
  for (WeightedIndex& term : row) term.weight /= sum;
  std::ranges::sort(row, {}, &WeightedIndex::index);
}

}  // namespace

int TexelCycle::rows() const { return data_->hierarchy.rows(); }

void TexelCycle::apply(const Signal& R, Signal& Z) const {
  const Data& d = *data_;
  Z.resize(R.rows(), R.cols());
  if (R.rows() == 0) return;
  const Scaling& scaling = d.hierarchy.scaling();
  for (Eigen::Index first = 0; first < R.cols(); first += 4) {
    const Eigen::Index channels = std::min<Eigen::Index>(4, R.cols() - first);
    const int lanes = lanes_for(int(channels));
    if (d.lanes != lanes) {
      d.workspace = std::make_unique<Multigrid::Workspace>(d.hierarchy.multigrid(), lanes);
      d.b = LaneVector(R.rows(), lanes), d.x = LaneVector(R.rows(), lanes);
      d.lanes = lanes;
    }
    // Kept away from the ends of single precision, as residuals become small.
    const double largest = R.middleCols(first, channels).cwiseAbs().maxCoeff();
    const double unit = largest > 0 ? 1 / largest : 1;
    parallel_for(R.rows(), [&](std::int64_t i) {
      for (Eigen::Index c = 0; c < channels; ++c)
        d.b.data()[i * lanes + c] = float(unit * scaling.row(i) * R(i, first + c));
    });
    d.hierarchy.multigrid().cycle(d.b.data(), d.x.data(), *d.workspace);
    parallel_for(R.rows(), [&](std::int64_t i) {
      for (Eigen::Index c = 0; c < channels; ++c)
        Z(i, first + c) = scaling.common / unit * scaling.row(i) * double(d.x.data()[i * lanes + c]);
    });
  }
}

int TexelCycle::for_each_interpolated(
    double share, const std::function<void(int row, std::span<const WeightedIndex> terms)>& visit) const {
  std::vector<const LevelTransfer*> steps;
  for (const auto& level : data_->hierarchy.multigrid().levels) {
    if (!steps.empty() && steps.back()->coarse_rows() < share * rows()) break;
    steps.push_back(level->transfer.get());
  }
  Terms row, next;
  for (int i = 0; i < rows(); ++i) {
    row.assign(1, {i, 1.0F});
    for (const LevelTransfer* step : steps) {
      next.clear();
      for (const WeightedIndex& term : row) add_parents(*step, term, next);
      row.swap(next);
    }
    keep_large(row);
    visit(i, row);
  }
  return steps.empty() ? rows() : steps.back()->coarse_rows();
}

std::int64_t TexelCycle::bytes() const { return data_->hierarchy.bytes(); }

}  // namespace mq

#pragma once
/// From a level to the next coarser one and back.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "mq/linear/kernels/transfer_kernels.h"

namespace mq {

/// P, which makes functions of the fine level of coarse ones, and its transpose R = Pᵀ. The rows of
/// P sum to 1: constants stay constants.
class LevelTransfer {
 public:
  virtual ~LevelTransfer() = default;
  virtual int fine_rows() const = 0;
  virtual int coarse_rows() const = 0;

  /// Row `fine` of P: at most 4 entries into `out`; returns how many.
  virtual int parents(int fine, std::array<WeightedIndex, 4>& out) const = 0;

  /// Column `coarse` of P, appended to `out`.
  virtual void children(int coarse, std::vector<WeightedIndex>& out) const = 0;

  /// b = R·r.
  virtual void restrict_to(int lanes, const float* r, float* b) const = 0;

  /// The same in some coarse rows.
  virtual void restrict_to(std::span<const int> rows, int lanes, const float* r,
                           float* b) const = 0;

  /// x += P·y.
  virtual void prolongate_add(int lanes, const float* y, float* x) const = 0;

  /// The same in some fine rows.
  virtual void prolongate_add(std::span<const int> rows, int lanes, const float* y,
                              float* x) const = 0;

  /// Itself, if it is the interpolation on a grid, or if its rows are kept.
  virtual const class GridTransfer* grid() const { return nullptr; }
  virtual const class SparseTransfer* sparse() const { return nullptr; }

  virtual std::int64_t bytes() const = 0;
};

/// P of any shape with at most 4 entries per row.
class SparseTransfer final : public LevelTransfer {
 public:
  /// Row i of P has entries[starts[i]] … entries[starts[i + 1] − 1].
  SparseTransfer(std::vector<int> starts, std::vector<WeightedIndex> entries, int coarse_rows);

  int fine_rows() const override { return int(starts_.size()) - 1; }
  int coarse_rows() const override { return int(child_starts_.size()) - 1; }
  int parents(int fine, std::array<WeightedIndex, 4>& out) const override;
  void children(int coarse, std::vector<WeightedIndex>& out) const override;
  void restrict_to(int lanes, const float* r, float* b) const override;
  void restrict_to(std::span<const int> rows, int lanes, const float* r, float* b) const override;
  void prolongate_add(int lanes, const float* y, float* x) const override;
  void prolongate_add(std::span<const int> rows, int lanes, const float* y,
                      float* x) const override;
  const SparseTransfer* sparse() const override { return this; }
  /// Row `fine` and column `coarse` of P.
  std::span<const WeightedIndex> row(int fine) const { return between(starts_, entries_, fine); }
  std::span<const WeightedIndex> column(int coarse) const { return between(child_starts_, child_entries_, coarse); }
  std::int64_t bytes() const override;

 private:
  static std::span<const WeightedIndex> between(const std::vector<int>& starts,
                                                const std::vector<WeightedIndex>& entries, int i) {
    return {entries.data() + starts[i], std::size_t(starts[i + 1] - starts[i])};
  }

  std::vector<int> starts_, child_starts_;
  std::vector<WeightedIndex> entries_, child_entries_;
};

/// Bilinear interpolation between the nodes of a grid. A fine unknown lies on a coarse node,
/// halfway between two in its row or column, or amid four. A few may read other nodes in the place
/// of some.
class GridTransfer final : public LevelTransfer {
 public:
  using Parents = GridParents;
  using Children = GridChildren;

  /// A fine unknown that reads node `to` where its place in the grid says `from`.
  struct Move {
    int fine, from, to;
    float weight = 0;  ///< the transfer finds it
  };

  GridTransfer(std::vector<Parents> parents, std::vector<Children> children)
      : parents_(std::move(parents)), children_(std::move(children)) {}

  /// Adds `extra` coarse nodes after the others and moves unknowns to them; once.
  void move(std::vector<Move> moves, int extra);

  int fine_rows() const override { return int(parents_.size()); }
  int coarse_rows() const override { return int(children_.size()); }
  int parents(int fine, std::array<WeightedIndex, 4>& out) const override;
  void children(int coarse, std::vector<WeightedIndex>& out) const override;
  void restrict_to(int lanes, const float* r, float* b) const override;
  void restrict_to(std::span<const int> rows, int lanes, const float* r, float* b) const override;
  void prolongate_add(int lanes, const float* y, float* x) const override;
  void prolongate_add(std::span<const int> rows, int lanes, const float* y,
                      float* x) const override;
  const GridTransfer* grid() const override { return this; }
  const Parents& grid_parents(int fine) const { return parents_[fine]; }
  const Children& grid_children(int coarse) const { return children_[coarse]; }
  std::int64_t bytes() const override;

 private:
  std::vector<Parents> parents_;
  std::vector<Children> children_;
  std::vector<Move> by_fine_, by_from_, by_to_;  ///< the moves, sorted by each of these
};

}  // namespace mq

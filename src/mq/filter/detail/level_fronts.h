#pragma once
/// First distances on levels of a hierarchy, the coarsest first: fast enough for one frame. Used inside
/// this room.

#include <span>
#include <utility>
#include <vector>

#include "mq/linear/matrix.h"
#include "mq/linear/multigrid.h"
#include "mq/mesh/mesh.h"

namespace mq {

/// The fronts of `fast_marching_distances`, in single precision and on coarser levels. Each level takes its
/// nodes in the order of what the next coarser one found, so that one walk over them nearly does; what it
/// left too far is looked at again. The same bits for any number of threads.
class LevelFronts {
 public:
  /// An unknown and its distance.
  using Fixed = std::pair<int, double>;

  /// S couples the unknowns at `positions`, of which `multigrid` has the levels; it must outlive the object.
  /// Fronts run on the first level of at most `most_nodes` and on those below it.
  LevelFronts(const SparseMatrix& S, std::span<const Vector3> positions, const Multigrid& multigrid,
              int most_nodes, const Progress& progress);

  /// Mean distance of the nodes of the finest of these levels.
  double spacing() const { return levels_.front().spacing; }
  int nodes() const { return int(levels_.front().starts.size()) - 1; }

  /// Distances per unknown from groups of fixed ones, which have those given. Each group is a source: an
  /// unknown with the disc around it. Where no coupling leads they mean nothing.
  void run(std::span<const std::vector<Fixed>> groups, LaneVector& distance);

 private:
  struct Neighbour {
    int index;
    float length;
    std::array<float, 3> way;
  };
  struct Level {
    double spacing = 0;
    std::vector<int> starts;
    std::vector<Neighbour> neighbours;
    std::vector<int> order, places;
    std::vector<char> fixed, stale;
    LaneVector w;
  };

  void add_level(const SparseMatrix& S, std::span<const Vector3> positions);
  std::vector<std::vector<Fixed>> lifted(const std::vector<std::vector<Fixed>>& groups, std::size_t to) const;
  static float arrival(const Level& level, int i);
  static void sweep(Level& level);
  static void order_by_distance(Level& level);
  static void order_by_steps(Level& level);

  const Multigrid& multigrid_;
  std::size_t first_ = 0;                        ///< the level of the hierarchy where these begin
  std::vector<std::vector<Vector3>> positions_;  ///< of all levels of the hierarchy that are used
  std::vector<Level> levels_;                    ///< the finest first
  std::vector<LaneVector> between_;              ///< levels finer than `first_`, but for the unknowns
};

}  // namespace mq

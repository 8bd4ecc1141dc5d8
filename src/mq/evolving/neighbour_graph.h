#pragma once
/// Which triangles of an evolving mesh follow each other in time and meet in space (thesis 6.4.1).
///
/// Triangles come and go with segments only, so that time counts in periods: all frames of one
/// segment. A chain is a triangle over its life, t_s ↦ … ↦ t_e.

#include <cstdint>
#include <vector>

#include "mq/base/progress.h"
#include "mq/evolving/evolving_mesh.h"

namespace mq {

/// Consecutive frames of one connectivity.
struct Period {
  int segment = 0;
  int first = 0, last = 0;  ///< frames, counted from 0, both included
  int frame_count() const { return last - first + 1; }
};

/// The periods of an evolving mesh, in their order; segments without frames have none.
std::vector<Period> periods_of(const EvolvingMesh& evolving);

/// Areas are whole multiples of 2⁻⁴⁰ of the mean area of a frame, lengths of 2⁻⁴⁰ of its root, so
/// that sums of them do not depend on their order.
struct NeighbourGraph {
  struct Chain {
    int triangle = 0;                     ///< its id
    int first = 0;                        ///< period it begins in
    std::vector<std::int64_t> area;       ///< per period, summed over its frames
    std::vector<std::int64_t> perimeter;  ///< likewise
    int last() const { return first + int(area.size()) - 1; }
  };
  struct Contact {
    int one = 0, other = 0;            ///< chains, one < other
    int first = 0;                     ///< period
    std::vector<std::int64_t> length;  ///< of common edges, per period, summed over its frames;
                                       ///< more than 0 where there is one
  };
  std::vector<int> frame_counts;  ///< per period
  std::vector<Chain> chains;      ///< by increasing id
  std::vector<Contact> contacts;
  double radius = 0;  ///< of the circle around an equilateral triangle of the mean area, in roots
                      ///< of the mean area of a frame
};

/// The graph of an evolving mesh, the same for every unit of length. Triangles with two equal
/// vertices are left out. Throws `InvalidInput` where no frame has any area, and as
/// `triangle_lifespans`.
NeighbourGraph neighbour_graph(const EvolvingMesh& evolving, const Progress& progress = {});

}  // namespace mq

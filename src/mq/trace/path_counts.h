#pragma once
/// What many paths did, added up.

#include <cstdint>

namespace mq {

/// What paths did. All of it is a sum over paths, whatever the number of threads.
struct PathCounts {
  std::int64_t paths = 0;
  std::int64_t triangles = 0;  ///< crossed, from edge to edge or less
  std::int64_t edges = 0;      ///< slid along
  std::int64_t resting = 0;    ///< paths that came to rest before their time was over
  std::int64_t cut_short = 0;  ///< paths that were stopped, as they would go on for ever

  PathCounts operator+(const PathCounts& other) const {
    return {paths + other.paths, triangles + other.triangles, edges + other.edges,
            resting + other.resting, cut_short + other.cut_short};
  }
};

}  // namespace mq

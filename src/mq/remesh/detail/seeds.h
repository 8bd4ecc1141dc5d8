#pragma once
/// Where remeshing begins.

#include "mq/base/progress.h"
#include "mq/remesh/detail/score.h"
#include "mq/remesh/remesh.h"

namespace mq {

struct SeedScores {
  double tolerance = 0;  ///< the one used, model units
  Mismatch of_template, of_target;
  std::vector<char> distorted;  ///< per triangle of the template, or none at all
};

/// How badly vertices of either surface are shown by the other, as the options say.
SeedScores seed_scores(const SearchedSurface& of_template, const SearchedSurface& target,
                       const RemeshOptions& options, const Progress& progress = {});

}  // namespace mq

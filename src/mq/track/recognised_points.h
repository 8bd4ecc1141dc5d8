#pragma once
/// The extremities of a surface, such as hands, feet and a head, and which of another one's they are, by
/// lengths of paths along both, which stay about the same however far a limb has swung (Zhang and others
/// [zhang2008deformation]; the mean of lengths: Hilaga and others [hilaga2001topology]).

#include <array>
#include <vector>

#include "mq/mesh/mesh.h"

namespace mq {

/// The ends of a surface, such as hands and feet: where the mean length of paths to all other points
/// is larger than around, by a part of what it is on the whole. Those that stand out most come first.
struct Extremities {
  std::vector<int> vertices;
  std::vector<double> means;                 ///< of lengths to all other points
  std::vector<std::vector<double>> lengths;  ///< from each to all vertices, as `PathLengths` finds them
};
inline constexpr int most_extremities = 8;
Extremities extremities(const Mesh& mesh, int most = most_extremities);

/// Pairs of extremities that may be the same, of two surfaces.
struct MatchedExtremities {
  std::vector<std::array<int, 2>> pairs;
  double score = 0;  ///< how many pairs of pairs are as far apart on both, and how exactly
};

/// The best ways to match extremities, best first: those are matched whose lengths to each other are
/// alike. `moves` says how far an extremity of the first would have to move to one of the second, in
/// diagonals, which tells apart what is alike in all else.
std::vector<MatchedExtremities> matched_extremities(const Extremities& first, const Extremities& second,
                                                    const std::vector<std::vector<double>>& moves,
                                                    int most);

}  // namespace mq

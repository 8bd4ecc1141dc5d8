#pragma once
/// Which copy of a texel a picture shows, where charts that share texels are laid apart.

#include <tuple>

#include "mq/atlas/separate_overlaps.h"
#include "mq/fem/texels.h"

namespace mq {

/// The texel of the pictures whose copy a texel of the larger textures is, and how it ranks among its copies.
struct CopyRank {
  enum class Lies { covered, inside, beside } lies = Lies::inside;  ///< a chart covers the centre; beside: the picture
  int turn = 0;        ///< of its chart, of those that cover the centre
  double mass = 0;
  Texels::Place at;    ///< in the larger textures
  Texels::Place home;  ///< in the pictures

  CopyRank() = default;
  CopyRank(const SeparatedAtlas& apart, const Texels::Place& place, int covering, int chart, double its_mass)
      : turn(chart < 0 ? int(apart.atlas.charts.size()) : apart.atlas.charts[std::size_t(chart)].turn),
        mass(its_mass),
        at(place) {
    const SeparatedAtlas::Home found = apart.home(place.texture, place.x, place.y);
    home = {place.texture, found.x, found.y};
    lies = !found.inside ? Lies::beside : covering >= 0 ? Lies::covered : Lies::inside;
  }

  /// The first of the copies of a texel is shown; all that lie covered are meant, or else the first.
  bool comes_before(const CopyRank& other) const {
    if (lies != other.lies) return lies < other.lies;
    if (lies == Lies::covered && turn != other.turn) return turn < other.turn;
    if (mass != other.mass) return mass > other.mass;
    return std::tie(at.texture, at.y, at.x) < std::tie(other.at.texture, other.at.y, other.at.x);
  }
};

}  // namespace mq

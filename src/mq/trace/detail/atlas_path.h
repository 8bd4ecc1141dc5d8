#pragma once
/// A path over the cells of an atlas (`AtlasFlow`): the automaton of walk.h, and what it does where charts end.

#include "mq/trace/atlas_flow.h"
#include "mq/trace/detail/walk.h"

namespace mq::walk {

struct AtlasPath : Path {
  int chart = -1;
  HalfEdge border = -1;  ///< the one it is on, −1: it is in a cell, and `Path` says where
  double s = 0;          ///< where on it, 0 to 1 from its source
  int direction = 0;     ///< which way it came along, ±1; 0: it came from a side
  bool entered = false;  ///< it came from a border to a node that lies on it
  int meetings = 0;      ///< how often it came to a border from a side
};

/// A path that comes to borders so often goes round at one, as P steps there, and is at its end.
inline constexpr int most_meetings = 1000;

/// A path that begins at a place; nowhere is where it stays.
void put_at(const AtlasFlow& flow, AtlasPath& path, const ChartPlace& place);

/// Where it is.
ChartPlace place_of(const AtlasFlow& flow, const AtlasPath& path);

/// Goes on to the next edge, node, border, or change on a border. False when the path is at its end.
bool advance(const AtlasFlow& flow, AtlasPath& path, PathCounts& counts);

/// As for any path, on borders too.
bool leave_turns_out(AtlasPath& path, AtlasPath& mark);

}  // namespace mq::walk

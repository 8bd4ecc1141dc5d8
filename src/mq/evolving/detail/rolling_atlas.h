#pragma once
/// An atlas that is made segment by segment, of what is known by then.

#include <memory>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "mq/base/progress.h"
#include "mq/base/stopwatch.h"
#include "mq/evolving/detail/filled_hole.h"
#include "mq/evolving/lifespan_atlas.h"

namespace mq {

/// What `lay_out` makes its atlas with, which says how.
class RollingAtlas {
 public:
  /// All must live as long.
  RollingAtlas(EvolvingMesh& film, const std::vector<Period>& periods,
               const LifespanAtlasOptions& options);
  ~RollingAtlas();

  /// Gives the segment of the next period texture coordinates.
  void add_period(const Progress& progress);

  int plans() const { return plans_; }
  int edits() const { return edits_; }
  const std::vector<int>& cleared() const { return cleared_; }
  const std::vector<UnwrapFigures::Seconds>& seconds() const { return seconds_; }

  /// The charts planned last.
  const LifespanCharts& planned() const;

  /// Connected pieces that the texture has in each period.
  const std::vector<int>& pieces_of_period() const { return pieces_of_period_; }

  /// Charts in the texture, of the periods so far.
  std::vector<AtlasPrism> prisms() const;

  /// What was laid flat together, and which triangles it lost when.
  struct Lived {
    int first = 0;                     ///< period, of all of its triangles
    std::vector<int> triangles, last;  ///< and per triangle the last period
  };
  std::vector<Lived> lived() const;

 private:
  struct Plan;

  /// A flat chart with its place.
  struct Piece {
    int chart = 0;  ///< number of the planned chart, of which this may be a part
    int body = 0;   ///< number of what was laid flat together: all of the chart, or a half
    int first = 0;  ///< period
    double scale = 0;
    std::vector<int> ids = {};
    std::vector<Triangle> vertex_ids = {},
                          corners = {};  ///< per triangle; corners are indices into uvs
    std::vector<double> areas = {};      ///< per triangle, at scale 1
    /// Per triangle, the periods it was there in; none where it was moved again before it was shown.
    std::vector<int> since = {}, last = {};
    std::vector<Vector2> uvs = {};
  };

  /// Where a triangle is.
  struct Home {
    int piece, index;
  };

  enum class Past { goes_on, forgotten };

  /// Triangles that have a place in the texture, in texels from the lower left corner.
  struct Taken {
    std::vector<std::vector<Vector2>> polygons;
    std::vector<int> pieces;  ///< per polygon; −1: of none yet
  };

  /// Edges along which triangles end at a piece, and that hang together in its texture.
  struct Shore {
    int piece = -1;
    double length = 0;
    std::vector<HalfEdge> edges = {};  ///< of the triangles
    std::unordered_map<int, int> uv_of = {};  ///< of the piece, by vertex of the segment; −1: there are two
  };

  /// Triangles laid beside a piece.
  struct Extended;

  /// How much a piece had before something was added to it.
  struct Before {
    int piece;
    std::size_t triangles, uvs;
  };

  void plan_whole(const Progress& progress);
  void plan_now(Past past, const Progress& progress);
  NeighbourGraph without_large(const NeighbourGraph& graph) const;
  std::vector<double> expected_lives(const NeighbourGraph& graph, int known);
  void set_plan(std::unique_ptr<Plan> plan);
  void pack_all(const Progress& progress);
  std::optional<std::vector<int>> leave(const std::vector<int>& ids, std::size_t since, Taken& taken) const;
  bool place_new(const Progress& progress);
  std::vector<std::pair<int, std::vector<int>>> refill(const std::vector<int>& charts, Taken& taken);
  struct HoleBorder {
    int piece = -1, edges = 0;
    std::unordered_map<int, int> uv_of = {};  ///< of the piece, by vertex of the segment
  };
  std::optional<HoleBorder> border_of(const std::vector<int>& triangles,
                                      const std::vector<HalfEdge>& twins) const;
  HolePatch patch_of(const std::vector<int>& triangles, const HoleBorder& border,
                     std::vector<int>& vertices) const;
  bool refill_hole(const std::vector<int>& triangles, const std::vector<HalfEdge>& twins, Taken& taken);
  std::vector<HalfEdge> twins() const;
  void extend_pieces();
  void absorb_small(const std::vector<HalfEdge>& twins);
  std::vector<int> with_rings(const std::vector<int>& part, int rings) const;
  bool move_in(const std::vector<int>& part, const std::vector<HalfEdge>& twins);
  bool take_in(const std::vector<int>& part, const std::vector<HalfEdge>& twins, Taken& taken);
  std::vector<Shore> shores_of(const std::vector<int>& triangles, const std::vector<HalfEdge>& twins) const;
  Extended extended(const std::vector<int>& triangles, const Shore& shore, const Taken& taken) const;
  bool extend_whole(const std::vector<int>& part, const std::vector<HalfEdge>& twins, Taken& taken);
  std::vector<int> extend_split(const std::vector<int>& part, const std::vector<HalfEdge>& twins, Taken& taken);
  void put(const Extended& extended, Taken& taken);
  void add_triangle(int piece, int triangle, const Triangle& uvs, std::vector<Vector2> laid, Taken& taken);
  void take_back(const std::vector<Before>& before);
  void settle();
  void write();
  std::vector<int> new_charts() const;
  Taken taken_without(const std::unordered_set<int>& ids) const;
  Taken taken_without_new() const;
  void lap(const char* step);

  EvolvingMesh& film_;
  const std::vector<Period>& periods_;
  const LifespanAtlasOptions& options_;
  bool knows_all_;  ///< from the first frame on
  UnitGrid grid_;
  std::unique_ptr<Plan> plan_;
  int now_ = -1;      ///< the period that is being added
  std::vector<Vector3> positions_;  ///< of its first frame, on the grid
  double scale_ = 0;  ///< texels per unit of the grid
  int charts_ = 0, bodies_ = 0, plans_ = 0, edits_ = 0;
  std::vector<int> cleared_, pieces_of_period_;
  std::unordered_map<int, Lifespan> lives_;  ///< of triangles by id, as far as they are known
  std::vector<Piece> pieces_;
  std::unordered_map<int, Home> homes_;  ///< of triangles of the last period, by id
  Stopwatch watch_;
  double before_ = 0;
  std::vector<UnwrapFigures::Seconds> seconds_ = {{"chart", 0}, {"flatten", 0}, {"pack", 0}};
};

}  // namespace mq

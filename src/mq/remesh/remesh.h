#pragma once
/// Local remeshing: a template is replaced by its target where, and only where, it deviates from it
/// beyond tolerance (thesis 6.3.2; [wojtan2009deforming, bojsenhansen2012tracking]).

#include <array>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "mq/base/progress.h"
#include "mq/mesh/closest_point.h"
#include "mq/mesh/surface.h"

namespace mq {

/// Per triangle its corners: a rest shape.
std::vector<std::array<Vector3, 3>> corner_positions(const Mesh& mesh);

struct RemeshOptions {
  double tolerance = 0;  ///< distance from which on flat, open surface the template does not show
                         ///< the target, model units; 0: two mean edges of the finer surface
  double accuracy = 0;   ///< the same for seeds alone, where the region around them is to stay as
                         ///< wide as `tolerance` says; 0: the tolerance
  double farthest = 0;  ///< distance from which a vertex is a seed wherever it is; 0: there is none
  double keep = 0.5;    ///< 0 to 1: neighbours of what is replaced go too from this score on
  double occlusion = 0.75;  ///< 0 to 1: how much less counts what cannot be seen
  double curvature = 2;     ///< from 0: how much more counts what is bent
  double growth = 0.25;     ///< share of a component that may go beyond what has to; else all goes
  /// Per triangle of the template its corners at rest: those distorted since are replaced
  /// where they are. Empty: not asked.
  std::span<const std::array<Vector3, 3>> rest = {};
  /// Per triangle of the template 1 where it is to be replaced where it is, besides. Empty: none.
  std::span<const char> retriangulated = {};
  /// Per vertex of either surface 1 where nothing is to begin, however far it is from the other one.
  /// Empty: wherever it is far.
  std::span<const char> left_of_template = {}, left_of_target = {};
  /// What becomes of a change that takes more than `growth` of its component.
  enum class Outgrown {
    replaced,  ///< the component goes as a whole
    left       ///< the change is not made, nor what is within two tolerances of it
  } outgrown = Outgrown::replaced;
};

/// How far vertices of one surface are from another, model units.
struct DistanceSummary {
  double mean = 0, p95 = 0, max = 0;
};

/// Where a vertex of the result lies in the surface it came from.
struct VertexOrigin : SurfacePoint {
  char of_target = 0;  ///< 1: the target, 0: the template
};

struct Remeshed {
  Mesh mesh;  ///< positions and triangles: first those of the template that are kept, in its order
  std::vector<int> template_triangles;  ///< per triangle that of the template, −1: added
  std::vector<int> target_triangles;  ///< per triangle that of the target, −1: another or changed
  std::vector<int> template_vertices;  ///< per vertex that of the template, bit for bit, or −1
  std::vector<int> target_vertices;    ///< per vertex that of the target it came from, or −1
  std::vector<VertexOrigin> origins;   ///< per vertex; for values that are to be carried over

  int kept = 0;            ///< triangles of the template that are in the result
  int removed = 0;         ///< those that are not
  int added = 0;           ///< triangles of the result that are not the template's
  int template_seeds = 0;  ///< vertices with a score above 1
  int target_seeds = 0;
  int distorted = 0;  ///< triangles of the template that went for their rest shape
  int reached = 0;    ///< triangles of the template that the region reached before it grew
  int regions = 0;    ///< connected parts of what was added
  int replaced_components = 0;                          ///< of the template, whole
  int left_outgrown = 0;                                ///< vertices of changes not made for that
  int rounds = 0;                                       ///< until all curves had partners
  double tolerance = 0;                                 ///< the one used, model units
  DistanceSummary to_target;                            ///< of the result's vertices to the target
  DistanceSummary from_target;                          ///< of the target's vertices to the result
  std::vector<std::pair<std::string, double>> seconds;  ///< per step
};

/// Replaces parts of the template by parts of the target.
///
/// 1. Seeds are the vertices of either surface whose mismatch (remesh_score.h) is above 1; their
///    neighbours join them while theirs is above `keep`.
/// 2. The region is what is nearer to them than the tolerance. The template's triangles that reach
///    into it go, the target's that lie inside it come. Triangles with edges far longer than the
///    tolerance are cut first where the region ends.
/// 3. Where the curves along which both now end do not go together one to one, or a strip between
///    two of them would be flipped, the region grows there, and 2 is done again. Where that
///    takes more than `growth` of a component beyond its seeds, the component is replaced by what
///    corresponds to it.
/// 4. Strips of triangles close the gaps (zip_curves.h); around them, and only on the target's
///    side, short edges go, edges are flipped and vertices move a little.
/// 5. What of the template is kept, but distorted against its rest shape, shows the target and only
/// has the
///    wrong triangles: it is triangulated anew where it is (remesh_renewal.h).
///
/// The result is manifold where both surfaces are, whatever their topologies. Boundaries stay
/// boundaries. Triangles of the template that are kept have their vertices bit for bit. Where no
/// vertex is a seed and no triangle distorted the result is the template. Same bits for any number
/// of threads. Throws `InvalidInput` where one of the two has no triangles, where they are turned
/// inside out against each other, and where options are out of range.
Remeshed remesh(const Surface& of_template, const Surface& target,
                const RemeshOptions& options = {}, const Progress& progress = {});

/// A surface and what finds the closest points of its mesh; all must stay.
struct SearchedSurface {
  const Surface& surface;
  const ClosestPointFinder& closest;
  /// Of its vertices, on the other surface, where that is known; empty: they are looked for.
  std::span<const ClosestPoint> places = {};
};

/// The same, bit for bit, for whoever has the finders already: setting them up is a good part of a
/// call that changes little.
Remeshed remesh(const SearchedSurface& of_template, const SearchedSurface& target,
                const RemeshOptions& options = {}, const Progress& progress = {});

/// Per vertex of either surface 1 where the other does not show it: what `remesh` begins with.
struct RemeshSeeds {
  std::vector<char> of_template, of_target;
  std::vector<ClosestPoint> on_template;  ///< of the target's vertices
};
RemeshSeeds remesh_seeds(const SearchedSurface& of_template, const SearchedSurface& target,
                         const RemeshOptions& options = {}, const Progress& progress = {});

/// The surface with other triangles where some are thin (a height of less than a thousandth of the
/// longest edge) or folded (`folded_triangles`), as far as edges that are flipped or collapsed and
/// vertices that move on it a little can help; the rest is kept, as `remesh` does.
Remeshed tidied(const Surface& surface, const Progress& progress = {});
Remeshed tidied(const SearchedSurface& surface, const Progress& progress = {});

}  // namespace mq

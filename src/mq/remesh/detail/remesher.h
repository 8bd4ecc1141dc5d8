#pragma once
/// One run of `remesh`: seeds, the region that grows from them, the cut and what closes it.

#include <optional>
#include <string>
#include <vector>

#include "mq/base/progress.h"
#include "mq/base/stopwatch.h"
#include "mq/remesh/detail/clip_surfaces.h"
#include "mq/remesh/detail/region.h"
#include "mq/remesh/detail/seam.h"
#include "mq/remesh/detail/zip_curves.h"
#include "mq/remesh/remesh.h"

namespace mq {

/// Its members are defined in several sources, by what they do. Options must have been checked, and
/// all arguments stay.
class Remesher {
 public:
  Remesher(const SearchedSurface& of_template, const SearchedSurface& target,
           const RemeshOptions& options)
      : template_(of_template.surface),
        target_(target.surface),
        options_(options),
        template_finder_(of_template.closest),
        target_finder_(target.closest),
        template_places_(of_template.places),
        target_places_(target.places) {}

  Remeshed run(const Progress& progress);

 private:
  /// How a vertex came into the region.
  enum class Mark : char { none, seed, grown };

  /// What goes and comes, and how the gap is closed.
  struct Cut {
    std::vector<char> kept;  ///< per triangle of the pair
    std::vector<Triangle> strips;
    std::vector<int> failed;  ///< vertices where it does not work
  };

  // remesher.cpp
  void find_seeds(const Progress& progress);
  void refuse_inside_out() const;
  void group_components();

  // remesher_region.cpp
  Cut grow(const Progress& progress);
  bool mark(const std::vector<int>& vertices, Mark how);
  std::vector<int> with_neighbours(const std::vector<int>& vertices) const;
  std::vector<char> groups_of(const std::vector<int>& vertices) const;
  void restart_region();
  bool template_stays() const;
  std::vector<char> outgrown_groups() const;
  void replace_outgrown();
  void leave_outgrown();
  void replace(const std::vector<char>& groups);
  std::vector<double> inside_area() const;

  // remesher_cut.cpp
  std::optional<Cut> attempt();
  bool leave_what_is_passed(Cut& cut, const std::vector<CutCurve>& curves,
                            const CurvePairs& found) const;
  bool reaches_too_far(const Triangle& t) const;
  void refuse_crossings(Cut& cut);
  bool crosses_itself_near(const Triangle& t);
  std::vector<int> uncovered(const Cut& cut) const;

  // remesher_result.cpp
  void finish(Cut& cut, const Progress& progress);
  std::vector<Vector3> offsets() const;
  std::int64_t count_crossings(const Seam& seam) const;
  std::vector<VertexOrigin> find_origins(const std::vector<Vector3>& positions) const;
  void put(const Seam& seam);
  void unfold_added();

  int group(int t) const {
    const int source = pair_.source_triangle[t];
    return pair_.triangle_of_target(t) ? target_group_[source] : template_group_[source];
  }
  void note(const std::string& step, const Stopwatch& watch) {
    result_.seconds.emplace_back(step, watch.seconds());
  }

  const Surface &template_, &target_;
  const RemeshOptions& options_;
  const ClosestPointFinder &template_finder_, &target_finder_;
  std::span<const ClosestPoint> template_places_, target_places_;  // empty: not known yet
  Remeshed result_;
  SurfacePair pair_;
  std::vector<ClosestPoint> on_target_, on_template_;  // of template's and target's vertices
  std::vector<double> scores_;
  std::vector<char> distorted_;  // per triangle of the template, or none at all
  std::vector<Mark> marked_;     // per vertex of the pair
  std::optional<MarkedRegion> region_;
  std::vector<int> template_group_, target_group_;  // per triangle
  std::vector<char> replaced_;                      // per group: as a whole
  std::vector<double> group_area_, first_inside_;   // per group
  std::optional<Mesh> self_crossings_;              // triangles of both surfaces, once asked for
  std::optional<ClosestPointFinder> near_self_crossings_;
  double reach_ = 0;  // between curves that go together
};

}  // namespace mq

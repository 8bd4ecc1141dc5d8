#pragma once
/// The two methods of `LiveGeodesic`. Used inside this room.

#include <functional>
#include <memory>
#include <vector>

#include "mq/fem/texel_hierarchy.h"
#include "mq/filter/live_geodesic.h"

namespace mq {

class LiveGeodesic::Way {
 public:
  virtual ~Way() = default;
  virtual void move(const std::vector<GeodesicSource>& sources) = 0;
  virtual LiveGeodesicStep step(const Progress& progress) = 0;
  virtual bool rests() const = 0;
  const Vector& distance() const { return distance_; }

 protected:
  Vector distance_;
};

/// A space and the levels of its matrices.
struct LiveGeodesicSpace {
  const SignalSpace& space;
  std::function<Hierarchy(const SparseMatrix& A, const Progress& progress)> levels;
};

std::unique_ptr<LiveGeodesic::Way> published_way(const LiveGeodesicSpace& space, const LiveGeodesicOptions& options,
                                                 const Progress& progress);
std::unique_ptr<LiveGeodesic::Way> progressive_way(const LiveGeodesicSpace& space,
                                                   const LiveGeodesicOptions& options, const Progress& progress);

/// A·x = b for one channel by cycles in single precision, from where x is.
class GuessedCycles {
 public:
  explicit GuessedCycles(Hierarchy hierarchy);

  void set_right_hand_side(const Vector& b);
  void set_guess(const Vector& x);

  /// x += C·(b − A·x). Returns by how much x changed at most.
  double cycle();

  double x(std::int64_t i) const { return hierarchy_.scaling().row(i) * double(x_.data()[i]); }
  const Hierarchy& hierarchy() const { return hierarchy_; }

 private:
  Hierarchy hierarchy_;
  Multigrid::Workspace workspace_;
  LaneVector b_, x_, r_, z_;
};

}  // namespace mq

#pragma once
/// Where what a frame of a texture video shows was in the frame before: tracked surfaces slide under what they show.

#include <array>
#include <memory>
#include <vector>

#include "mq/flow/surface_optical_flow.h"
#include "mq/trace/trace_atlas.h"

namespace mq {

/// How `FrameDrift::follow` aligns two frames that follow each other: motions of up to 16 texels.
MeshFlowOptions drift_flow();

/// Places of one frame in its atlas, and how they go on to the frame before and back. Nothing slides until `follow`.
///
/// 29 bytes per texel of the texture, 24 per unknown, and 16 per texel of the texture once something slides.
class FrameDrift {
 public:
  /// `frame` owns the others, and stays as long as this does.
  FrameDrift(std::shared_ptr<const void> frame, const Surface& surface, const Atlas& atlas, const TexelSpace& space);

  /// How far unknowns slid on average, in texels, and what share of the squared difference of both frames (that of
  /// `MeshFlow`) is gone along it: 0 and nothing slides where no field brings them nearer to each other.
  struct Fit {
    double texels = 0, explained = 0;
  };

  /// Finds the field X along which both meet, each half-way, by optical flow in the texture (`TextureFlow`): signals of
  /// the unknowns of this frame's space. Throws what that throws.
  Fit follow(const Signal& before, const Signal& now, const MeshFlowOptions& options = drift_flow(),
             const Progress& progress = {});

  /// The same with a field that `follow` has found, per cell of the grid.
  void follow(std::vector<std::array<double, 2>> field) { field_ = std::move(field); }
  const std::vector<std::array<double, 2>>& field() const { return field_; }

  /// Whether the atlas is the one of the frame before, and something was followed.
  bool follows() const { return !field_.empty(); }

  /// Where places of this frame were in the frame before, Φ₋ₓ(p, 1), and the other way round, Φₓ(p, 1). Places without
  /// a chart stay.
  std::vector<ChartPlace> before(const std::vector<ChartPlace>& places) const { return followed(places, -1); }
  std::vector<ChartPlace> after(const std::vector<ChartPlace>& places) const { return followed(places, 1); }

  /// Of points that are at the unknowns' starts half-way between both frames, where they were in the frame before and
  /// where they are in this one.
  struct HalfWay {
    std::vector<ChartPlace> before, now;
  };
  HalfWay half_way() const { return {followed(starts_, -0.5), followed(starts_, 0.5)}; }

  /// Where unknowns are: at their texels, or beside them where these lie outside their chart.
  const std::vector<ChartPlace>& starts() const { return starts_; }

  /// In texels of the picture.
  Vector2 texel(const ChartPlace& place) const { return domain_.texel(place); }
  /// As far from an unknown's start as this; without a chart where none is.
  ChartPlace beside(int unknown, const Vector2& texels) const;

  /// By how much a signal differs there from where an unknown is. 0 at its start, bit for bit.
  Eigen::RowVectorXd change(const Signal& signal, int unknown, const ChartPlace& at) const;

 private:
  std::vector<ChartPlace> followed(const std::vector<ChartPlace>& places, double time) const;

  std::shared_ptr<const void> frame_;
  const Surface* surface_;
  const Atlas* atlas_;
  const TexelSpace* space_;
  TraceAtlas domain_;
  std::vector<ChartPlace> starts_;
  std::vector<std::array<double, 2>> field_;  ///< per cell of the grid
};

}  // namespace mq

#include "mq/video/frame_drift.h"

#include <cmath>

#include "mq/base/parallel.h"
#include "mq/flow/texture_flow.h"
#include "mq/trace/atlas_flow.h"

namespace mq {

MeshFlowOptions drift_flow() {
  MeshFlowOptions options;
  options.largest = {8, Length::Unit::texels};
  return options;
}

FrameDrift::FrameDrift(std::shared_ptr<const void> frame, const Surface& surface, const Atlas& atlas,
                       const TexelSpace& space)
    : frame_(std::move(frame)),
      surface_(&surface),
      atlas_(&atlas),
      space_(&space),
      domain_(surface, atlas, space),
      starts_(domain_.starts().places) {}

FrameDrift::Fit FrameDrift::follow(const Signal& before, const Signal& now, const MeshFlowOptions& options,
                                   const Progress& progress) {
  const TextureFlow found(*surface_, *atlas_, *space_, before, now, options, progress);
  field_ = found.velocities();
  const MeshFlow& flow = found.flow();
  const Eigen::Map<const Eigen::Matrix2Xd> vectors(flow.field.data(), 2, flow.field.size() / 2);
  const double blend = flow.blend_error, error = flow.errors().back();
  return {.texels = vectors.colwise().norm().mean() / space_->scale().texel_spacing,
          .explained = blend > 0 ? 1 - error / blend : 0};
}

std::vector<ChartPlace> FrameDrift::followed(const std::vector<ChartPlace>& places, double time) const {
  if (field_.empty()) return places;
  std::vector<std::array<double, 2>> field = field_;
  const double sign = time < 0 ? -1 : 1;
  for (auto& [x, y] : field) x *= sign, y *= sign;
  std::vector<ChartPlace> ends = AtlasFlow::along(domain_, field).trace(places, std::abs(time)).ends;
  for (std::size_t i = 0; i < places.size(); ++i)
    if (places[i].chart < 0 || ends[i].chart < 0) ends[i] = places[i];
  return ends;
}

ChartPlace FrameDrift::beside(int unknown, const Vector2& texels) const {
  const ChartPlace& start = starts_[std::size_t(unknown)];
  if (start.chart < 0) return {};
  if (texels.isZero(0)) return start;
  const ChartPlace place = domain_.place(start.chart, domain_.texture(start.cell), domain_.texel(start) + texels);
  return domain_.covered(place.cell) ? place : ChartPlace{};
}

Eigen::RowVectorXd FrameDrift::change(const Signal& signal, int unknown, const ChartPlace& at) const {
  const ChartPlace& start = starts_[std::size_t(unknown)];
  if (at == start || at.chart < 0 || start.chart < 0) return Eigen::RowVectorXd::Zero(signal.cols());
  Signal values(2, signal.cols());
  domain_.sharp_value(signal, at, values.row(0));
  domain_.sharp_value(signal, start, values.row(1));
  return values.row(0) - values.row(1);
}

}  // namespace mq

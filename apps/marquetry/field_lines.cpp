#include "field_lines.h"

#include "mq/fem/field_metric.h"

namespace mq::app {

std::unique_ptr<SignalSpace> space_across(const Scene& scene, const Domain& domain,
                                          const TangentField& field, double kappa,
                                          const Progress& progress) {
  if (dynamic_cast<const TexelDomain*>(&domain)) {
    TexelSpaceOptions options;
    options.metrics = texel_metrics_across(scene.surface, *scene.atlas, field, kappa);
    return std::make_unique<TexelSpace>(scene.surface, *scene.atlas, options, progress);
  }
  return std::make_unique<VertexSpace>(scene.surface, shapes_across(scene.surface, field, kappa));
}

}  // namespace mq::app

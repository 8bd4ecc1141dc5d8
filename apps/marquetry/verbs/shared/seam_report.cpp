#include "verbs/shared/seam_report.h"

#include "mq/model/model_paints.h"

namespace mq::app {

Json seams_json(const TexturedModel& scene) { return seams_json(scene, scene.model.textures); }

Json seams_json(const TexturedModel& scene, const std::vector<Texture>& textures) {
  const SeamDifference seams = texture_seams(scene, textures);
  return {{"rms", seams.rms}, {"p99", seams.difference_p99}, {"largest", seams.worst.difference}};
}

}  // namespace mq::app

#include "verbs/shared/seam_report.h"

#include "mq/draw/seam_difference.h"

namespace mq::app {

Json seams_json(const TexturedModel& scene) {
  std::vector<const Image<float>*> pictures;
  for (const Texture& texture : scene.model.textures) pictures.push_back(&texture.pixels);
  const SeamDifference seams = seam_difference(scene.surface, *scene.atlas, pictures);
  return {{"rms", seams.rms}, {"p99", seams.difference_p99}, {"largest", seams.worst.difference}};
}

}  // namespace mq::app

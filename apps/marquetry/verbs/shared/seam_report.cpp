#include "verbs/shared/seam_report.h"

#include "mq/model/model_paints.h"

namespace mq::app {

namespace {

Json difference_json(const SeamDifference& seams) {
  return {{"rms", seams.rms}, {"p99", seams.difference_p99}, {"largest", seams.worst.difference}};
}

}  // namespace

Json seams_json(const TexturedModel& scene) { return seams_json(scene, scene.model.textures); }

Json seams_json(const TexturedModel& scene, const std::vector<Texture>& textures) {
  return difference_json(texture_seams(scene, textures));
}

Json seams_json(const TexturedModel& scene, const TextureSignal& signal) {
  return seams_json(scene, signal.shading_frames());
}

Json seams_json(const TexturedModel& scene, const ShadingFrames* frames) {
  return frames ? difference_json(texture_seams(scene, *frames)) : seams_json(scene);
}

}  // namespace mq::app

#pragma once
/// A sample with about as many texels as one asks for.

#include <cmath>
#include <memory>
#include <string>

#include "mq/fem/texel_space.h"
#include "mq/sample/sample.h"

namespace mq {

struct SampleSpace {
  Sample sample;
  Surface surface;
  Atlas atlas;
  std::unique_ptr<TexelSpace> space;
};

inline std::unique_ptr<SampleSpace> make_sample_space(const std::string& name, double wanted_texels) {
  double size = 1024;
  for (int round = 0;; ++round) {
    auto model = std::make_unique<SampleSpace>();
    model->sample = make_sample(name, {.texture_size = int(size)});
    model->surface = make_surface(model->sample.mesh);
    model->atlas = make_atlas(model->surface, {model->sample.texture});
    model->space = std::make_unique<TexelSpace>(model->surface, model->atlas);
    if (round == 1) return model;
    size *= std::sqrt(wanted_texels / model->space->size());
  }
}

}  // namespace mq
